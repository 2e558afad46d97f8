// sightline-bench trace: primary rays of one image through the ray tracer, on one thread, and beside Embree 3 where
// the build has found it. Embree gets all meshes as one mesh in world coordinates. It gets solids in two ways: as
// triangles, whose chords deviate by a quarter of a pixel at the median distance unless --chord says otherwise, and as
// user geometry that calls our reference intersectors.
//
// The rays exist before the clock runs, by default in the cache, where those of an image are that makes them tile by
// tile. The least of interleaved passes counts, in processor time.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/table.h"
#include "sightline/core/image_rays.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/raytrace/tracer.h"
#if SIGHTLINE_HAS_EMBREE
#include "sightline/apps/bench/embree_peer.h"
#include "sightline/gpuprims/internal/primitives.h"
#endif

namespace sightline::bench::trace_bench {
namespace {

using apps::need;
using core::dvec3;
using core::vec3;

struct Options {
  apps::ModelOptions model;
  std::size_t triangles = 900'000;
  std::uint64_t items = 0;
  double zoom = 1.0;
  int width = 1408, height = 768, passes = 5, threads = 1;
  std::size_t chunk = 4096;
  double chord = 0.25;
  std::string only, json;
};

/// A ball of radius 1 with bumps, of about as many triangles.
core::Mesh bumpy_ball(std::size_t triangles) {
  const auto rings = std::max(4u, std::uint32_t(std::sqrt(double(triangles) / 4.0))), segments = 2 * rings;
  core::Mesh mesh;
  for (std::uint32_t r = 0; r <= rings; ++r)
    for (std::uint32_t s = 0; s <= segments; ++s) {
      const double theta = std::numbers::pi * r / rings, phi = 2.0 * std::numbers::pi * (s % segments) / segments;
      const double radius = 1.0 + 0.1 * std::sin(9.0 * theta) * std::sin(11.0 * phi) + 0.01 * std::sin(70.0 * theta);
      mesh.positions.emplace_back(
          radius * dvec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)));
    }
  for (std::uint32_t r = 0; r < rings; ++r)
    for (std::uint32_t s = 0; s < segments; ++s) {
      const std::uint32_t a = r * (segments + 1) + s, b = a + segments + 1;
      for (const std::uint32_t i : {a, b, a + 1, a + 1, b, b + 1}) mesh.indices.push_back(i);
    }
  return mesh;
}

/// All rays of the image, by tiles of 4 x 4 pixels.
std::vector<core::Ray> primary_rays(const core::View& view, int width, int height) {
  const auto pixels = need(core::ImageRays::create(view, width, height));
  std::vector<core::Ray> rays;
  for (int y = 0; y < height; y += 4)
    for (int x = 0; x < width; x += 4)
      for (int j = y; j < std::min(y + 4, height); ++j)
        for (int i = x; i < std::min(x + 4, width); ++i) rays.push_back(pixels.through(i + 0.5, j + 0.5));
  return rays;
}

/// One way to trace all rays: its least time, and the distances of the last pass.
struct Variant {
  std::string name;
  std::function<void(std::size_t first, std::span<float> t)> trace;  ///< some rays, from `first` on
  double ms = std::numeric_limits<double>::infinity();
  std::vector<float> t = {};
  std::size_t hits() const {
    return std::size_t(std::count_if(t.begin(), t.end(), [](float x) { return std::isfinite(x); }));
  }
};

#if SIGHTLINE_HAS_EMBREE
void append(core::Mesh& all, const core::Mesh& mesh, const core::Affine& world) {
  const auto first = std::uint32_t(all.positions.size());
  for (const vec3& p : mesh.positions) all.positions.emplace_back(core::transform_point(world, dvec3(p)));
  for (const std::uint32_t i : mesh.indices) all.indices.push_back(first + i);
}

bool is_solid(core::Kind kind) {
  return int(kind) < core::kPrimitiveKindCount && kind != core::Kind::kLine;
}

