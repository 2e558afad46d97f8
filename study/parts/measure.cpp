// sightline-study measure: what a distance between two items and a snap cost.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "sightline/analysis/measure/distances.h"
#include "sightline/analysis/measure/snap.h"
#include "sightline/apps/bench/harness.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/study/parts/parts.h"

namespace sightline::bench::measure_bench {
namespace {

using Json = json::Value;
using core::dvec3;
using measure::Item;

constexpr std::size_t kPairs = 500;
constexpr int kMeshRings = 72;  // 20,448 triangles

struct Options {
  int rounds = 5;
  std::string json;
};

/// A closed ball.
core::Mesh ball_mesh(int rings, float radius) {
  core::Mesh mesh;
  const int around = 2 * rings;
  const auto index = [&](int i, int j) { return std::uint32_t(i * around + j % around); };
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j < around; ++j) {
      const double polar = core::kFullTurn / 2 * i / rings, turn = core::kFullTurn * j / around;
      const double flat = i == 0 || i == rings ? 0.0 : std::sin(polar);
      mesh.positions.emplace_back(dvec3(flat * std::cos(turn), flat * std::sin(turn), std::cos(polar)) *
                                  double(radius));
      if (i > 0 && i < rings) mesh.indices.insert(mesh.indices.end(), {index(i, j), index(i + 1, j), index(i, j + 1)});
      if (i + 1 < rings)
        mesh.indices.insert(mesh.indices.end(), {index(i, j + 1), index(i + 1, j), index(i + 1, j + 1)});
    }
  return mesh;
}

/// Items of one kind in random places of a box of 6 m, 1,000 km from the origin. Meshes share one shape in two places,
/// since preparing them takes long.
class Places {
 public:
  Item item(const std::string& name) {
    if (name == "pipe") return primitive(core::Cylinder{0.1f, 4.0f});
    if (name == "bend") return primitive(core::CircularTorus{0.3f, 0.1f, 1.5707964f});
    if (name == "box") return primitive(core::Box{0.5f, 0.7f, 0.9f});
    if (name == "reducer") return primitive(core::Snout{0.2f, 0.1f, 0.3f, 0.1f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f});
    if (name == "dish") return primitive(core::EllipticalDish{0.5f, 0.25f});
    return *Item::create(ball_mesh(kMeshRings, 0.5f), placement());
  }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  dvec3 direction() {
    const double z = uniform(-1, 1), turn = uniform(0, core::kFullTurn), flat = std::sqrt(1 - z * z);
    return {flat * std::cos(turn), flat * std::sin(turn), z};
  }

 private:
  core::Affine placement() {
    const dvec3 z = direction(), x = glm::normalize(glm::cross(z, direction()));
    return {{x, glm::cross(z, x), z}, dvec3(1e6, 0, 0) + dvec3(uniform(-3, 3), uniform(-3, 3), uniform(-3, 3))};
  }
  Item primitive(const core::Primitive& p) { return *Item::create(p, placement()); }

