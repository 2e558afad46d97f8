#include "sightline/apps/study/rays/benchmark.h"

#include <algorithm>
#include <cmath>
#include <ctime>

namespace sightline::study::rays {
namespace {

using core::dvec3;
using Rays = std::vector<Ray>;

/// The sphere around the box around all triangles.
struct Sphere {
  dvec3 centre;
  double radius;
  explicit Sphere(const UnitSpace& space) {
    const dvec3 low = space.corner + space.size * dvec3(space.bounds.min);
    const dvec3 high = space.corner + space.size * dvec3(space.bounds.max);
    centre = 0.5 * (low + high);
    radius = 0.5 * glm::length(high - low);
  }
};

/// Where a ray hit: a point slightly before the surface, and the normal on that side.
struct Start {
  dvec3 point, normal, incoming;
};
std::vector<Start> starts_of(const TriangleSet& triangles, const Rays& rays, const std::vector<Hit>& hits) {
  std::vector<Start> starts;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!hits[i]) continue;
    const auto& c = triangles.corners(hits[i].triangle);
    const dvec3 a(c[0]), normal = glm::normalize(glm::cross(dvec3(c[1]) - a, dvec3(c[2]) - a));
    const dvec3 direction = glm::normalize(rays[i].direction);
    const dvec3 to_eye = glm::dot(normal, direction) < 0.0 ? normal : -normal;
    const dvec3 point = rays[i].origin + hits[i].t * rays[i].direction;
    starts.push_back({point + 1e-6 * triangles.space().size * to_eye, to_eye, direction});
  }
  return starts;
}

double seconds_now() {
  return double(std::clock()) / CLOCKS_PER_SEC;
}

/// Hits found, so that no compiler drops the search.
std::size_t search(const Traversal& traversal, const Structures& structures, const Rays& rays, bool any) {
  std::size_t hits = 0;
  if (any)
    for (const Ray& ray : rays) hits += traversal.any(structures, ray);
  else
    for (const Ray& ray : rays) hits += bool(traversal.nearest(structures, ray));
  return hits;
}

double balance(const std::vector<std::uint32_t>& visits, const Image& image, int tile_width, int tile_height) {
  constexpr std::size_t kDevices = 4;
  std::array<double, kDevices> load{};
  const int tiles_across = (image.width + tile_width - 1) / tile_width;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::size_t tile = std::size_t(y / tile_height) * std::size_t(tiles_across) + std::size_t(x / tile_width);
      load[tile % kDevices] += visits[std::size_t(y) * std::size_t(image.width) + std::size_t(x)];
    }
  const double most = *std::max_element(load.begin(), load.end());
  return most == 0.0 ? 1.0 : (load[0] + load[1] + load[2] + load[3]) / (double(kDevices) * most);
}

/// Runs the primary rays with counters. Fills `hits` if it is empty, and otherwise compares with it.
void count_visits(TraversalRun& run, const Structures& structures, const Rays& rays, const Image& image,
                  std::vector<Hit>& hits) {
  const bool first = hits.empty();
  std::vector<std::uint32_t> visits(rays.size());
  Counters sum;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::uint64_t before = sum.nodes;
    const Hit hit = run.traversal->count(structures, rays[i], sum);
    visits[i] = std::uint32_t(sum.nodes - before);
    if (first)
      hits.push_back(hit);
    else
      run.disagreements += hit != hits[i];
  }
  run.nodes = double(sum.nodes) / double(rays.size());
  run.triangles = double(sum.triangles) / double(rays.size());
  run.lanes_rows = lanes_at_work(visits, image, 32, 1);
  run.lanes_tiles = lanes_at_work(visits, image, 8, 4);
  run.balance_rows = balance(visits, image, image.width, 1);
  run.balance_tiles = balance(visits, image, 32, 32);
}

double time_brute_force(const TriangleSet& triangles, const Rays& rays) {
  constexpr std::size_t kFew = 16;
  const double start = seconds_now();
  std::size_t hits = 0, number = 0;
  for (std::size_t i = 0; i < rays.size(); i += rays.size() / kFew + 1, ++number)
    hits += bool(triangles.brute_force(rays[i]));
  return hits > number ? 0.0 : (seconds_now() - start) * 1e9 / double(number);
}

}  // namespace

double lanes_at_work(const std::vector<std::uint32_t>& visits, const Image& image, int width, int height) {
  double busy = 0.0, paid = 0.0;
  for (int y0 = 0; y0 < image.height; y0 += height)
    for (int x0 = 0; x0 < image.width; x0 += width) {
      std::uint32_t most = 0;
      for (int y = y0; y < std::min(y0 + height, image.height); ++y)
        for (int x = x0; x < std::min(x0 + width, image.width); ++x) {
          const std::uint32_t v = visits[std::size_t(y) * std::size_t(image.width) + std::size_t(x)];
          most = std::max(most, v);
          busy += v;
        }
      paid += double(most) * width * height;
    }
  return paid == 0.0 ? 1.0 : busy / paid;
}

