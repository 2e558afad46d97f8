// Internal to the STL reader: the text form.
#pragma once

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <span>
#include <string_view>

#include "sightline/core/internal/ascii_case.h"
#include "sightline/importers/internal/import_job.h"

namespace sightline::importers::stl {

/// Keywords come in any case.
inline bool is(std::string_view word, std::string_view keyword) {
  if (word.size() != keyword.size()) return false;
  return word == keyword ||
         std::equal(word.begin(), word.end(), keyword.begin(), [](char a, char b) { return core::lower_case(a) == b; });
}
inline bool is_one_of(std::string_view word, std::initializer_list<std::string_view> keywords) {
  return std::any_of(keywords.begin(), keywords.end(), [&](std::string_view keyword) { return is(word, keyword); });
}

/// Adds an item for each solid. What counts are the vertices of each loop: where these are all there, other words may
/// be missing, misspelt or too many, with a counted warning for each kind. Damage is what leaves a facet in doubt: a
/// coordinate that is no number, a word within a loop that is not understood, an end of the file within a solid. When
/// lenient, reading goes on at the next facet.
core::Expected<void> read_text(ImportJob& job, std::span<const std::byte> bytes);

}  // namespace sightline::importers::stl