  std::mt19937_64 random_{1};
};

/// Microseconds of each of call(0) … call(count - 1): the least of all rounds.
template <class Call>
Json times_of(const std::string& name, std::size_t count, int rounds, const Call& call) {
  std::vector<double> least(count, std::numeric_limits<double>::infinity());
  for (int round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < count; ++i) {
      const double start = milliseconds();
      call(i);
      least[i] = std::min(least[i], 1e3 * (milliseconds() - start));
    }
  return {{"call", name}, {"us", apps::to_json(apps::summarise(least))}};
}

Json measure_distances(const std::string& a, const std::string& b, int rounds) {
  Places places;
  const bool slow = a == "mesh" && b == "mesh";
  const std::size_t count_a = a == "mesh" ? 1 : kPairs, count_b = b == "mesh" ? slow ? 20 : 1 : kPairs;
  std::vector<Item> items_a, items_b;
  for (std::size_t i = 0; i < count_a; ++i) items_a.push_back(places.item(a));
  for (std::size_t i = 0; i < count_b; ++i) items_b.push_back(places.item(b));
  std::size_t touching = 0;
  double error = 0.0;
  const std::size_t count = std::max(count_a, count_b);
  const auto pair = [&](std::size_t i) { return measure::distance(items_a[i % count_a], items_b[i % count_b]); };
  for (std::size_t i = 0; i < count; ++i) {
    const measure::Distance d = pair(i);
    touching += d.touching ? 1 : 0;
    error = std::max(error, d.error);
  }
  double sum = 0.0;
  Json row = times_of("distance: " + a + " to " + b, count, rounds, [&](std::size_t i) { sum += pair(i).distance; });
  row["pairs"] = count;
  row["touching"] = touching;
  row["largest_error"] = error;
  row["mean_distance"] = sum / double(count * std::size_t(rounds));
  return row;
}

/// Eyes look at points near a feature of the item, or near the surface of a mesh.
Json measure_snaps(const std::string& name, bool cut, int rounds) {
  Places places;
  std::vector<Item> items;
  const std::size_t count = kPairs, different = name == "mesh" ? 1 : kPairs;
  for (std::size_t i = 0; i < different; ++i) items.push_back(places.item(name));
  std::vector<measure::Aim> aims;
  for (std::size_t i = 0; i < count; ++i) {
    const dvec3 outside = dvec3(1e6, 0, 0) + 8.0 * places.direction();
    // A pick stands in for the ray tracer's: the nearest point of the item.
    const dvec3 point = measure::distance(outside, items[i % different]).to;
    const dvec3 eye = point + 5.0 * glm::normalize(outside - point);
    aims.push_back({point, 0.0, measure::AimRay{eye, glm::normalize(point - eye), 0.01}});
  }
  std::vector<core::Plane> planes;
  if (cut) planes = {{{0, 0, 1}, 1.0}, {{-1, 0, 0}, 1e6 + 1.0}};
  std::size_t found = 0;
  const auto snap = [&](std::size_t i) { return measure::snap(items[i % different], aims[i], planes); };
  for (std::size_t i = 0; i < count; ++i) found += snap(i) ? 1 : 0;
  Json row = times_of("snap: " + name + (cut ? ", 2 sections" : ""), count, rounds, snap);
  row["found"] = found;
  return row;
}

void print(const Json& json, std::FILE* out) {
  std::fprintf(out, "%-28s %9s %9s %9s %9s\n", "us a call", "median", "mean", "p99", "max");
  for (const Json& row : json["rows"]) {
    const Json& us = row["us"];
    std::fprintf(out, "%-28s %9.2f %9.2f %9.2f %9.2f", row["call"].get<std::string>().c_str(),
                 us["median"].get<double>(), us["mean"].get<double>(), us["p99"].get<double>(),
                 us["max"].get<double>());
    if (row.contains("touching"))
      std::fprintf(out, "  %zu of %zu touch, error <= %.1e m", row["touching"].get<std::size_t>(),
                   row["pairs"].get<std::size_t>(), row["largest_error"].get<double>());
    if (row.contains("found")) std::fprintf(out, "  %zu found", row["found"].get<std::size_t>());
    std::fprintf(out, "\n");
  }
}

core::Expected<int> run(const Options& options) {
  Json json{{"rounds", options.rounds}, {"rows", Json::array()}};
  Json& rows = json["rows"];
  constexpr const char* kPairsOfKinds[][2] = {{"box", "box"},   {"pipe", "pipe"}, {"reducer", "dish"},
                                              {"pipe", "bend"}, {"bend", "bend"}, {"bend", "box"},
                                              {"pipe", "mesh"}, {"bend", "mesh"}, {"mesh", "mesh"}};
  for (const auto& [a, b] : kPairsOfKinds) rows.push_back(measure_distances(a, b, options.rounds));
  for (const char* name : {"box", "pipe", "bend", "mesh"})
    for (const bool cut : {false, true}) rows.push_back(measure_snaps(name, cut, options.rounds));
  const core::Mesh mesh = ball_mesh(kMeshRings, 0.5f);
  rows.push_back(times_of("prepare a mesh", 5, options.rounds, [&](std::size_t) { return Item::create(mesh, {}); }));
  return finish(options.json, json, print);
}

void add_options(apps::CommandLine& line, Options& options) {
  line.add("--rounds", options.rounds, "the least time of so many rounds counts").in_range(1, 1000).shows_default();
  apps::add_json_option(line, options.json);
  line.examples(
      "  sightline-study measure\n"
      "  sightline-study measure --rounds 20 --json measure.json");
}

}  // namespace
}  // namespace sightline::bench::measure_bench

sightline::bench::Run sightline::bench::add_measure(apps::CommandLine& line) {
  using namespace measure_bench;
  return add_subcommand<Options>(line, add_options, run);
}