/// All meshes of a snapshot, in world coordinates; with a chord tolerance in metres all solids as triangles, too.
core::Mesh joined(const core::Snapshot& snapshot, double tolerance = 0.0) {
  core::Mesh all;
  for (core::Slot slot = 0; slot < snapshot.size(); ++slot) {
    if (snapshot.vacant(slot)) continue;
    const core::Affine world = snapshot.world_from_item(slot);
    if (int(snapshot.kind(slot)) >= core::kPrimitiveKindCount) {
      append(all, snapshot.mesh(slot), world);
    } else if (tolerance > 0.0 && is_solid(snapshot.kind(slot))) {
      double scale = 0.0;
      for (int i = 0; i < 3; ++i) scale = std::max(scale, glm::length(world.linear[i]));
      append(all,
             gpuprims::tessellate(snapshot.primitive(slot), {.chord_tolerance = tolerance / scale, .min_segments = 3}),
             world);
    }
  }
  return all;
}

std::vector<PeerSolid> solids_of(const core::Snapshot& snapshot) {
  std::vector<PeerSolid> solids;
  for (core::Slot slot = 0; slot < snapshot.size(); ++slot) {
    if (snapshot.vacant(slot) || !is_solid(snapshot.kind(slot))) continue;
    const core::Affine world = snapshot.world_from_item(slot);
    const core::Primitive solid = snapshot.primitive(slot);
    solids.push_back({solid, glm::inverse(world.linear), world.origin, core::bounds(solid, world)});
  }
  return solids;
}

/// Embree's scenes, the rays as it takes them, and what it built.
struct Peers {
  int threads;
  std::vector<std::unique_ptr<EmbreePeer>> scenes = {};
  std::vector<FloatRay> rays = {};
  std::vector<Variant> variants = {};
  json::Value builds = json::Value::array();

  void add(const std::string& name, const core::Mesh& mesh, std::vector<PeerSolid> solids, bool robust) {
    if (mesh.indices.empty() && solids.empty()) return;
    const EmbreePeer* peer =
        scenes.emplace_back(std::make_unique<EmbreePeer>(mesh, std::move(solids), robust, threads)).get();
    builds.push_back(
        {{"name", name}, {"ms", peer->build_ms()}, {"bytes", peer->bytes()}, {"triangles", mesh.indices.size() / 3}});
    variants.push_back({.name = name + ", single", .trace = [peer, this](std::size_t first, std::span<float> t) {
                          peer->single(std::span(rays).subspan(first, t.size()), t);
                        }});
    variants.push_back({.name = name + ", packets of 16", .trace = [peer, this](std::size_t first, std::span<float> t) {
                          peer->packets(std::span(rays).subspan(first, t.size()), t);
                        }});
  }
};

/// A chord tolerance that an image shows as one pixel at the median distance of what it hits; metres.
double one_pixel(const raytrace::Tracer& tracer, std::span<const core::Ray> rays, int height) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < rays.size(); i += 97)
    if (const auto hit = tracer.nearest(rays[i]); *hit) distances.push_back((*hit)->t);
  if (distances.empty()) return 4.0;
  const auto middle = distances.begin() + std::ptrdiff_t(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return 2.0 * std::tan(0.5 * apps::kFovy) / height * *middle;
}

void add_peers(const core::Snapshot& snapshot, const raytrace::Tracer& tracer, std::span<const core::Ray> rays,
               const Options& options, Peers& peers, json::Value& json) {
  for (const core::Ray& r : rays)
    peers.rays.push_back({vec3(r.origin), vec3(r.direction), float(r.t_min), float(std::min(r.t_max, 1e30))});
  const core::Mesh mesh = joined(snapshot);
  const std::vector<PeerSolid> solids = solids_of(snapshot);
  if (solids.empty()) {
    peers.add("Embree robust", mesh, {}, true);
    peers.add("Embree default", mesh, {}, false);
    return;
  }
  const double tolerance = options.chord * one_pixel(tracer, rays, options.height);
  json["chord_tolerance_m"] = tolerance;
  peers.add("Embree robust, tessellated", joined(snapshot, tolerance), {}, true);
  peers.add("Embree, our intersectors", mesh, solids, true);
}
#endif

void print_table(const json::Value& json, std::FILE* out) {
  std::fprintf(out, "%zu items, %zu triangles, %zu rays\n", json["items"].get<std::size_t>(),
               json["triangles"].get<std::size_t>(), json["rays"].get<std::size_t>());
  if (json.contains("chord_tolerance_m"))
    std::fprintf(out, "tessellated within %.3g m\n", json["chord_tolerance_m"].get<double>());
  static constexpr apps::Column kBuilds[] = {
      {"tracer", "name"}, {"build, ms", "ms", "{:.1f}"}, {"bytes", "bytes", "{:.0f}"}};
  static constexpr apps::Column kVariants[] = {{"way", "name"},
                                               {"Mray/s", "mrays_per_s", "{:.2f}"},
                                               {"hit", "hits", "{:.0f}"},
                                               {"differ", "different", "{:.0f}"}};
  apps::print_table(json["builds"], kBuilds, out);
  std::fprintf(out, "\n");
  apps::print_table(json["variants"], kVariants, out);
}

