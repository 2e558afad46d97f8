// sightline-bench import: the speed of importing model files into scenes, on one thread.
//
// Equal conditions: the file's bytes are in memory (read once before, from the page cache), every pass makes a new
// scene, and the commit is timed separately. What counts is the median over the passes.

#include "sightline/importers/import.h"

#include <cstdio>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/table.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::bench::import_bench {
namespace {

struct Options {
  std::vector<std::string> files;
  std::string json;
  int passes = 5;
  bool no_sharing = false;
  importers::ImportOptions import;
};

constexpr apps::Column kColumns[] = {{"MB", "mb", "{:.2f}"},
                                     {"MB/s", "mb_per_s", "{:.1f}"},
                                     {"import ms", "import_ms", "{:.2f}"},
                                     {"commit ms", "commit_ms", "{:.2f}"},
                                     {"items", "items", "{:.0f}"},
                                     {"shared", "shared_meshes", "{:.0f}"},
                                     {"scene MB", "scene_mb", "{:.1f}"},
                                     {"file", "file"}};

json::Value measure(const std::string& file, int passes, const importers::ImportOptions& options) {
  json::Value row;
  std::vector<double> import_ms, commit_ms;
  for (int pass = 0; pass < passes; ++pass) {
    core::Scene scene;
    const double begin = milliseconds();
    const auto report = apps::need(importers::import_file(core::platform::path_of(file), scene, scene.root(), options));
    import_ms.push_back(milliseconds() - begin);
    const double committing = milliseconds();
    apps::need(scene.commit());
    commit_ms.push_back(milliseconds() - committing);
    row = {{"file", file},
           {"mb", double(report.bytes) / 1e6},
           {"items", scene.item_count()},
           {"shared_meshes", report.shared_meshes},
           {"scene_mb", double(scene.memory_bytes()) / 1e6}};
  }
  const double median = apps::median(import_ms);
  row.update({{"import_ms", median},
              {"commit_ms", apps::median(commit_ms)},
              {"mb_per_s", 1e3 * row["mb"].get<double>() / median}});
  return row;
}

core::Expected<int> run(const Options& options) {
  importers::ImportOptions import = options.import;
  if (options.no_sharing) import.copies = importers::MeshCopies::kApart;
  json::Value rows = json::Value::array();
  for (const std::string& file : options.files) rows.push_back(measure(file, options.passes, import));
  return finish(options.json, json::sorted(rows),
                [](const json::Value& all, std::FILE* out) { apps::print_table(all, kColumns, out); });
}

void add_options(apps::CommandLine& line, Options& options) {
  line.add("FILE", options.files, "Model files, each measured by itself").required();
  line.add("--passes", options.passes, "Imports per file").shows_default().in_range(1, 1000);
  line.add_flag("--no-sharing", options.no_sharing, "Leave equal meshes apart");
  apps::add_import_options(line, options.import);
  apps::add_json_option(line, options.json);
  line.examples(
      "  sightline-bench import plant.rvm bunny.ply\n"
      "  sightline-bench import --passes 9 --json - a.obj");
}

}  // namespace
}  // namespace sightline::bench::import_bench

sightline::bench::Run sightline::bench::add_import(apps::CommandLine& line) {
  using namespace import_bench;
  return add_subcommand<Options>(line, add_options, run);
}
