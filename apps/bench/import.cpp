// sightline-bench import: the speed of importing model files into scenes, on one thread.
//
// Equal conditions: the file's bytes are in memory (read once before, from the page cache), every pass makes a new
// scene, and the commit is timed separately. A figure is the median over the passes.

#include "sightline/importers/import.h"

#include <cstdio>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/statistics.h"
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

struct Figures {
  std::string file;
  std::uint64_t bytes = 0, items = 0, shared = 0, scene_bytes = 0;
  double import_ms = 0.0, commit_ms = 0.0;
  double megabytes_per_s() const { return double(bytes) / 1e3 / import_ms; }
};

core::Expected<Figures> measure(const std::string& file, int passes, const importers::ImportOptions& options) {
  Figures figures{.file = file};
  std::vector<double> import_ms, commit_ms;
  for (int pass = 0; pass < passes; ++pass) {
    core::Scene scene;
    const double begin = milliseconds();
    const auto report = importers::import_file(file, scene, scene.root(), options);
    import_ms.push_back(milliseconds() - begin);
    if (!report) return tl::unexpected(report.error());
    const double committing = milliseconds();
    if (auto delta = scene.commit(); !delta) return tl::unexpected(delta.error());
    commit_ms.push_back(milliseconds() - committing);
    figures.bytes = report->bytes;
    figures.items = scene.item_count();
    figures.shared = report->shared_meshes;
    figures.scene_bytes = scene.memory_bytes();
  }
  figures.import_ms = apps::median(import_ms);
  figures.commit_ms = apps::median(commit_ms);
  return figures;
}

core::Expected<int> run(const Options& options) {
  importers::ImportOptions import = options.import;
  if (options.no_sharing) import.copies = importers::MeshCopies::kApart;
  json::Value json = json::Value::array();
  std::FILE* out = apps::table_stream(options.json);
  std::fprintf(out, "%9s %9s %10s %9s %9s %9s %9s  file\n", "MB", "MB/s", "import ms", "commit ms", "items", "shared",
               "scene MB");
  for (const std::string& file : options.files) {
    const auto f = measure(file, options.passes, import);
    if (!f) return tl::unexpected(f.error());
    std::fprintf(out, "%9.2f %9.1f %10.2f %9.2f %9llu %9llu %9.1f  %s\n", double(f->bytes) / 1e6, f->megabytes_per_s(),
                 f->import_ms, f->commit_ms, (unsigned long long)f->items, (unsigned long long)f->shared,
                 double(f->scene_bytes) / 1e6, file.c_str());
    json.push_back({{"file", file},
                    {"bytes", f->bytes},
                    {"mb_per_s", f->megabytes_per_s()},
                    {"import_ms", f->import_ms},
                    {"commit_ms", f->commit_ms},
                    {"items", f->items},
                    {"shared_meshes", f->shared},
                    {"scene_bytes", f->scene_bytes}});
  }
  return finish(options.json, json::sorted(std::move(json)));
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