std::unique_ptr<core::Scene> ball_of(std::size_t triangles) {
  auto scene = std::make_unique<core::Scene>();
  scene->add_mesh_instance(scene->root(), need(scene->add_mesh(bumpy_ball(triangles))));
  need(scene->commit());
  return scene;
}

/// Answer: Hit or FirstHit.
template <class Answer>
float distance_of(const Answer& hit) {
  return hit.slot != core::kNone ? float(hit.t) : std::numeric_limits<float>::infinity();
}

/// Streams of 256 rays.
template <class Answer>
Variant stream_variant(const char* name, const raytrace::Tracer& tracer, std::span<const core::Ray> rays) {
  return {.name = name, .trace = [&tracer, rays](std::size_t first, std::span<float> t) {
            std::array<Answer, 256> hits;
            for (std::size_t at = 0; at < t.size(); at += hits.size()) {
              const auto some = std::span(hits).first(std::min(hits.size(), t.size() - at));
              if (!tracer.nearest(rays.subspan(first + at, some.size()), some)) return;
              for (std::size_t i = 0; i < some.size(); ++i) t[at + i] = distance_of(some[i]);
            }
          }};
}

std::vector<Variant> own_variants(const raytrace::Tracer& tracer, std::span<const core::Ray> rays) {
  const auto single = [&tracer, rays](std::size_t first, std::span<float> t) {
    for (std::size_t i = 0; i < t.size(); ++i) {
      const auto hit = tracer.nearest(rays[first + i]);
      t[i] = *hit ? distance_of(**hit) : std::numeric_limits<float>::infinity();
    }
  };
  const auto first_hits = [&tracer, rays](std::size_t first, std::span<float> t) {
    for (std::size_t i = 0; i < t.size(); ++i) t[i] = distance_of(*tracer.first(rays[first + i]));
  };
  return {{.name = "Sightline, single", .trace = single},
          {.name = "Sightline, single first hits", .trace = first_hits},
          stream_variant<raytrace::Hit>("Sightline, streams", tracer, rays),
          stream_variant<raytrace::FirstHit>("Sightline, streams of first hits", tracer, rays)};
}

/// Reads what is there, so that it is in the cache.
void read(std::span<const std::byte> bytes) {
  for (std::size_t i = 0; i < bytes.size(); i += 64) {
    [[maybe_unused]] const volatile std::byte one = bytes[i];
  }
}

/// All rays once; `fetch` brings some into the cache.
double pass_ms(const Variant& variant, std::size_t chunk, std::span<float> t,
               const std::function<void(std::size_t first, std::size_t count)>& fetch) {
  double ms = 0.0;
  for (std::size_t first = 0; first < t.size(); first += chunk) {
    const std::size_t count = std::min(chunk, t.size() - first);
    if (count < t.size()) fetch(first, count);
    const double start = processor_milliseconds();
    variant.trace(first, t.subspan(first, count));
    ms += processor_milliseconds() - start;
  }
  return ms;
}

