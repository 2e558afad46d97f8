#include "sightline/apps/compare/reports.h"

namespace sightline::apps {
namespace {

using compare::Change;
using compare::Group;
using compare::Way;
using Json = json::Value;

Json vector_json(const core::dvec3& v) {
  return {v.x, v.y, v.z};
}

Json item_json(const Compared& c, const Change& change) {
  Json out{{"state", compare::name_of(change.state)}, {"kind", core::name_of(kind_of(c, change))}};
  if (change.before != core::kNoItem) out["before"] = path_before(c, change);
  if (change.after != core::kNoItem) out["after"] = path_after(c, change);
  if (change.differences) out["differs"] = names_of(change.differences);
  if (change.differences & compare::kPlace) {
    out["offset"] = vector_json(change.offset);
    out["turn_deg"] = glm::degrees(change.turn);
  }
  return out;
}

/// Names what differs in a group as items name it. Added and removed items have no name.
std::string difference_name(Way way) {
  switch (way) {
    case Way::kMoved:
      return "place";
    case Way::kShape:
      return "shape";
    case Way::kMaterial:
      return "material";
    case Way::kAttributes:
    case Way::kNodeAttributes:
      return "attributes";
    case Way::kRenamed:
      return "path";
    case Way::kAdded:
    case Way::kRemoved:
      break;
  }
  return "";
}

Json group_json(const Compared& c, const Group& group) {
  Json out{{"state", compare::name_of(group.way)},
           {"node", path_of(c, group)},
           {group.way == Way::kNodeAttributes ? "nodes" : "items", group.size()},
           {"of", group.of},
           {"text", what_of(c, group)}};
  if (const std::string name = difference_name(group.way); !name.empty()) out["differs"] = name;
  if (!group.box.empty()) out["box"] = {vector_json(group.box.min), vector_json(group.box.max)};
  if (group.way != Way::kMoved) return out;
  out["offset"] = vector_json(group.offset);
  out["turn_deg"] = glm::degrees(group.turn);
  if (group.turn > 0.0) out["axis"] = vector_json(group.axis);
  return out;
}

}  // namespace

Json json_report(const Compared& c) {
  Json out{{"before", c.before_file},
           {"after", c.after_file},
           {"tolerance", c.tolerance},
           {"with_attributes", c.found.with_attributes}};
  for (std::size_t i = 0; i < compare::kStateCount; ++i)
    out["counts"][std::string(compare::name_of(compare::State(i)))] = c.found.counts[i];
  out["renamed"] = c.found.renamed;
  out["groups"] = Json::array();
  for (const Group& group : c.groups.all) out["groups"].push_back(group_json(c, group));
  out["items"] = Json::array();
  for (const Change& change : c.found.items)
    if (is_listed(change)) out["items"].push_back(item_json(c, change));
  out["nodes"] = Json::array();
  for (const compare::NodeChange& node : c.found.nodes) out["nodes"].push_back(c.after.scene->path(node.after));
  return out;
}

}  // namespace sightline::apps
