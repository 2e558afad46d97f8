// sightline-compare: what changed between two revisions of a model.

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <limits>
#include <span>
#include <utility>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/compare/group_images.h"
#include "sightline/apps/compare/reports.h"
#include "sightline/core/internal/atomic_file.h"
#include "sightline/core/internal/platform/files.h"

namespace {

using namespace sightline;
using apps::need;

struct Options {
  std::string before, after, html_file, csv_file, bcf_file, json_file;
  std::vector<std::string> before_attributes, after_attributes;
  importers::ImportOptions import;
  compare::Options compare;
  std::size_t list = 20;
  bool all = false, fail_on_changes = false;
};
constexpr std::string Options::*kTextFiles[] = {&Options::html_file, &Options::csv_file, &Options::json_file};

core::Expected<double> parse_tolerance(const std::string& text) {
  auto tolerance = apps::parse_finite(text);
  if (tolerance && *tolerance < 0.0) return core::fail("expected a tolerance of at least 0, found \"" + text + "\"");
  return tolerance;
}

apps::Model load(const std::string& file, const std::vector<std::string>& attributes,
                 const importers::ImportOptions& import) {
  apps::ModelOptions options;
  options.files = {file};
  options.files.insert(options.files.end(), attributes.begin(), attributes.end());
  options.import = import;
  options.import.copies = importers::MeshCopies::kExact;  // similar copies may be moved by a little
  auto model = need(apps::load_model(options));
  need(model.scene->commit());
  return model;
}

/// Below the node of the file, so that the file's name does not matter.
compare::Revision revision_of(const apps::Model& model) {
  const auto& nodes = model.report.nodes;
  return {model.scene.get(), nodes.size() == 1 ? nodes[0] : model.scene->root()};
}

apps::Compared compared(const Options& options, const apps::Model& before, const apps::Model& after) {
  compare::Options with = options.compare;
  apps::Progress bar("comparing");
  with.progress = bar.callback();
  auto out = need(apps::compare_revisions(revision_of(before), revision_of(after), with));
  out.before_file = options.before;
  out.after_file = options.after;
  return out;
}

/// For pages and topics, where this build can draw.
std::vector<apps::GroupImage> images_of(const Options& options, const apps::Compared& found, const apps::Model& before,
                                        const apps::Model& after) {
  if (options.html_file.empty() && options.bcf_file.empty()) return {};
#if SIGHTLINE_HAS_GROUP_IMAGES
  apps::Progress bar("drawing");
  return need(
      apps::group_images(found, *before.scene, *after.scene, [&](double share) { (void)bar.callback()(share); }));
#else
  (void)found, (void)before, (void)after;
  return {};
#endif
}

void write_bcf(const Options& options, const apps::Compared& found, std::span<const apps::GroupImage> images) {
  const auto bytes = bcf_report(found, images);
  if (!bytes) apps::fail(options.bcf_file + ": " + bytes.error().message);
  need(core::write_file(core::platform::path_of(options.bcf_file), {std::as_bytes(std::span(*bytes))}));
  if (const std::size_t all = found.groups.all.size(); all > apps::kMostTopics)
    std::fprintf(stderr, "sightline-compare: %s: has the %zu largest of %zu groups\n", options.bcf_file.c_str(),
                 apps::kMostTopics, all);
}

void write_files(const Options& options, const apps::Compared& found, std::span<const apps::GroupImage> images) {
  if (!options.json_file.empty()) need(apps::write_json(options.json_file, json::sorted(json_report(found))));
  if (!options.html_file.empty()) need(apps::write_text(options.html_file, html_report(found, images)));
  if (!options.csv_file.empty()) need(apps::write_text(options.csv_file, csv_report(found)));
  if (!options.bcf_file.empty()) write_bcf(options, found, images);
}

core::Expected<int> run(const Options& options) {
  const auto before = load(options.before, options.before_attributes, options.import);
  const auto after = load(options.after, options.after_attributes, options.import);
  const auto found = compared(options, before, after);
  const auto to_stdout = [&] {
    return std::any_of(std::begin(kTextFiles), std::end(kTextFiles), [&](auto file) { return options.*file == "-"; });
  };
  if (!to_stdout()) {
    constexpr auto kAll = std::numeric_limits<std::size_t>::max();
    std::fputs(text_report(found, options.all ? kAll : options.list).c_str(), stdout);
  }
  write_files(options, found, images_of(options, found, before, after));
  return options.fail_on_changes && !found.found.same() ? apps::kExitFailure : apps::kExitOk;
}

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line(
      "What changed between two revisions of a model: items added, removed, moved and changed", "sightline-compare",
      "  sightline-compare plant-a.rvm plant-b.rvm\n"
      "  sightline-compare plant-a.rvm plant-b.rvm --html changes.html --csv changes.csv --bcf changes.bcf\n"
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
  const apps::Option all = line.add_flag("--all", options.all, "List all groups of equal changes");
  line.add("--list", options.list, "List at most so many groups, the largest ones")
      .shows_default()
      .not_negative()
      .excludes(all);
  line.add_flag("--fail-on-changes", options.fail_on_changes, "Exit 1 when anything but names differs");
  apps::add_import_options(line, options.import);
  line.add("--html", options.html_file, "Write a page with all groups and their items to FILE").usage_text("FILE");
  line.add("--csv", options.csv_file, "Write a row for each item that differs to FILE, or - for stdout")
      .usage_text("FILE");
  line.add("--bcf", options.bcf_file,
           "Write a BCF topic for each group to FILE, at most " + std::to_string(apps::kMostTopics))
      .usage_text("FILE");
  line.add("--json", options.json_file, "Write counts, groups and all that differs as JSON to FILE, or - for stdout")
      .usage_text("FILE");
  return line.run(argc, argv, [&] { return run(options); });
}
