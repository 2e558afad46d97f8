// sightline-study stream: meshes come and go while a view flies through a plant. What the worst frame takes, commit
// included.
//
// Meshes of some sixty triangles arrive in a rhythm of real time, and the oldest leave once there are as many as
// --kept. Every frame commits what has come since the frame before. A second run edits nothing: its frames are what
// frames cost by themselves.
#include <algorithm>
#include <cstdio>
#include <deque>
#include <random>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/gpuprims/internal/sphere.h"
#include "sightline/study/parts/parts.h"

namespace sightline::bench::stream_bench {
namespace {

using Json = json::Value;
using engine::Engine;

struct Options {
  std::uint64_t items = 1'000'000;
  engine::CullerChoice culler = engine::CullerChoice::kCpu;
  gl::ContextPlatform platform = {};
  std::string size = "640x360";
  double rate = 10'000.0, seconds = 20.0;
  std::size_t kept = 50'000;
  std::string json;
};

void add_options(apps::CommandLine& line, Options& o) {
  line.add("--items", o.items, "Of the generated plant").in_range(1, 100'000'000).shows_default();
  apps::add_culler_option(line, o.culler);
  line.add("--size", o.size, "Of the image").shows_default();
  line.add("--rate", o.rate, "Meshes that come a second").in_range(0.0, 1e7).shows_default();
  line.add("--kept", o.kept, "Meshes that stay, the newest").in_range(1, 100'000'000).shows_default();
  line.add("--seconds", o.seconds, "Of the flight").in_range(0.1, 86'400.0).shows_default();
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-study stream --items 100000\n"
      "  sightline-study stream --culler gpu --rate 100 --kept 1000 --seconds 60");
}

/// The meshes of one run.
class Stream {
 public:
  Stream(core::Scene& scene, const core::AabbD& room, std::size_t kept) : scene_(scene), room_(room), kept_(kept) {}

  core::Expected<void> add(std::size_t count) {
    for (; count > 0; --count) {
      auto mesh = scene_.add_mesh(gpuprims::tessellate(core::Sphere{0.5f}, {.fixed_segments = 6 + int(random_() % 4)}));
      if (!mesh) return tl::unexpected(mesh.error());
      items_.push_back({scene_.add_mesh_instance(scene_.root(), *mesh, somewhere()), *mesh});
      if (items_.size() <= kept_) continue;
      scene_.remove_item(items_.front().item);
      scene_.remove_mesh(items_.front().mesh);
      items_.pop_front();
    }
    return {};
  }

 private:
  struct Streamed {
    core::ItemId item;
    core::MeshId mesh;
  };
  core::Affine somewhere() {
    std::uniform_real_distribution<double> share(0.0, 1.0);
    const double x = share(random_), y = share(random_);
    return core::translation(room_.min + (room_.max - room_.min) * core::dvec3(x, y, share(random_)));
  }

  core::Scene& scene_;
  core::AabbD room_;
  std::size_t kept_;
  std::mt19937 random_{1};
  std::deque<Streamed> items_;
};

struct Times {
  std::vector<double> frames, commits;  // milliseconds; frames include commits and the wait for the image
  int landings = 0;
  std::size_t meshes = 0;
};

core::Expected<Times> fly(const Options& o, Engine& engine, Stream& stream, const std::vector<core::View>& views,
                          double rate) {
  Times times;
  const gl::Functions& gl = engine.drawing()->context().functions();
  const double began = milliseconds();
  std::size_t disorder = 0;
  for (std::size_t frame = 0; milliseconds() - began < 1e3 * o.seconds; ++frame) {
    const double start = milliseconds();
    const auto due = std::size_t(rate * 1e-3 * (start - began));
    if (auto done = stream.add(due - times.meshes); !done) return tl::unexpected(done.error());
    times.meshes = due;
    const double added = milliseconds();
    if (auto done = engine.commit(); !done) return tl::unexpected(done.error());
    const double committed = milliseconds();
    if (auto drawn = engine.frame(views[frame % views.size()]); !drawn) return tl::unexpected(drawn.error());
    gl.Finish();
    times.commits.push_back(committed - added);
    times.frames.push_back(milliseconds() - added);
    times.landings += engine.snapshot().disorder() < disorder;
    disorder = engine.snapshot().disorder();
  }
  return times;
}

Json row_of(const char* name, const Times& times) {
  const auto most = [](const std::vector<double>& ms) { return *std::max_element(ms.begin(), ms.end()); };
  const double median = apps::median(times.frames);
  return {{"run", name},
          {"frames", times.frames.size()},
          {"meshes", times.meshes},
          {"landings", times.landings},
          {"median_ms", median},
          {"worst_ms", most(times.frames)},
          {"allowed_ms", 2.0 * median + 16.0},
          {"late", std::count_if(times.frames.begin(), times.frames.end(),
                                 [&](double ms) { return ms > 2.0 * median + 16.0; })},
          {"median_commit_ms", apps::median(times.commits)},
          {"worst_commit_ms", most(times.commits)}};
}

void print(const Json& json, std::FILE* out) {
  std::fprintf(out, "%-10s %7s %8s %9s %10s %9s %12s %5s %14s %9s\n", "run", "frames", "meshes", "landings",
               "median ms", "worst ms", "2 x + 16 ms", "late", "median commit", "worst");
  for (const Json& row : json["runs"])
    std::fprintf(out, "%-10s %7.0f %8.0f %9.0f %10.2f %9.2f %12.2f %5.0f %14.2f %9.2f\n",
                 row["run"].get<std::string>().c_str(), row["frames"].get<double>(), row["meshes"].get<double>(),
                 row["landings"].get<double>(), row["median_ms"].get<double>(), row["worst_ms"].get<double>(),
                 row["allowed_ms"].get<double>(), row["late"].get<double>(), row["median_commit_ms"].get<double>(),
                 row["worst_commit_ms"].get<double>());
}

core::Expected<int> run(const Options& o) {
  const auto size = apps::parse_size(o.size);
  if (!size) return tl::unexpected(size.error());
  auto scene = model_or_plant({}, o.items);
  if (!scene) return tl::unexpected(scene.error());
  engine::EngineConfig config = drawing_config((*size)[0], (*size)[1], o.platform);
  config.drawing.ids = false;
  config.culling.culler = o.culler;
  auto engine = Engine::create(**scene, config);
  if (!engine) return tl::unexpected(engine.error());
  const auto views = tour_views(engine->snapshot(), 600, double((*size)[0]) / (*size)[1]);
  if (!views) return tl::unexpected(views.error());
  Stream stream(**scene, engine->snapshot().bounds().fitted_bounds().bounds, o.kept);
  const gl::Context& context = engine->drawing()->context();
  Json json = renderer_json(context);
  json.update({{"items", (*scene)->item_count()}, {"rate", o.rate}, {"kept", o.kept}, {"seconds", o.seconds}});
  std::fprintf(apps::table_stream(o.json), "%s, %.0f meshes a second, %s\n\n",
               engine::count_text((*scene)->item_count()).c_str(), o.rate, renderer_line(context).c_str());
  for (const bool edits : {false, true}) {
    const auto times = fly(o, *engine, stream, *views, edits ? o.rate : 0.0);
    if (!times) return tl::unexpected(times.error());
    json["runs"].push_back(row_of(edits ? "streaming" : "no edits", *times));
  }
  return finish(o.json, json, print);
}

}  // namespace
}  // namespace sightline::bench::stream_bench

sightline::bench::Run sightline::bench::add_stream(apps::CommandLine& line) {
  using namespace stream_bench;
  return add_subcommand<Options>(line, add_options, run);
}