std::vector<Ray> primary_rays(const UnitSpace& space, const Image& image) {
  constexpr double kTanHalfFovy = 0.41421356237309503;  // of 45 degrees
  const Sphere around(space);
  const dvec3 back = glm::normalize(dvec3(0.55, -0.7, 0.45));
  const dvec3 right = glm::normalize(glm::cross(dvec3(0, 0, 1), back)), up = glm::cross(back, right);
  const dvec3 eye = around.centre + 1.9 * around.radius * back;
  Rays rays;
  rays.reserve(std::size_t(image.width) * std::size_t(image.height));
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const double across = (2.0 * x + 1.0 - image.width) / image.height;
      const double upwards = 1.0 - (2.0 * y + 1.0) / image.height;
      rays.push_back({eye, kTanHalfFovy * (across * right + upwards * up) - back});
    }
  return rays;
}

dvec3 light_over(const UnitSpace& space, double turned) {
  const Sphere around(space);
  const dvec3 aside(std::cos(turned) - 0.5 * std::sin(turned), std::sin(turned) + 0.5 * std::cos(turned), 2.0);
  return around.centre + around.radius * aside;
}

std::vector<Ray> shadow_rays(const TriangleSet& triangles, const std::vector<Ray>& rays, const std::vector<Hit>& hits,
                             const dvec3& light) {
  Rays shadows;
  for (const Start& s : starts_of(triangles, rays, hits)) shadows.push_back({s.point, light - s.point, 1.0});
  return shadows;
}

const char* name_of(RayKind kind) {
  constexpr std::array<const char*, kRayKinds> kNames = {"primary", "reflected", "shadow"};
  return kNames[std::size_t(kind)];
}

const TraversalRun* Benchmark::find(const std::string& traversal) const {
  for (const TraversalRun& run : traversals)
    if (run.traversal->name == traversal) return &run;
  return nullptr;
}

core::Expected<Benchmark> run_benchmark(const std::string& model, const TriangleSet& triangles, const Image& image,
                                        int passes, const std::function<void(const std::string&)>& step,
                                        const BenchmarkHook& then) {
  step("building");
  const Structures structures(triangles);
  Benchmark result{model, triangles.size(), {}, 0.0, 0.0, {}, {}};
  for (std::size_t i = 0; i < kStructures; ++i)
    result.structures.push_back({Structure(i), structures.bytes(Structure(i)), structures.build_seconds[i]});

  BenchmarkRays searched{image, {primary_rays(triangles.space(), image), {}, {}}, {}};
  std::array<Rays, kRayKinds>& rays = searched.rays;
  std::vector<Hit>& hits = searched.hits;
  for (const Traversal& traversal : traversals()) {
    step(std::string("counting, ") + traversal.name);
    result.traversals.push_back({&traversal, {}, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, std::nullopt});
    count_visits(result.traversals.back(), structures, rays[0], image, hits);
  }
  for (const Start& s : starts_of(triangles, rays[0], hits))
    rays[1].push_back({s.point, s.incoming - 2.0 * glm::dot(s.incoming, s.normal) * s.normal});
  rays[2] = shadow_rays(triangles, rays[0], hits, light_over(triangles.space()));
  result.hits = double(rays[1].size()) / double(rays[0].size());
  result.brute_force_ns = time_brute_force(triangles, rays[0]);

  for (std::size_t kind = 0; kind < kRayKinds; ++kind) {
    result.rays[kind] = rays[kind].size();
    for (int pass = 0; pass < passes && !rays[kind].empty(); ++pass) {
      std::size_t found = 0;
      for (TraversalRun& run : result.traversals) {
        step(std::string(name_of(RayKind(kind))) + " rays, " + run.traversal->name);
        const double start = seconds_now();
        const std::size_t n = search(*run.traversal, structures, rays[kind], RayKind(kind) == RayKind::kShadow);
        const double ns = (seconds_now() - start) * 1e9 / double(rays[kind].size());
        run.ns[kind] = pass == 0 ? ns : std::min(run.ns[kind], ns);
        if (&run == &result.traversals.front()) found = n;
        run.disagreements += n > found ? n - found : found - n;
      }
    }
  }
  if (then)
    if (auto done = then(structures, searched, result); !done) return tl::unexpected(done.error());
  return result;
}

}  // namespace sightline::study::rays
