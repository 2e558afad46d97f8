// sightline-bench-intersect: what a ray against one analytic primitive costs on the CPU, for each kind, in double,
// float and (cylinders) vectors. Accuracy is the matter of sightline-stability.
#include <algorithm>
#include <cstdio>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "sightline/apps/common/cli.h"
#include "sightline/bench/harness.h"
#include "sightline/core/instruction_set.h"
#include "sightline/gpuprims/cylinder_rays.h"
#include "sightline/gpuprims/primitives.h"

namespace {

using namespace sightline;
using core::dvec3;
using gpuprims::Ray;
using Json = nlohmann::json;

constexpr float kFullTurn = 6.2831855f;

struct Case {
  const char* name;
  core::Primitive primitive;
  dvec3 half;  ///< of a box about the local origin that holds it
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

/// Rays from 5 to 15 units away in any direction through points of the box.
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

struct Figure {
  double ns = 0.0, hit = 0.0;  ///< per ray; share of rays that hit
};

constexpr int kPasses = 9;

/// Median of the passes of shoot(), which returns the number of rays that hit.
template <class Shoot>
Figure measure(std::size_t rays, const Shoot& shoot) {
  std::vector<double> times;
  std::size_t hit = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    const double start = bench::milliseconds();
    hit = shoot();
    times.push_back((bench::milliseconds() - start) * 1e6 / double(rays));
  }
  return {bench::median(times), double(hit) / double(rays)};
}

template <class Real>
Figure measure_single(const core::Primitive& primitive, const std::vector<Ray>& rays) {
  return measure(rays.size(), [&] {
    std::size_t hit = 0;
    for (const Ray& ray : rays) hit += gpuprims::intersect<Real>(primitive, ray).count > 0;
    return hit;
  });
}

Figure measure_beam(const core::Cylinder& cylinder, const std::vector<Ray>& rays) {
  std::vector<double> values[6], t_min(rays.size(), 0.0), t(rays.size());
  for (const Ray& ray : rays) {
    for (int axis = 0; axis < 3; ++axis) {
      values[axis].push_back(ray.origin[axis]);
      values[3 + axis].push_back(ray.direction[axis]);
    }
  }
  // In portions that stay in the processor's first cache, as a renderer's tiles do.
  constexpr std::size_t kPortion = 256;
  return measure(rays.size(), [&] {
    std::size_t hit = 0;
    for (std::size_t first = 0; first < rays.size(); first += kPortion) {
      const std::size_t count = std::min(kPortion, rays.size() - first);
      const auto at = [&](int i) { return values[i].data() + first; };
      const std::span<double> out(t.data() + first, count);
      gpuprims::first_crossings(cylinder, {{at(0), at(1), at(2)}, {at(3), at(4), at(5)}, count},
                                std::span(t_min).subspan(first, count), {}, out);
      for (const double value : out) hit += value < std::numeric_limits<double>::infinity();
    }
    return hit;
  });
}

Json report(const char* name, const char* path, const Figure& figure) {
  std::printf("%-26s %-8s %8.1f %7.3f\n", name, path, figure.ns, figure.hit);
  return {{"primitive", name}, {"path", path}, {"ns_per_ray", figure.ns}, {"hit_share", figure.hit}};
}

core::Expected<int> run(std::size_t count, const std::string& json) {
  std::printf("%zu rays a case, median of %d passes\n%-26s %-8s %8s %7s\n", count, kPasses, "primitive", "path",
              "ns/ray", "hit");
  Json rows = Json::array();
  for (const Case& c : kCases) {
    const std::vector<Ray> rays = generic_rays(count, c.half);
    rows.push_back(report(c.name, "double", measure_single<double>(c.primitive, rays)));
    rows.push_back(report(c.name, "float", measure_single<float>(c.primitive, rays)));
    const auto* cylinder = std::get_if<core::Cylinder>(&c.primitive);
    if (cylinder == nullptr) continue;
    for (const auto set : {core::InstructionSet::kScalar, core::InstructionSet::kAvx2, core::InstructionSet::kAvx512}) {
      if (!core::supported(set)) continue;
      core::force_instruction_set(set);
      rows.push_back(report("cylinder, many rays", core::name_of(set), measure_beam(*cylinder, rays)));
    }
    core::force_instruction_set(std::nullopt);
  }
  if (json.empty()) return apps::kExitOk;
  if (auto done = apps::write_text(json, apps::to_text(Json{{"rays", count}, {"cases", rows}})); !done)
    return tl::unexpected(done.error());
  return apps::kExitOk;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("What a ray against one analytic primitive costs on the CPU", "sightline-bench-intersect");
  apps::describe(app,
                 "  sightline-bench-intersect\n"
                 "  sightline-bench-intersect --rays 1000000 --json intersect.json\n");
  std::size_t rays = 100'000;
  std::string json;
  app.add_option("--rays", rays, "Rays of each case")->check(CLI::Range(1000, 100'000'000))->capture_default_str();
  app.add_option("--json", json, "Figures to a file, or - for stdout");
  return apps::run(app, argc, argv, [&] { return run(rays, json); });
}
