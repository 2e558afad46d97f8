// Parts of a model that users name, by the rule of core/find_nodes.h, and what is said where a name is not clear.
#pragma once

#include <string>
#include <vector>

#include "sightline/core/find_nodes.h"

namespace sightline::apps {

/// A text that may name parts: not empty, and no regular expression that is none. For options, before a model is read.
core::Expected<std::string> parse_part(const std::string& text);

/// The nodes that fulfil all conditions. Fails where there are none, with names that are like the text.
core::Expected<core::FoundNodes> find_parts(const core::Scene& scene, const std::vector<core::NodeCondition>& wanted);

/// One line that counts parts, says what about them the text fits, and has the first few paths.
std::string words_of_parts(const core::Scene& scene, const std::string& text, const core::FoundNodes& found);

/// Nodes that any of the texts names. Fails where one names none. Where one names several, that is a line on stderr
/// unless `quiet`.
core::Expected<std::vector<core::NodeId>> named_nodes(const core::Scene& scene, const std::vector<std::string>& texts,
                                                      bool quiet);

/// By ItemId, whether an item lies below one of these nodes.
std::vector<bool> items_below(const core::Scene& scene, const std::vector<core::NodeId>& nodes);

}  // namespace sightline::apps
