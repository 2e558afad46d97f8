// sightline-bench queries: compares spatial queries through the hierarchy with a loop over all boxes.
//
// A time is the median over random queries of a kind. Every tenth answer is compared.
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/models/plant_boxes.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/table.h"
#include "sightline/core/item_bounds.h"
#include "sightline/culling/queries/spatial_queries.h"

namespace sightline::bench::queries_bench {
namespace {

using core::Ray;
using culling::SpatialQueries;
using Slots = std::vector<core::Slot>;
using Hits = std::vector<culling::SlotDistance>;

struct Options {
  std::size_t count = 713'000;
  std::string json;
};

/// Places of random queries, the same for every kind.
class Places {
 public:
  explicit Places(std::uint64_t seed) : random_(seed) {}

  core::dvec3 point() {
    const double x = 400.0 * unit(), y = 100.0 * unit();
    return {x, y, 60.0 * unit()};
  }
  core::AabbD box(double size) {
    const core::dvec3 at = point();
    return {at - 0.5 * size, at + 0.5 * size};
  }
  Ray ray() {
    const core::dvec3 from = point();
    return {from, glm::normalize(point() - from)};
  }

 private:
  double unit() { return std::uniform_real_distribution<double>(0.0, 1.0)(random_); }
  std::mt19937_64 random_;
};

class Suite {
 public:
  explicit Suite(const core::ItemBounds& bounds)
      : hierarchy_(bounds), queries_(bounds, hierarchy_), linear_(bounds, none_) {}

  /// `place(places)` makes a query's argument, and ask(queries, argument, answer) runs the query. Fails when the
  /// hierarchy's answer differs from that of the loop over all boxes.
  template <class Answer, class Place, class Ask>
  void add(const char* name, const Place& place, const Ask& ask) {
    constexpr std::size_t kQueries = 400, kComparedEvery = 10;
    Places places(1);
    std::vector<decltype(place(places))> arguments;
    for (std::size_t i = 0; i < kQueries; ++i) arguments.push_back(place(places));
    Answer answer, expected;
    double found = 0.0;
    for (std::size_t i = 0; i < kQueries; ++i) {
      ask(queries_, arguments[i], answer);
      found += double(answer.size()) / double(kQueries);
      if (i % kComparedEvery != 0) continue;
      ask(linear_, arguments[i], expected);
      if (answer != expected) apps::fail(std::string(name) + ": the loop over all boxes gives another answer");
    }
    const auto median_us = [&](const SpatialQueries& queries) {
      return 1e3 * apps::median(time_path(kQueries, [&](std::size_t i) { ask(queries, arguments[i], answer); }));
    };
    const double hierarchy = median_us(queries_), linear = median_us(linear_);
    rows_.push_back({{"query", name},
                     {"found", found},
                     {"hierarchy_us", hierarchy},
                     {"linear_us", linear},
                     {"ratio", linear / hierarchy}});
  }

  const json::Value& rows() const { return rows_; }

 private:
  culling::Hierarchy hierarchy_;
  const culling::Hierarchy none_;
  SpatialQueries queries_, linear_;
  json::Value rows_ = json::Value::array();
};

constexpr apps::Column kColumns[] = {{"query", "query"},
                                     {"found, mean", "found", "{:.1f}"},
                                     {"hierarchy, us", "hierarchy_us", "{:.2f}"},
                                     {"linear, us", "linear_us", "{:.1f}"},
                                     {"ratio", "ratio", "{:.0f}"}};

core::Expected<int> run(const Options& options) {
  const core::ItemBounds bounds = in_production_order(PlantBoxes(1).make(options.count));
  const std::uint32_t layers = core::kDefaultLayerMask;
  const auto box = [](double size) { return [size](Places& places) { return places.box(size); }; };
  const auto point = [](Places& places) { return places.point(); };
  const auto ray = [](Places& places) { return places.ray(); };
  using Box = core::AabbD;
  using Point = core::dvec3;
  const auto intersecting = [=](const SpatialQueries& q, const Box& b, Slots& out) { q.intersecting(b, layers, out); };
  const auto inside = [=](const SpatialQueries& q, const Box& b, Slots& out) { q.inside(b, layers, out); };
  const auto around = [=](const SpatialQueries& q, const Point& p, Slots& out) { q.around(p, 1.0, layers, out); };
  const auto along = [=](const SpatialQueries& q, const Ray& r, Hits& out) { q.along(r, layers, out); };
  const auto first = [=](std::size_t n) {
    return [=](const SpatialQueries& q, const Ray& r, Hits& out) { q.first_along(r, n, layers, out); };
  };
  const auto nearest = [=](std::size_t n) {
    return [=](const SpatialQueries& q, const Point& p, Hits& out) { q.nearest(p, n, layers, out); };
  };

  Suite suite(bounds);
  suite.add<Slots>("intersecting a box of 2 m", box(2.0), intersecting);
  suite.add<Slots>("intersecting a box of 20 m", box(20.0), intersecting);
  suite.add<Slots>("inside a box of 20 m", box(20.0), inside);
  suite.add<Slots>("within 1 m of a point", point, around);
  suite.add<Hits>("along a ray, all", ray, along);
  suite.add<Hits>("along a ray, first", ray, first(1));
  suite.add<Hits>("along a ray, first 16", ray, first(16));
  suite.add<Hits>("nearest", point, nearest(1));
  suite.add<Hits>("nearest 16", point, nearest(16));
  return finish(options.json, {{"boxes", options.count}, {"queries", suite.rows()}},
                [](const json::Value& all, std::FILE* out) { apps::print_table(all["queries"], kColumns, out); });
}

void add_options(apps::CommandLine& line, Options& options) {
  add_generate_option(line, options.count).shows_default();
  apps::add_json_option(line, options.json);
  line.examples("  sightline-bench queries --generate 713000 --json queries.json");
}

}  // namespace
}  // namespace sightline::bench::queries_bench

sightline::bench::Run sightline::bench::add_queries(apps::CommandLine& line) {
  using namespace queries_bench;
  return add_subcommand<Options>(line, add_options, run);
}
