// Search for items by several conditions.
//
// A query is conditions with " & " between them, all of which must hold. "!" before a condition stands for its
// opposite.
//
//   PART                   the item lies below a node that core/find_nodes.h finds for this text, such as "KEY=TEXT"
//   KEY==TEXT              its value (values.h) is TEXT, regardless of case; also !=. The text may have * for any
//                          characters and ? for one
//   KEY<NUMBER             its value begins with such a number; also <=, > and >=
//   @size>LENGTH           so with the longest side of its box; a length is in metres or ends in mm, cm, m, in or ft
//   @KEY=TEXT              as == for @kind, @material, @layer and @file
//   @near<=LENGTH of PART  it is not farther than that from the items of PART, to which it does not belong
//
// Blanks around keys, signs and values do not count.
#pragma once

#include <string_view>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"

namespace sightline::query {

/// Whether a text is a query of several conditions, or of one that is no PART. A text can be both the name of a part
/// and a query: tools take it for a name where a part has it.
SIGHTLINE_API bool is_query(std::string_view text);

/// Fails where find_items() fails for every scene.
SIGHTLINE_API core::Expected<void> check_query(std::string_view text);

/// The items for which the query holds, in rising order, hidden ones too; there may be none. Takes some 100 ns for
/// each node and attribute and each condition. Distances of "@near" are those of analysis/measure: exact, and where
/// one is known to lie within an interval that holds LENGTH, it counts as near. They are worked out for pairs of items
/// whose boxes are so near, after all other conditions.
///
/// Fails where a condition is none, where its PART or KEY occurs nowhere in the scene, and where "@near" would look at
/// more than 100 million pairs of boxes. The error names the condition.
SIGHTLINE_API core::Expected<std::vector<core::ItemId>> find_items(const core::Scene& scene, std::string_view text);

}  // namespace sightline::query
