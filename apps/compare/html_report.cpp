#include <algorithm>
#include <span>
#include <utility>

#include "sightline/apps/common/change_colours.h"
#include "sightline/apps/common/html_page.h"
#include "sightline/apps/common/numbers.h"
#include "sightline/apps/compare/reports.h"

namespace sightline::apps {
namespace {

using compare::Group;
using compare::State;
using compare::Way;

constexpr core::vec3 kFaint(0.85f);  // of what the viewer leaves faint

Badge badge_of(State state) {
  return {std::string(compare::name_of(state)), change_colour(state).value_or(kFaint)};
}

Badge badge_of(Way way) {
  for (const State state : {State::kAdded, State::kRemoved, State::kMoved, State::kChanged})
    if (compare::name_of(state) == compare::name_of(way)) return badge_of(state);
  return {std::string(compare::name_of(way)), kFaint};
}

std::string count_text(std::size_t count) {
  return grouped(std::int64_t(count));
}

/// A path from below the group's node on.
std::string below(const std::string& group, const std::string& path) {
  if (path.size() > group.size() + 1 && path.starts_with(group) && path[group.size()] == '/')
    return path.substr(group.size() + 1);
  return path;
}

std::string lines(const std::vector<FactChange>& facts, std::string FactChange::*side) {
  std::string text;
  for (const FactChange& fact : facts) text += (text.empty() ? "" : "; ") + fact.name + ": " + fact.*side;
  return text;
}

using Table = std::vector<std::vector<std::string>>;

/// The columns beside the name of a member tell of what the group has not told.
std::vector<std::string> head_of(Way way) {
  switch (way) {
    case Way::kShape:
    case Way::kMaterial:
    case Way::kAttributes:
      return {"item", "kind", "before", "after"};
    case Way::kNodeAttributes:
      return {"node", "before", "after"};
    case Way::kRenamed:
      return {"item", "kind", "formerly"};
    case Way::kAdded:
    case Way::kRemoved:
    case Way::kMoved:
      break;
  }
  return {"item", "kind"};
}

std::vector<std::string> row_of(const Compared& c, const Group& group, const std::string& path, std::size_t i) {
  if (group.way == Way::kNodeAttributes) {
    const compare::NodeChange& node = c.found.nodes[c.groups.members[group.begin + i]];
    const std::vector<FactChange> facts = facts_of(c, node);
    return {below(path, c.after.scene->path(node.after)), lines(facts, &FactChange::before),
            lines(facts, &FactChange::after)};
  }
  const compare::Change& change = c.item(group, i);
  std::vector<std::string> row = {below(path, path_of(c, change)), std::string(core::name_of(kind_of(c, change)))};
  const std::size_t columns = head_of(group.way).size();
  if (columns == 4) {
    const std::vector<FactChange> facts = facts_of(c, change);
    row.push_back(lines(facts, &FactChange::before));
    row.push_back(lines(facts, &FactChange::after));
  }
  if (columns == 3) row.push_back(path_before(c, change));
  return row;
}

void add_images(const GroupImage& images, HtmlBody& body) {
  std::vector<LabelledPng> pair;
  for (const auto& [label, png] : {std::pair("before", &images.before), std::pair("after", &images.after)})
    if (!png->empty()) pair.push_back({label, *png});
  if (!pair.empty()) body.images(pair, {"What has changed is coloured, all else is faint.", ""});
}

void add_group(const Compared& c, const Group& group, const GroupImage& images, HtmlBody& body) {
  const std::string path = path_of(c, group);
  const auto members = rows_of(group, kMostPageRows, [&](std::size_t i) { return row_of(c, group, path, i); });
  Table rows;
  for (const auto& [row, count] : members.rows) {
    rows.push_back(row);
    if (count > 1) rows.back()[0] += " \u00d7 " + count_text(count);
  }
  std::string caption = "Below " + path + ".";
  if (members.left_out > 0) caption += " " + count_text(members.left_out) + " more are left out.";
  HtmlBody inside;
  add_images(images, inside);
  inside.text_table(head_of(group.way), rows, {caption, ""});
  body.details(badge_of(group.way), path + ": " + what_of(c, group), inside);
}

struct Chapter {
  std::string id, title;
  std::vector<Way> ways;
};

/// The groups of some ways of changing, the largest ones first; nothing where there are none.
void add_chapter(const Compared& c, std::span<const GroupImage> images, const Chapter& chapter,
                 std::vector<PageSection>& sections) {
  HtmlBody body;
  std::size_t groups = 0;
  for (std::size_t i = 0; i < c.groups.all.size(); ++i) {
    const Group& group = c.groups.all[i];
    if (std::find(chapter.ways.begin(), chapter.ways.end(), group.way) == chapter.ways.end()) continue;
    if (groups++ < kMostPageGroups) add_group(c, group, i < images.size() ? images[i] : GroupImage(), body);
  }
  if (groups == 0) return;
  if (groups > kMostPageGroups)
    body.paragraph("These are the " + count_text(kMostPageGroups) + " largest of " + count_text(groups) +
                   " groups. --csv FILE lists all items.");
  const std::string headline = groups == 1 ? "1 group" : count_text(groups) + " groups";
  sections.push_back({chapter.id, chapter.title, headline, body.text()});
}

PageSection summary(const Compared& c) {
  Table rows;
  std::vector<Badge> badges;
  for (const State state : {State::kAdded, State::kRemoved, State::kMoved, State::kChanged, State::kUnchanged}) {
    rows.push_back({"", count_text(c.found.count(state))});
    badges.push_back(badge_of(state));
  }
  HtmlBody body;
  body.table({"state", "items"}, rows, {"Each item counts once. An item that has moved and changed is changed.", ""},
             badges);
  if (c.found.renamed > 0) body.paragraph(count_text(c.found.renamed) + " items are renamed, or below other nodes.");
  if (!c.found.with_attributes) body.paragraph("Attributes are not compared: one revision has none.");
  if (!c.found.nodes.empty())
    body.paragraph(count_text(c.found.nodes.size()) + " nodes without items have other attributes.");
  return {"summary", "Summary", c.found.same() ? "nothing but names has changed" : "", body.text()};
}

}  // namespace

std::string html_report(const Compared& c, std::span<const GroupImage> images) {
  const std::vector<Chapter> chapters = {
      {"added", "Added", {Way::kAdded}},
      {"removed", "Removed", {Way::kRemoved}},
      {"moved", "Moved", {Way::kMoved}},
      {"changed", "Changed", {Way::kShape, Way::kMaterial, Way::kAttributes, Way::kNodeAttributes}},
      {"renamed", "Renamed", {Way::kRenamed}}};
  std::vector<PageSection> sections{summary(c)};
  for (const Chapter& chapter : chapters) add_chapter(c, images, chapter, sections);
  return html_page("What has changed",
                   {"From " + c.before_file + " to " + c.after_file + ".",
                    "Each line is a group of items that changed alike; click it to list them. An item that changed in "
                    "several ways is in several groups."},
                   sections);
}

}  // namespace sightline::apps
