// sightline-compare: what changed between two revisions of a model.

#include "sightline/analysis/compare/compare.h"

#include <cstdio>
#include <numbers>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/importers/json/internal/json.h"

namespace {

using namespace sightline;
using compare::Change;
using compare::State;
using Json = json::Value;

struct Options {
  std::string before, after, json_file;
  std::vector<std::string> before_attributes, after_attributes;
  importers::ImportOptions import;
  compare::Options compare;
  std::size_t list = 20;
  bool fail_on_changes = false;
};

core::Expected<double> parse_tolerance(const std::string& text) {
  auto tolerance = apps::parse_finite(text);
  if (tolerance && *tolerance < 0.0) return core::fail("expected a tolerance of at least 0, found \"" + text + "\"");
  return tolerance;
}

core::Expected<apps::Model> load(const std::string& file, const std::vector<std::string>& attributes,
                                 const importers::ImportOptions& import) {
  apps::ModelOptions options;
  options.files = {file};
  options.files.insert(options.files.end(), attributes.begin(), attributes.end());
  options.import = import;
  options.import.copies = importers::MeshCopies::kExact;  // similar copies may be moved by a little
  auto model = apps::load_model(options);
  if (!model) return model;
  if (auto delta = model->scene->commit(); !delta) return tl::unexpected(delta.error());
  return model;
}

/// Below the node of the file, so that the file's name does not matter.
compare::Revision revision_of(const apps::Model& model) {
  const auto& nodes = model.report.nodes;
  return {model.scene.get(), nodes.size() == 1 ? nodes[0] : model.scene->root()};
}

std::string names_of(std::uint8_t differences) {
  std::string names;
  for (const auto& [bit, name] : {std::pair(compare::kShape, "shape"), std::pair(compare::kPlace, "place"),
                                  std::pair(compare::kMaterial, "material"),
                                  std::pair(compare::kAttributes, "attributes"), std::pair(compare::kPath, "path")})
    if (differences & bit) names.append(names.empty() ? "" : ", ").append(name);
  return names;
}

/// Paths and facts of what differs.
class Reporter {
 public:
  Reporter(const core::Scene& before, const core::Scene& after) : before_(before), after_(after) {}

  static bool is_listed(const Change& change) { return change.state != State::kUnchanged || change.differences != 0; }

  /// One line: state, path, what differs, by how much.
  void print(const Change& change) const {
    const bool removed = change.after == core::kNoItem;
    std::printf("%-9s %s  (%s)", state_name(change), removed ? path_before(change).c_str() : path_after(change).c_str(),
                std::string(core::name_of(removed ? before_.kind(change.before) : after_.kind(change.after))).c_str());
    if (change.differences) std::printf("  %s", names_of(change.differences).c_str());
    if (change.differences & compare::kPlace) {
      const core::dvec3& o = change.offset;
      std::printf("; by %.4f m (%.4f %.4f %.4f)", glm::length(o), o.x, o.y, o.z);
      if (change.turn > 1e-6) std::printf(", turned by %.3f degrees", change.turn * 180.0 / std::numbers::pi);
    }
    if (change.differences & compare::kPath) std::printf("; was %s", path_before(change).c_str());
    std::printf("\n");
  }

  Json to_json(const Change& change) const {
    Json out{{"state", compare::name_of(change.state)}};
    if (change.before != core::kNoItem) out["before"] = path_before(change);
    if (change.after != core::kNoItem) out["after"] = path_after(change);
    out["kind"] =
        core::name_of(change.after != core::kNoItem ? after_.kind(change.after) : before_.kind(change.before));
    if (change.differences) out["differs"] = names_json(change.differences);
    if (change.differences & compare::kPlace) {
      out["offset"] = {change.offset.x, change.offset.y, change.offset.z};
      out["turn_deg"] = change.turn * 180.0 / std::numbers::pi;
    }
    return out;
  }

 private:
  static const char* state_name(const Change& change) {
    return change.state == State::kUnchanged ? "renamed" : compare::name_of(change.state).data();
  }
  static Json names_json(std::uint8_t differences) {
    Json out = Json::array();
    for (int bit = 0; bit < 8; ++bit)
      if (differences & 1 << bit) out.push_back(names_of(std::uint8_t(1 << bit)));
    return out;
  }
  std::string path_before(const Change& change) const { return before_.path(before_.node_of(change.before)); }
  std::string path_after(const Change& change) const { return after_.path(after_.node_of(change.after)); }

