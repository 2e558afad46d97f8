// sightline-study proxies: tightness of the proxies of ray-cast primitives. It is the number of pixels that the
// fragment stage ran for, divided by the number of pixels that show the item. Each item is drawn alone, fills about
// half of the view, and is seen from random directions. Items are generated with proportions as in plants, or come from
// models, whose placements are ignored.
//
// ARB_pipeline_statistics_query counts the fragments. Most implementations count whole blocks of pixels (4 x 4 on
// llvmpipe), so slim items seem worse than they are.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/gpuscene/internal/gpu_scene.h"
#include "sightline/importers/import.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/study/parts/parts.h"

namespace sightline::bench::proxies_bench {
namespace {

using Json = json::Value;
using core::dvec3;
using core::Kind;

constexpr GLenum kFragmentShaderInvocations = 0x82F4;
constexpr std::array kKinds = {Kind::kCylinder,         Kind::kSnout,          Kind::kCircularTorus,
                               Kind::kSphere,           Kind::kEllipticalDish, Kind::kSphericalDish,
                               Kind::kRectangularTorus, Kind::kPyramid,        Kind::kBox};

struct Options {
  std::vector<std::string> models;
  int items = 100, size = 512;
  std::uint32_t seed = 1;
  gl::ContextPlatform platform = {};
  std::string json;
};

struct Item {
  core::Primitive primitive;
  core::dmat3 linear{1.0};
};

class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * double(engine_()) / 4294967296.0; }
  float number(double low, double high) { return float(uniform(low, high)); }
  /// Uniform over octaves.
  float length(double low, double high) { return float(std::exp(uniform(std::log(low), std::log(high)))); }
  dvec3 direction() {
    const double z = uniform(-1.0, 1.0), turn = uniform(0.0, 2.0 * std::numbers::pi), r = std::sqrt(1.0 - z * z);
    return {r * std::cos(turn), r * std::sin(turn), z};
  }
  std::size_t below(std::size_t count) { return engine_() % count; }

 private:
  std::mt19937 engine_;
};

core::Primitive made_up(Kind kind, Random& random) {
  constexpr double kFull = 2.0 * std::numbers::pi;
  const float angle = random.uniform(0.0, 1.0) < 0.5 ? float(0.25 * kFull) : random.number(0.1, kFull);
  switch (kind) {
    case Kind::kCylinder:
      return core::Cylinder{1.0f, random.length(0.1, 40.0)};
    case Kind::kSnout:
      return core::Snout{
          1.0f, random.number(0.2, 1.0), random.length(0.2, 5.0), random.number(-0.5, 0.5), 0.0f, 0.0f, 0.0f, 0.0f,
          0.0f};
    case Kind::kCircularTorus:
      return core::CircularTorus{random.length(1.5, 10.0), 1.0f, angle};
    case Kind::kSphere:
      return core::Sphere{1.0f};
    case Kind::kEllipticalDish:
      return core::EllipticalDish{1.0f, random.number(0.2, 1.0)};
    case Kind::kSphericalDish:
      return core::SphericalDish{1.0f, random.number(0.1, 1.0)};
    case Kind::kRectangularTorus: {
      const float inner = random.length(0.3, 10.0);
      return core::RectangularTorus{inner, inner + random.number(0.2, 2.0), random.number(0.2, 2.0), angle};
    }
    case Kind::kPyramid:
      return core::Pyramid{random.length(0.2, 5.0), random.length(0.2, 5.0),  random.length(0.2, 5.0),
                           random.length(0.2, 5.0), random.number(-1.0, 1.0), random.number(-1.0, 1.0),
                           random.length(0.2, 5.0)};
    default:
      return core::Box{1.0f, random.length(0.1, 10.0), random.length(0.1, 10.0)};
  }
}

core::Expected<std::vector<Item>> items_of(const std::string& model, Kind kind, int count, Random& random) {
  std::vector<Item> items;
  if (model.empty()) {
    for (int i = 0; i < count; ++i) items.push_back({made_up(kind, random)});
    return items;
  }
  core::Scene scene;
  if (auto report = importers::import_file(model, scene, scene.root()); !report) return tl::unexpected(report.error());
  const core::Snapshot snapshot(scene);
  std::vector<core::Slot> slots;
  for (const core::Slot s : snapshot.of_kind(kind).members)
    if (!snapshot.vacant(s) && !core::is_degenerate(snapshot.primitive(s))) slots.push_back(s);
  for (int i = 0; i < count && !slots.empty(); ++i) {
    const core::Slot s = slots[random.below(slots.size())];
    items.push_back({snapshot.primitive(s), snapshot.world_from_item(s).linear});
  }
  return items;
}

struct Tightness {
  std::uint64_t proxy = 0, shown = 0;  // pixels over all items
  std::vector<double> ratios;          // of each visible item

  double ratio() const { return double(proxy) / double(shown); }
};

