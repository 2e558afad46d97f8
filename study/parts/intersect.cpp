// sightline-study intersect: CPU cost of a ray against one analytic primitive, for each kind.
// sightline-stability measures accuracy.
#include <random>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "sightline/apps/bench/microbenchmarks.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/study/parts/parts.h"

namespace sightline::bench::intersect_bench {
namespace {

using core::dvec3;
using gpuprims::Ray;

struct Options {
  std::size_t rays = 100'000;
  MicrobenchmarkOptions microbenchmarks;
};

constexpr float kFullTurn = 6.2831855f;

struct Case {
  const char* name;
  core::Primitive primitive;
  dvec3 half;  ///< half extents of a box about the local origin that contains it
};
const Case kCases[] = {
    {"cylinder", core::Cylinder{1, 2}, {1, 1, 1}},
    {"snout", core::Snout{1, 0.5f, 2, 0, 0, 0, 0, 0, 0}, {1, 1, 1}},
    {"snout, slanted", core::Snout{1, 0.5f, 2, 0.3f, 0, 0.1f, 0, 0, 0.2f}, {1.2, 1, 1.2}},
    {"circular torus", core::CircularTorus{1, 0.3f, kFullTurn}, {1.3, 1.3, 0.3}},
    {"circular torus, slice", core::CircularTorus{1, 0.3f, 2}, {1.3, 1.3, 0.3}},
    {"rectangular torus", core::RectangularTorus{0.7f, 1.3f, 0.6f, kFullTurn}, {1.3, 1.3, 0.3}},
    {"rectangular torus, slice", core::RectangularTorus{0.7f, 1.3f, 0.6f, 2}, {1.3, 1.3, 0.3}},
    {"sphere", core::Sphere{2}, {1, 1, 1}},
    {"spherical dish", core::SphericalDish{1, 0.4f}, {1, 1, 0.4}},
    {"elliptical dish", core::EllipticalDish{1, 0.5f}, {1, 1, 0.5}},
    {"box", core::Box{2, 2, 2}, {1, 1, 1}},
    {"pyramid", core::Pyramid{2, 2, 1, 1, 0.3f, 0, 2}, {1.2, 1, 1}},
};

/// Rays through points of the box, in any direction, from 5 to 15 units away.
std::vector<Ray> generic_rays(std::size_t count, const dvec3& half) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> side(-1.0, 1.0);
  const auto vector = [&] {
    const double x = side(random), y = side(random);
    return dvec3(x, y, side(random));
  };
  std::vector<Ray> rays;
  while (rays.size() < count) {
    const dvec3 direction = vector(), target = half * vector();
    const double length = glm::length(direction);
    if (!(length > 0.1 && length <= 1.0)) continue;
    rays.push_back({target - (10.0 + 5.0 * side(random)) / length * direction, direction / length});
  }
  return rays;
}

/// Times shoot(), which returns the number of rays that hit. Counters: time per ray, and share of rays that hit.
template <class Shoot>
void measure(benchmark::State& state, std::size_t rays, const Shoot& shoot) {
  std::size_t hit = 0;
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(hit = shoot());
  state.counters["per ray"] =
      benchmark::Counter(double(rays), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["hit"] = double(hit) / double(rays);
}

void measure_single(benchmark::State& state, const core::Primitive& primitive, const std::vector<Ray>& rays) {
  measure(state, rays.size(), [&] {
    std::size_t hit = 0;
    for (const Ray& ray : rays) hit += gpuprims::intersect(primitive, ray).count > 0;
    return hit;
  });
}

template <class Measure>
void add(const std::string& name, const Measure& measure) {
  benchmark::RegisterBenchmark(name.c_str(), measure)->Unit(benchmark::kMillisecond);
}

core::Expected<int> run(const Options& options) {
  for (const Case& c : kCases) {
    const std::vector<Ray> rays = generic_rays(options.rays, c.half);
    const std::string name = c.name;
    add(name + "/double", [=, &c](benchmark::State& s) { measure_single(s, c.primitive, rays); });
  }
  return run_microbenchmarks(options.microbenchmarks);
}

void add_options(apps::CommandLine& line, Options& options) {
  line.add("--rays", options.rays, "Rays of each case").in_range(1000, 100'000'000).shows_default();
  add_microbenchmark_options(line, options.microbenchmarks);
  line.examples(
      "  sightline-study intersect\n"
      "  sightline-study intersect --rays 1000000 --filter torus --json intersect.json");
}

}  // namespace
}  // namespace sightline::bench::intersect_bench

sightline::bench::Run sightline::bench::add_intersect(apps::CommandLine& line) {
  using namespace intersect_bench;
  return add_subcommand<Options>(line, add_options, run);
}
