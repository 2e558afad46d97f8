#include "sightline/apps/compare/compared.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>

#include "sightline/apps/common/html_page.h"
#include "sightline/apps/common/tree_walk.h"

namespace sightline::apps {
namespace {

using compare::Change;
using compare::Group;
using compare::Way;

constexpr double kLeastTurn = 1e-6;    // radians; less is not worth telling
constexpr double kAlongAxis = 1e-4;    // of a direction's length, which may be off an axis
constexpr std::size_t kMostNames = 5;  // of attributes in a sentence

core::MaterialId material_of(const core::Scene& scene, core::ItemId item) {
  return scene.material_at(scene.state(item).material);
}

std::string material_text(const core::Scene& scene, core::MaterialId id) {
  if (!id.valid()) return "none";
  const core::Material& material = scene.material(id);
  std::string text = material.name.empty() ? "" : material.name + " ";
  text += hex_of(material.colour);
  if (material.alpha < 1.0f) text += " " + std::to_string(std::lround(100.0f * material.alpha)) + " %";
  return text;
}

/// "+x", or none where a direction is along no axis.
std::string axis_name(const core::dvec3& direction) {
  const core::dvec3 part = glm::abs(direction) / glm::length(direction);
  for (int axis = 0; axis < 3; ++axis)
    if (part[axis] > 1.0 - kAlongAxis * kAlongAxis) return std::string(direction[axis] < 0 ? "-" : "+") + "xyz"[axis];
  return "";
}

std::string moved_text(const Compared& c, const Group& group) {
  const double distance = glm::length(group.offset);
  const std::string axis = axis_name(group.offset);
  std::string text = "moved by " + (c.lengths ? c.lengths->text(distance) : length_text(distance));
  text += axis.empty() ? " (" + (c.lengths ? c.lengths->text(group.offset) : vector_text(group.offset)) + ")"
                       : " along " + axis;
  if (!(group.turn > kLeastTurn)) return text;
  char turn[40];
  std::snprintf(turn, sizeof turn, "turned by %.3f° about ", glm::degrees(group.turn));
  const std::string about = axis_name(group.axis);
  const std::string turned = turn + (about.empty() ? "(" + vector_text(group.axis) + ")" : about);
  return distance < 1e-6 ? turned : text + ", " + turned;
}

/// Returns the text that all share, or none where they differ.
template <class Text>
std::string common_text(std::size_t count, const Text& text) {
  const std::string first = text(0);
  for (std::size_t i = 1; i < count; ++i)
    if (text(i) != first) return "";
  return first;
}

std::string shape_text(const Compared& c, const Group& group) {
  const Change& first = c.item(group, 0);
  const auto before = core::name_of(c.before.scene->kind(first.before)),
             after = core::name_of(c.after.scene->kind(first.after));
  if (before != after) return "changed from " + std::string(before) + " to " + std::string(after);
  return "changed in shape";
}

std::string recoloured_text(const Compared& c, const Group& group) {
  const std::string before = common_text(group.size(), [&](std::size_t i) {
    return material_text(*c.before.scene, material_of(*c.before.scene, c.item(group, i).before));
  });
  const std::string after = material_text(*c.after.scene, material_of(*c.after.scene, c.item(group, 0).after));
  return "changed in material" + (before.empty() ? "" : " from " + before) + " to " + after;
}

/// Names of attributes, and values where one alone has changed, and for all items alike.
std::string attributes_text(const Compared& c, const Group& group) {
  const auto facts = [&](std::size_t i) {
    const std::uint32_t index = c.groups.members[group.begin + i];
    if (group.way == Way::kNodeAttributes) return facts_of(c, c.found.nodes[index]);
    const Change& change = c.found.items[index];
    return differing(attribute_facts(*c.before.scene, c.before.scene->node_of(change.before)),
                     attribute_facts(*c.after.scene, c.after.scene->node_of(change.after)));
  };
  const std::vector<FactChange> first = facts(0);
  std::string text = first.size() == 1 ? "changed in attribute "
                     : first.empty()   ? "changed in attributes"
                                       : "changed in attributes ";
  for (std::size_t i = 0; i < std::min(first.size(), kMostNames); ++i) text += (i > 0 ? ", " : "") + first[i].name;
  if (first.size() > kMostNames) text += " and " + std::to_string(first.size() - kMostNames) + " more";
  if (first.size() != 1) return text;
  const std::string values = common_text(group.size(), [&](std::size_t i) {
    const std::vector<FactChange> own = facts(i);
    return own.empty() ? "" : " from \"" + own[0].before + "\" to \"" + own[0].after + "\"";
  });
  return text + values;
}

/// The node above the old place of an item that is as far above it as the group's node is above the new one.
std::string old_path(const Compared& c, const Group& group, const Change& change) {
  const core::Scene &before = *c.before.scene, &after = *c.after.scene;
  core::NodeId old = before.node_of(change.before);
  for (core::NodeId now = after.node_of(change.after); now != group.node && old != c.before.top;
       now = after.parent(now))
    old = before.parent(old);
  return before.path(old);
}

std::string renamed_text(const Compared& c, const Group& group) {
  const std::string first = old_path(c, group, c.item(group, 0));
  if (old_path(c, group, c.item(group, group.size() - 1)) == first && first != path_of(c, group))
    return "renamed, formerly " + first;
  return "renamed, or below other nodes than before";
}

std::string change_text(const Compared& c, const Group& group) {
  switch (group.way) {
    case Way::kAdded:
    case Way::kRemoved:
      return std::string(compare::name_of(group.way));
    case Way::kMoved:
      return moved_text(c, group);
    case Way::kShape:
      return shape_text(c, group);
    case Way::kMaterial:
      return recoloured_text(c, group);
    case Way::kAttributes:
    case Way::kNodeAttributes:
      return attributes_text(c, group);
    case Way::kRenamed:
      break;
  }
  return renamed_text(c, group);
}

}  // namespace

core::Expected<Compared> compare_revisions(const compare::Revision& before, const compare::Revision& after,
                                           const compare::Options& options) {
  auto found = compare::revisions(before, after, options);
  if (!found) return tl::unexpected(found.error());
  Compared out{{}, {}, options.tolerance, before, after, std::move(*found), {}};
  out.groups = compare::grouped(before, after, out.found, options.tolerance);
  return out;
}

bool is_listed(const Change& change) {
  return change.state != compare::State::kUnchanged || change.differences != 0;
}

std::string_view state_name(const Change& change) {
  return change.state == compare::State::kUnchanged && change.differences != 0 ? "renamed"
                                                                               : compare::name_of(change.state);
}

std::string path_before(const Compared& c, const Change& change) {
  return c.before.scene->path(c.before.scene->node_of(change.before));
}

std::string path_after(const Compared& c, const Change& change) {
  return c.after.scene->path(c.after.scene->node_of(change.after));
}

std::string path_of(const Compared& c, const Change& change) {
  return change.after == core::kNoItem ? path_before(c, change) : path_after(c, change);
}

core::Kind kind_of(const Compared& c, const Change& change) {
  return change.after == core::kNoItem ? c.before.scene->kind(change.before) : c.after.scene->kind(change.after);
}

std::vector<std::string> names_of(std::uint8_t differences) {
  std::vector<std::string> names;
  for (const auto& [bit, name] : {std::pair(compare::kShape, "shape"), std::pair(compare::kPlace, "place"),
                                  std::pair(compare::kMaterial, "material"),
                                  std::pair(compare::kAttributes, "attributes"), std::pair(compare::kPath, "path")})
    if (differences & bit) names.emplace_back(name);
  return names;
}

std::vector<FactChange> facts_of(const Compared& c, const Change& change) {
  std::vector<FactChange> facts;
  if (change.before == core::kNoItem || change.after == core::kNoItem) return facts;
  const core::Scene &before = *c.before.scene, &after = *c.after.scene;
  if (change.differences & compare::kShape) {
    facts = differing(item_facts(before, change.before), item_facts(after, change.after));
    // Where the box is tells of the place, and the material follows with its colour.
    std::erase_if(facts, [](const FactChange& fact) {
      return fact.name == "from" || fact.name == "to" || fact.name == "material";
    });
  }
  if (change.differences & compare::kMaterial)
    facts.push_back({"material", material_text(before, material_of(before, change.before)),
                     material_text(after, material_of(after, change.after))});
  if (change.differences & compare::kAttributes)
    for (FactChange& fact :
         facts_of(c, compare::NodeChange{before.node_of(change.before), after.node_of(change.after)}))
      facts.push_back(std::move(fact));
  return facts;
}

std::vector<FactChange> facts_of(const Compared& c, const compare::NodeChange& change) {
  return differing(attribute_facts(*c.before.scene, change.before), attribute_facts(*c.after.scene, change.after));
}

compare::State shown_as(Way way) {
  switch (way) {
    case Way::kAdded:
      return compare::State::kAdded;
    case Way::kRemoved:
      return compare::State::kRemoved;
    case Way::kMoved:
      return compare::State::kMoved;
    case Way::kRenamed:
      return compare::State::kUnchanged;
    case Way::kShape:
    case Way::kMaterial:
    case Way::kAttributes:
    case Way::kNodeAttributes:
      break;
  }
  return compare::State::kChanged;
}

std::vector<core::ItemId> items_of(const Compared& c, const Group& group, Revision revision) {
  const bool newer = revision == Revision::kNewer;
  std::vector<core::ItemId> items;
  std::vector<core::NodeId> nodes;
  for (std::uint32_t i = group.begin; i < group.end; ++i) {
    const std::uint32_t member = c.groups.members[i];
    if (group.way == Way::kNodeAttributes) {
      nodes.push_back(newer ? c.found.nodes[member].after : c.found.nodes[member].before);
    } else {
      const core::ItemId item = newer ? c.found.items[member].after : c.found.items[member].before;
      if (item != core::kNoItem) items.push_back(item);
    }
  }
  if (!nodes.empty()) return items_below(*(newer ? c.after : c.before).scene, nodes);
  core::sort_unique(items);
  return items;
}

core::AabbD box_of(const Compared& c, const Group& group, Revision revision) {
  if (group.way == Way::kNodeAttributes) return c.after.scene->bounds(group.node);
  core::AabbD box = group.box;
  if (group.way != Way::kMoved) return box;
  const core::AabbD before{box.min - group.offset, box.max - group.offset};
  if (glm::length(group.offset) <= glm::length(box.size()))
    box.grow(before);
  else if (revision == Revision::kOlder)
    box = before;
  return box;
}

const core::Scene& scene_of(const Compared& c, const Group& group) {
  return *(group.way == Way::kRemoved ? c.before : c.after).scene;
}

std::string path_of(const Compared& c, const Group& group) {
  const std::string path = scene_of(c, group).path(group.node);
  return path.empty() ? "/" : path;
}

std::string name_of(const Compared& c, const Group& group) {
  const std::string_view name = scene_of(c, group).name(group.node);
  return name.empty() ? path_of(c, group) : std::string(name);
}

std::string what_of(const Compared& c, const Group& group) {
  const bool nodes = group.way == Way::kNodeAttributes;
  std::string text = grouped(std::int64_t(group.size()));
  if (group.of > group.size()) text += " of " + grouped(std::int64_t(group.of));
  text += nodes ? (group.of == 1 ? " node" : " nodes") : (group.of == 1 ? " item" : " items");
  if (!nodes && group.size() == 1) text += " (" + std::string(core::name_of(kind_of(c, c.item(group, 0)))) + ")";
  return text + " " + change_text(c, group);
}

}  // namespace sightline::apps