/// Items stand in a row, far enough apart that each is alone in its view.
core::Expected<Tightness> measure(gl::Context& context, const std::vector<Item>& items, int size, Random& random) {
  core::Scene scene;
  std::vector<core::AabbD> boxes;
  double reach = 0.0;
  for (const Item& item : items) {
    const core::AabbD box = core::bounds(item.primitive, {item.linear, dvec3(0.0)});
    reach = std::max(reach, glm::length(box.max - box.min));
  }
  for (std::size_t i = 0; i < items.size(); ++i) {
    const core::Affine placed{items[i].linear, {100.0 * reach * double(i), 0.0, 0.0}};
    scene.add_primitive(scene.root(), items[i].primitive, placed);
    boxes.push_back(core::bounds(items[i].primitive, placed));
  }
  engine::EngineConfig config;
  config.draw = config.drawing.ids = true;
  config.width = config.height = size;
  config.context.application = &context;
  auto engine = engine::Engine::create(scene, config);
  if (!engine) return tl::unexpected(engine.error());
  const gl::Functions& gl = context.functions();
  GLuint query = 0;
  gl.GenQueries(1, &query);  // Mesa 22's glCreateQueries refuses the target
  Tightness out;
  for (const core::AabbD& box : boxes) {
    const double radius = 0.5 * glm::length(box.max - box.min);
    const dvec3 centre = box.centre(), eye = centre + 4.0 * radius * random.direction();
    const auto view = core::View::perspective({eye, centre, random.direction()}, 2.0 * std::asin(1.0 / 4.0), 1.0,
                                              radius, 10.0 * radius);
    if (!view) return tl::unexpected(view.error());
    gl.BeginQuery(kFragmentShaderInvocations, query);
    const auto frame = engine->frame(*view);
    gl.EndQuery(kFragmentShaderInvocations);
    if (!frame) return tl::unexpected(frame.error());
    const image::IdImage ids = engine->drawing()->target().read_ids();
    const auto shown =
        std::uint64_t(std::count_if(ids.ids.begin(), ids.ids.end(), [](std::uint32_t id) { return id != 0; }));
    if (shown == 0) continue;
    GLuint fragments = 0;
    gl.GetQueryObjectuiv(query, GL_QUERY_RESULT, &fragments);
    out.proxy += fragments;
    out.shown += shown;
    out.ratios.push_back(double(fragments) / double(shown));
  }
  gl.DeleteQueries(1, &query);
  return out;
}

core::Expected<int> run(const Options& o) {
  auto context = gl::Context::create_offscreen({.platform = o.platform});
  if (!context) return tl::unexpected(context.error());
  Json json = renderer_json(*context);
  json.update({{"size", o.size}, {"seed", o.seed}, {"subjects", Json::array()}});
  std::FILE* out = apps::table_stream(o.json);
  std::fprintf(out, "%s\n", renderer_line(*context).c_str());
  std::vector<std::string> subjects{""};
  subjects.insert(subjects.end(), o.models.begin(), o.models.end());
  for (const std::string& model : subjects) {
    const std::string name = model.empty() ? "made up" : std::filesystem::path(model).filename().string();
    std::fprintf(out, "%s\n%-20s %8s %12s %10s %10s\n", name.c_str(), "kind", "items", "proxy/shown", "median", "p90");
    Json rows = Json::array();
    for (const Kind kind : kKinds) {
      Random random(o.seed);
      const auto items = items_of(model, kind, o.items, random);
      if (!items) return tl::unexpected(items.error());
      if (items->empty()) continue;
      const auto found = measure(*context, *items, o.size, random);
      if (!found) return tl::unexpected(found.error());
      if (found->ratios.empty()) continue;
      const std::string kind_name(core::name_of(kind));
      const double median = apps::median(found->ratios), p90 = apps::percentile(found->ratios, 0.9);
      std::fprintf(out, "%-20s %8zu %12.2f %10.2f %10.2f\n", kind_name.c_str(), found->ratios.size(), found->ratio(),
                   median, p90);
      rows.push_back({{"kind", kind_name},
                      {"items", found->ratios.size()},
                      {"proxy_pixels", found->proxy},
                      {"shown_pixels", found->shown},
                      {"ratio", found->ratio()},
                      {"median", median},
                      {"p90", p90}});
    }
    json["subjects"].push_back({{"name", name}, {"kinds", std::move(rows)}});
  }
  return finish(o.json, json);
}

void add_options(apps::CommandLine& line, Options& o) {
  line.add("MODEL", o.models, "Models whose items are measured beside made-up ones");
  line.add("--items", o.items, "Of each kind").in_range(1, 100'000).shows_default();
  line.add("--size", o.size, "Width and height of the images").in_range(64, 4096).shows_default();
  line.add("--seed", o.seed, "Of shapes and directions").shows_default();
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-study proxies\n"
      "  sightline-study proxies plant.rvm --items 300 --json proxies.json");
}

}  // namespace
}  // namespace sightline::bench::proxies_bench

sightline::bench::Run sightline::bench::add_proxies(apps::CommandLine& line) {
  using namespace proxies_bench;
  return add_subcommand<Options>(line, add_options, run);
}
