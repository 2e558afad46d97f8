// What sightline-compare writes of a comparison.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sightline/apps/compare/compared.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

/// PNG of a group as it was and as it is; empty where there is none.
struct GroupImage {
  std::vector<std::uint8_t> before, after;
};
/// Images of the largest groups, in their order, as far as there are; at most so many.
inline constexpr std::size_t kMostImages = 50;

/// Counts, and at most so many groups, one a line.
std::string text_report(const Compared& compared, std::size_t most);

/// Counts, groups, and all items and nodes that differ.
json::Value json_report(const Compared& compared);

/// A line of names, then one for each item and node that differs, as in RFC 4180.
std::string csv_report(const Compared& compared);

/// An HTML page that holds all it shows, in the viewer's colours. It lists at most so many groups of each way of
/// changing, and of each group at most so many rows of items; it says what it leaves out. The largest groups have
/// images, where there are any to give.
std::string html_report(const Compared& compared, std::span<const GroupImage> images = {});
inline constexpr std::size_t kMostPageGroups = 1000, kMostPageRows = 200;

/// The bytes of a BCF archive with a topic for each group, the largest ones if there are more: a view of the group, in
/// which its items are selected, with what has become of it as title and text, and an image of it. Fails in builds
/// without BCF.
core::Expected<std::string> bcf_report(const Compared& compared, std::span<const GroupImage> images = {});
inline constexpr std::size_t kMostTopics = 100;

}  // namespace sightline::apps