  const core::Scene &before_, &after_;
};

void print(const compare::Comparison& found, const Reporter& reporter, const core::Scene& after, std::size_t most) {
  for (std::size_t i = 0; i < compare::kStateCount; ++i)
    std::printf("%-16s %12zu\n", std::string(compare::name_of(State(i))).c_str(), found.counts[i]);
  std::printf("%-16s %12zu\n%-16s %12zu\n", "renamed", found.renamed, "nodes changed", found.nodes.size());
  std::size_t listed = 0, left_out = 0;
  const auto may_list = [&] { return listed < most ? bool(++listed) : (++left_out, false); };
  for (const Change& change : found.items)
    if (Reporter::is_listed(change) && may_list()) reporter.print(change);
  for (const compare::NodeChange& node : found.nodes)
    if (may_list()) std::printf("%-9s %s  (node)  attributes\n", "changed", after.path(node.after).c_str());
  if (left_out > 0 && most > 0) std::printf("and %zu more (--list N)\n", left_out);
}

Json to_json(const Options& options, const compare::Comparison& found, const Reporter& reporter,
             const core::Scene& after) {
  Json out{{"before", options.before}, {"after", options.after}, {"tolerance", options.compare.tolerance}};
  for (std::size_t i = 0; i < compare::kStateCount; ++i)
    out["counts"][std::string(compare::name_of(State(i)))] = found.counts[i];
  out["renamed"] = found.renamed;
  out["items"] = Json::array();
  for (const Change& change : found.items)
    if (Reporter::is_listed(change)) out["items"].push_back(reporter.to_json(change));
  out["nodes"] = Json::array();
  for (const compare::NodeChange& node : found.nodes) out["nodes"].push_back(after.path(node.after));
  return out;
}

core::Expected<int> run(const Options& options) {
  const auto before = load(options.before, options.before_attributes, options.import);
  if (!before) return tl::unexpected(before.error());
  const auto after = load(options.after, options.after_attributes, options.import);
  if (!after) return tl::unexpected(after.error());
  const auto found = compare::revisions(revision_of(*before), revision_of(*after), options.compare);
  if (!found) return tl::unexpected(found.error());
  const Reporter reporter(*before->scene, *after->scene);
  if (options.json_file != "-") print(*found, reporter, *after->scene, options.list);
  if (!options.json_file.empty()) {
    const std::string text = apps::to_text(json::sorted(to_json(options, *found, reporter, *after->scene)));
    if (auto done = apps::write_text(options.json_file, text); !done) return tl::unexpected(done.error());
  }
  return options.fail_on_changes && !found->same() ? apps::kExitFailure : apps::kExitOk;
}

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line(
      "What changed between two revisions of a model: items added, removed, moved and changed", "sightline-compare",
      "  sightline-compare plant-a.rvm plant-b.rvm\n"
      "  sightline-compare old.rvm new.rvm --old-attributes old.txt --new-attributes new.txt --json -\n"
      "  sightline-compare old.glb new.glb --tolerance 0.001 --fail-on-changes");
  Options options;
  line.add("OLD", options.before, "Model file of the earlier revision").required();
  line.add("NEW", options.after, "Model file of the later revision").required();
  line.add("--old-attributes", options.before_attributes, "Attribute file of OLD; may be given several times")
      .one_value_each();
  line.add("--new-attributes", options.after_attributes, "Attribute file of NEW; may be given several times")
      .one_value_each();
  line.add("--tolerance", options.compare.tolerance, "Metres by which points may differ and count as the same")
      .shows_default()
      .accepted_by(parse_tolerance);
  line.add("--list", options.list, "List at most so many items that differ").shows_default().not_negative();
  line.add_flag("--fail-on-changes", options.fail_on_changes, "Exit 1 when anything but names differs");
  apps::add_import_options(line, options.import);
  line.add("--json", options.json_file, "Write counts and all that differs as JSON to FILE, or - for stdout");
  return line.run(argc, argv, [&] { return run(options); });
}
