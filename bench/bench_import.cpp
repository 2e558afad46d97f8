// sightline-bench-import: how fast model files become scenes, on one thread.
//
// Held equal: the file's bytes lie in memory (read once before, from the page cache), a new scene for every pass, the
// commit is timed apart. A figure is the median over the passes.

#include <chrono>
#include <cstdio>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "sightline/apps/common/cli.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/importers/import.h"

namespace {

using namespace sightline;
using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

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
    const auto begin = Clock::now();
    const auto report = importers::import_file(file, scene, scene.root(), options);
    import_ms.push_back(milliseconds_since(begin));
    if (!report) return tl::unexpected(report.error());
    const auto committing = Clock::now();
    if (auto delta = scene.commit(); !delta) return tl::unexpected(delta.error());
    commit_ms.push_back(milliseconds_since(committing));
    figures.bytes = report->bytes;
    figures.items = scene.item_count();
    figures.shared = report->shared_meshes;
    figures.scene_bytes = scene.memory_bytes();
  }
  figures.import_ms = apps::summarise(import_ms).median;
  figures.commit_ms = apps::summarise(commit_ms).median;
  return figures;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Measures how fast model files are imported", "sightline-bench-import");
  apps::describe(app,
                 "  sightline-bench-import plant.rvm bunny.ply\n  sightline-bench-import --passes 9 --json - a.obj");
  std::vector<std::string> files;
  std::string json_file;
  int passes = 5;
  bool no_sharing = false;
  importers::ImportOptions options;
  app.add_option("FILE", files, "Model files, each measured by itself")->required();
  app.add_option("--passes", passes, "Imports per file")->capture_default_str()->check(CLI::Range(1, 1000));
  app.add_flag("--no-sharing", no_sharing, "Leave equal meshes apart");
  app.add_option("--json", json_file, "Write the figures as JSON to FILE, or - for stdout");
  apps::add_import_options(app, options);
  return apps::run(app, argc, argv, [&]() -> core::Expected<int> {
    if (no_sharing) options.copies = importers::MeshCopies::kApart;
    nlohmann::json out = nlohmann::json::array();
    if (json_file != "-")
      std::printf("%9s %9s %10s %9s %9s %9s %9s  file\n", "MB", "MB/s", "import ms", "commit ms", "items", "shared",
                  "scene MB");
    for (const std::string& file : files) {
      const auto f = measure(file, passes, options);
      if (!f) return tl::unexpected(f.error());
      if (json_file != "-")
        std::printf("%9.2f %9.1f %10.2f %9.2f %9llu %9llu %9.1f  %s\n", double(f->bytes) / 1e6, f->megabytes_per_s(),
                    f->import_ms, f->commit_ms, (unsigned long long)f->items, (unsigned long long)f->shared,
                    double(f->scene_bytes) / 1e6, file.c_str());
      out.push_back({{"file", file},
                     {"bytes", f->bytes},
                     {"mb_per_s", f->megabytes_per_s()},
                     {"import_ms", f->import_ms},
                     {"commit_ms", f->commit_ms},
                     {"items", f->items},
                     {"shared_meshes", f->shared},
                     {"scene_bytes", f->scene_bytes}});
    }
    if (!json_file.empty())
      if (auto done = apps::write_text(json_file, apps::to_text(out)); !done) return tl::unexpected(done.error());
    return apps::kExitOk;
  });
}
