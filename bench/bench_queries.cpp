// sightline-bench-queries: spatial queries through the hierarchy against a loop over all boxes.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "sightline/apps/common/cli.h"
#include "sightline/bench/harness.h"
#include "sightline/bench/models/plant_boxes.h"
#include "sightline/core/item_bounds.h"
#include "sightline/culling/spatial_queries.h"

namespace {

using namespace sightline;
using Random = std::mt19937_64;

double microseconds() {
  return 1e3 * bench::milliseconds();
}

core::dvec3 in_plant(Random& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double x = 400.0 * unit(random), y = 100.0 * unit(random);
  return {x, y, 60.0 * unit(random)};
}

/// Times ask(queries, sample) through the hierarchy and without one, in turns, and prints a row. False when the answers
/// differ.
template <class Answer, class Ask>
bool compare(const char* what, const core::ItemBounds& bounds, const culling::Hierarchy& hierarchy, const Ask& ask) {
  constexpr std::uint64_t kQueries = 400, kLinearEvery = 10;
  const culling::Hierarchy none;
  const culling::SpatialQueries queries(bounds, hierarchy), linear(bounds, none);
  std::vector<Answer> answer, expected;
  std::vector<double> times, linear_times;
  double found = 0.0;
  for (std::uint64_t sample = 0; sample < kQueries; ++sample) {
    Random random(sample);
    random.discard(1);  // fills its state
    const double start = microseconds();
    ask(queries, random, answer);
    times.push_back(microseconds() - start);
    found += double(answer.size()) / double(kQueries);
    if (sample % kLinearEvery != 0) continue;
    random.seed(sample);
    random.discard(1);
    const double linear_start = microseconds();
    ask(linear, random, expected);
    linear_times.push_back(microseconds() - linear_start);
    if (answer != expected) return false;
  }
  const double time = bench::median(times), linear_time = bench::median(linear_times);
  std::printf("%-34s %10.1f %10.2f %10.1f %8.0f\n", what, found, time, linear_time, linear_time / time);
  return true;
}

bool measure(std::size_t count) {
  using culling::SlotDistance;
  using culling::SpatialQueries;
  const core::ItemBounds bounds = bench::in_production_order(bench::PlantBoxes(1).make(count));
  const culling::Hierarchy hierarchy(bounds);
  const auto layers = core::kDefaultLayerMask;
  std::printf("%zu boxes; medians in microseconds\n%-34s %10s %10s %10s %8s\n", count, "query", "found", "hierarchy",
              "linear", "ratio");
  const auto range = [](Random& random, double half) {
    const core::dvec3 at = in_plant(random);
    return core::AabbD{at - half, at + half};
  };
  const auto ray = [](Random& random) {
    const core::dvec3 from = in_plant(random);
    return culling::RaySegment{from, glm::normalize(in_plant(random) - from)};
  };
  using Slots = std::vector<core::Slot>;
  using Hits = std::vector<SlotDistance>;
  const auto slots = [&](const char* what, const auto& ask) {
    return compare<core::Slot>(what, bounds, hierarchy, ask);
  };
  const auto hits = [&](const char* what, const auto& ask) {
    return compare<SlotDistance>(what, bounds, hierarchy, ask);
  };
  return slots("intersecting a box of 2 m",
               [&](const SpatialQueries& q, Random& r, Slots& out) { q.intersecting(range(r, 1.0), layers, out); }) &&
         slots("intersecting a box of 20 m",
               [&](const SpatialQueries& q, Random& r, Slots& out) { q.intersecting(range(r, 10.0), layers, out); }) &&
         slots("inside a box of 20 m",
               [&](const SpatialQueries& q, Random& r, Slots& out) { q.inside(range(r, 10.0), layers, out); }) &&
         slots("within 1 m of a point",
               [&](const SpatialQueries& q, Random& r, Slots& out) { q.around(in_plant(r), 1.0, layers, out); }) &&
         hits("along a ray, all",
              [&](const SpatialQueries& q, Random& r, Hits& out) { q.along(ray(r), layers, out); }) &&
         hits("along a ray, first",
              [&](const SpatialQueries& q, Random& r, Hits& out) { q.first_along(ray(r), 1, layers, out); }) &&
         hits("along a ray, first 16",
              [&](const SpatialQueries& q, Random& r, Hits& out) { q.first_along(ray(r), 16, layers, out); }) &&
         hits("nearest",
              [&](const SpatialQueries& q, Random& r, Hits& out) { q.nearest(in_plant(r), 1, layers, out); }) &&
         hits("nearest 16",
              [&](const SpatialQueries& q, Random& r, Hits& out) { q.nearest(in_plant(r), 16, layers, out); });
}

void add_options(CLI::App& app, std::size_t& count) {
  app.add_option("--generate", count, "so many boxes of a made-up plant of 400 x 100 x 60 m")
      ->check(CLI::Range(1, 50'000'000))
      ->capture_default_str();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Spatial queries through the hierarchy against a loop over all boxes.", "sightline-bench-queries"};
  apps::describe(app, "  sightline-bench-queries --generate 713000");
  std::size_t count = 713'000;
  add_options(app, count);
  return apps::run(app, argc, argv, [&]() -> core::Expected<int> {
    if (!measure(count)) return core::fail("an answer differs from that of the loop over all boxes");
    return apps::kExitOk;
  });
}
