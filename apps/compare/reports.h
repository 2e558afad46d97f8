// What sightline-compare writes of a comparison.
#pragma once

#include <cstddef>
#include <string>

#include "sightline/apps/compare/compared.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

/// Counts, and at most so many groups, one a line.
std::string text_report(const Compared& compared, std::size_t most);

/// Counts, groups, and all items and nodes that differ.
json::Value json_report(const Compared& compared);

/// A line of names, then one for each item and node that differs, as in RFC 4180.
std::string csv_report(const Compared& compared);

/// An HTML page that holds all it shows, in the viewer's colours. It lists at most so many groups of each way of
/// changing, and of each group at most so many rows of items; it says what it leaves out.
std::string html_report(const Compared& compared);
inline constexpr std::size_t kMostPageGroups = 1000, kMostPageRows = 200;

/// The bytes of a BCF archive with a topic for each group, the largest ones if there are more: a view of the group, in
/// which its items are selected, with what has become of it as title and text. Fails in builds without BCF.
core::Expected<std::string> bcf_report(const Compared& compared);
inline constexpr std::size_t kMostTopics = 100;

}  // namespace sightline::apps