core::Expected<int> run(const Options& options) {
  const bool ball = options.model.files.empty() && options.items == 0;
  const auto scene = ball ? ball_of(options.triangles) : need(model_or_plant(options.model, options.items));
  const core::Snapshot snapshot(*scene);
  std::size_t triangles = 0;
  for (core::Slot slot = 0; slot < snapshot.size(); ++slot)
    if (!snapshot.vacant(slot) && int(snapshot.kind(slot)) >= core::kPrimitiveKindCount)
      triangles += snapshot.mesh(slot).indices.size() / 3;

  core::AabbD shown = snapshot.bounds().fitted_bounds().bounds;
  const dvec3 half = 0.5 / options.zoom * shown.size(), centre = shown.centre();
  shown = {centre - half, centre + half};
  const core::View view =
      need(core::View::fit(shown, core::kOverviewDirection, apps::kFovy, double(options.width) / options.height));
  const std::vector<core::Ray> rays = primary_rays(view, options.width, options.height);

  json::Value json{{"items", snapshot.size()}, {"triangles", triangles}, {"rays", rays.size()}};
  const double begin = milliseconds();
  const raytrace::Tracer tracer = need(raytrace::Tracer::create(snapshot, options.threads));
  json["builds"].push_back({{"name", "Sightline"}, {"ms", milliseconds() - begin}, {"bytes", tracer.memory().total()}});

  std::vector<Variant> variants = own_variants(tracer, rays);
#if SIGHTLINE_HAS_EMBREE
  Peers peers{options.threads};
  if (!options.only.starts_with("Sightline")) add_peers(snapshot, tracer, rays, options, peers, json);
  for (const json::Value& build : peers.builds) json["builds"].push_back(build);
  variants.insert(variants.end(), peers.variants.begin(), peers.variants.end());
#endif
  if (!options.only.empty())
    std::erase_if(variants,
                  [&](const Variant& variant) { return variant.name.find(options.only) == std::string::npos; });
  if (variants.empty()) apps::fail("--only " + options.only + ": no tracer has such a name");
  for (Variant& variant : variants) variant.t.resize(rays.size());
  const auto fetch = [&](std::size_t first, std::size_t count) {
    read(std::as_bytes(std::span(rays).subspan(first, count)));
#if SIGHTLINE_HAS_EMBREE
    if (!peers.rays.empty()) read(std::as_bytes(std::span(peers.rays).subspan(first, count)));
#endif
  };
  const std::size_t chunk = options.chunk > 0 ? options.chunk : rays.size();
  for (int pass = 0; pass < options.passes; ++pass)
    for (Variant& variant : variants) variant.ms = std::min(variant.ms, pass_ms(variant, chunk, variant.t, fetch));
  for (const Variant& variant : variants) {
    std::size_t different = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const float a = variant.t[i], b = variants.front().t[i];
      different += !(a == b || std::abs(a - b) <= 1e-4f * std::abs(b));
    }
    json["variants"].push_back({{"name", variant.name},
                                {"mrays_per_s", double(rays.size()) / 1e3 / variant.ms},
                                {"hits", variant.hits()},
                                {"different", different}});
  }
  return finish(options.json, json::sorted(std::move(json)), print_table);
}

void add_options(apps::CommandLine& line, Options& options) {
  apps::add_model_options(line, options.model);
  line.option("MODEL").required(false);
  line.add("--triangles", options.triangles, "Without MODEL: triangles of a ball with bumps")
      .shows_default()
      .in_range(std::size_t(64), std::size_t(100'000'000));
  line.add("--items", options.items, "Without MODEL: items of a generated plant, instead of a ball")
      .in_range(std::uint64_t(1'000), std::uint64_t(10'000'000));
  line.add("--zoom", options.zoom, "Fit this part of the model's middle: 2 is half of its bounds")
      .shows_default()
      .in_range(1.0, 1000.0);
  line.add("--width", options.width, "Pixels").shows_default().in_range(1, 16384);
  line.add("--height", options.height, "Pixels").shows_default().in_range(1, 16384);
  line.add("--passes", options.passes, "Times that each tracer traces all rays").shows_default().in_range(1, 1000);
  line.add("--chunk", options.chunk, "Rays that are in the cache when they are traced; 0: all are in memory")
      .shows_default()
      .in_range(std::size_t(0), std::size_t(1) << 30);
  line.add("--chord", options.chord, "Deviation of the chords of solids that Embree gets as triangles, pixels")
      .shows_default()
      .in_range(1e-4, 10.0);
  line.add("--only", options.only, "Only tracers whose name has this text, as \"Sightline, streams\"");
  line.add("--threads", options.threads, "Threads that build; one traces").shows_default().in_range(1, 1024);
  apps::add_json_option(line, options.json);
  line.examples(
      "  sightline-bench trace bunny.ply\n"
      "  sightline-bench trace --triangles 3600000 --threads 2\n"
      "  sightline-bench trace --items 100000 --zoom 4\n"
      "  sightline-bench trace --items 10000 --zoom 4 --chord 0.015625    # Embree with finer triangles");
}

}  // namespace
}  // namespace sightline::bench::trace_bench

sightline::bench::Run sightline::bench::add_trace(apps::CommandLine& line) {
  using namespace trace_bench;
  return add_subcommand<Options>(line, add_options, run);
}
