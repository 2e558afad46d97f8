#include <algorithm>
#include <cmath>

#include "sightline/apps/common/model.h"
#include "sightline/apps/common/numbers.h"
#include "sightline/apps/compare/reports.h"
#include "sightline/apps/viewpoints/bcf.h"

namespace sightline::apps {
namespace {

using compare::Group;
using compare::Way;

constexpr std::size_t kMostLines = 10;  // of items in a text

/// Where an item is, its kind, and what it had, or has, that the title does not tell.
std::pair<std::string, std::string> item_lines(const Compared& c, const Group& group, std::size_t i) {
  const compare::Change& change = c.item(group, i);
  const std::string item = path_of(c, change) + " (" + std::string(core::name_of(kind_of(c, change))) + ")";
  std::string text;
  if (group.way != Way::kShape && group.way != Way::kAttributes) return {item, text};
  for (const FactChange& fact : facts_of(c, change))
    text += "\n  " + fact.name + ": \"" + fact.before + "\" to \"" + fact.after + "\"";
  return {item, text};
}

std::string comment(const Compared& c, const Group& group, const std::string& about) {
  std::string text = about + ", from " + c.before_file + " to " + c.after_file + ".";
  if (group.way == Way::kNodeAttributes) return text;
  const auto lines = rows_of(group, kMostLines, [&](std::size_t i) { return item_lines(c, group, i); });
  for (const auto& [line, count] : lines.rows)
    text += "\n" + line.first + (count > 1 ? " \u00d7 " + grouped(std::int64_t(count)) : "") + line.second;
  if (lines.left_out > 0) text += "\nand " + grouped(std::int64_t(lines.left_out)) + " more items";
  return text;
}

Viewpoint topic(const Compared& c, const Group& group, const ItemNames& names) {
  Viewpoint view;
  const core::AabbD box = box_of(c, group, Revision::kNewer);
  view.fovy = kFovy;
  view.pose = core::fitting_pose(box, core::kOverviewDirection, view.fovy, kGroupAspect, kGroupFilled);
  view.near = 0.0;
  view.shown.emplace().selection = names.name(items_of(c, group, Revision::kNewer), false);
  const std::string what = ": " + what_of(c, group), about = path_of(c, group) + what;
  view.name = name_of(c, group) + what;
  view.comment = comment(c, group, about);
  view.author = author_name();
  view.date = date_now();
  view.guid = about;  // no GUID: format_bcf() makes one of it, the same one each time
  return view;
}

}  // namespace

core::Expected<std::string> bcf_report(const Compared& c, std::span<const GroupImage> images) {
  const ItemNames names(*c.after.scene);
  std::vector<Viewpoint> views;
  for (std::size_t i = 0; i < std::min(c.groups.all.size(), kMostTopics); ++i) {
    views.push_back(topic(c, c.groups.all[i], names));
    if (i < images.size()) views.back().snapshot = images[i].after.empty() ? images[i].before : images[i].after;
  }
  return format_bcf(views);
}

}  // namespace sightline::apps
