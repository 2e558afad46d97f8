#include <charconv>
#include <iterator>

#include "sightline/apps/common/markup.h"
#include "sightline/apps/compare/reports.h"

namespace sightline::apps {
namespace {

using compare::Change;

constexpr std::string_view kHead = "state,path,kind,dx_m,dy_m,dz_m,turn_deg,changed,old_path,old,new\r\n";

std::string number(double value) {
  char text[32];
  return {text, std::to_chars(text, std::end(text), value + 0.0).ptr};  // + 0.0: no -0
}

std::string joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : "; ") + text;
  return all;
}

/// "radius=0.1 m; Type=PIPE": what facts were, or are; those that were not there are left out.
std::string values(const std::vector<FactChange>& facts, std::string FactChange::*side) {
  std::vector<std::string> all;
  for (const FactChange& fact : facts)
    if (!(fact.*side).empty()) all.push_back(fact.name + "=" + fact.*side);
  return joined(all);
}

std::string row(const Compared& c, const Change& change) {
  std::string out(state_name(change));
  out += "," + csv_field(path_of(c, change)) + "," + std::string(core::name_of(kind_of(c, change)));
  const bool moved = change.differences & compare::kPlace;
  for (int axis = 0; axis < 3; ++axis) out += "," + (moved ? number(change.offset[axis]) : "");
  out += "," + (moved ? number(glm::degrees(change.turn)) : "");
  out += "," + csv_field(joined(names_of(change.differences)));
  out += "," + (change.differences & compare::kPath ? csv_field(path_before(c, change)) : "");
  const std::vector<FactChange> facts = facts_of(c, change);
  return out + "," + csv_field(values(facts, &FactChange::before)) + "," +
         csv_field(values(facts, &FactChange::after)) + "\r\n";
}

std::string row(const Compared& c, const compare::NodeChange& change) {
  const std::vector<FactChange> facts = facts_of(c, change);
  return "changed," + csv_field(c.after.scene->path(change.after)) + ",node,,,,,attributes,," +
         csv_field(values(facts, &FactChange::before)) + "," + csv_field(values(facts, &FactChange::after)) + "\r\n";
}

}  // namespace

std::string csv_report(const Compared& c) {
  std::string out(kHead);
  for (const Change& change : c.found.items)
    if (is_listed(change)) out += row(c, change);
  for (const compare::NodeChange& change : c.found.nodes) out += row(c, change);
  return out;
}

}  // namespace sightline::apps
