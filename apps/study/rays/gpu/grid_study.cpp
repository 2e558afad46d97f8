#include "sightline/apps/study/rays/gpu/grid_study.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>

#include "sightline/apps/study/rays/gpu/benchmark.h"

namespace sightline::study::rays {
namespace {

using core::vec3;

// --- scenes ----------------------------------------------------------------------------------------------------------

void add(GeneratedMesh& mesh, const GeneratedMesh& part, float scale, const vec3& at) {
  const std::uint32_t first = std::uint32_t(mesh.positions.size());
  for (const vec3& p : part.positions) mesh.positions.push_back(scale * p + at);
  for (const std::uint32_t i : part.indices) mesh.indices.push_back(first + i);
}

/// A ball of 2 * around * (up - 1) triangles, radius 1.
GeneratedMesh ball(std::uint32_t around, std::uint32_t up) {
  constexpr double kPi = std::numbers::pi;
  GeneratedMesh mesh;
  for (std::uint32_t j = 0; j <= up; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double v = kPi * j / up, u = 2.0 * kPi * i / around;
      mesh.positions.push_back(vec3(core::dvec3(std::sin(v) * std::cos(u), std::sin(v) * std::sin(u), std::cos(v))));
    }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return j * around + i % around; };
  for (std::uint32_t j = 0; j < up; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      if (j > 0) mesh.indices.insert(mesh.indices.end(), {at(i, j), at(i, j + 1), at(i + 1, j)});
      if (j + 1 < up) mesh.indices.insert(mesh.indices.end(), {at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  return mesh;
}

/// Twelve triangles, half edges of 1.
GeneratedMesh box() {
  GeneratedMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back({i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f});
  for (std::uint32_t axis = 0; axis < 3; ++axis)
    for (std::uint32_t side = 0; side < 2; ++side) {
      const std::uint32_t u = 1u << (axis + 1) % 3, v = 1u << (axis + 2) % 3, corner = side << axis;
      mesh.indices.insert(mesh.indices.end(), {corner, corner + u, corner + v, corner + u, corner + u + v, corner + v});
    }
  return mesh;
}

/// PRI: a sphere beside a box.
GridScene sphere_and_box(const std::string& name, std::uint32_t around, std::uint32_t up) {
  GridScene scene{name, "5.6", {}, 2, {1, 2, 4, 6, 10, 15}};
  add(scene.mesh, ball(around, up), 1.0f, {-1.1f, 0.0f, 0.0f});
  add(scene.mesh, box(), 0.9f, {1.1f, 0.0f, 0.0f});
  return scene;
}

/// DIST: nine objects over a ground that is always the same.
GridScene nine_objects(const std::string& name, const std::array<vec3, 9>& places) {
  GridScene scene{name, "5.8 5.9 5.10", {}, 1, {10, 22, 50, 65, 100, 200}};
  const GeneratedMesh object = make_scan(1148);
  for (const vec3& place : places) add(scene.mesh, object, 0.8f, place);
  GeneratedMesh ground;
  ground.positions = {{-4, -4, -1}, {4, -4, -1}, {4, 4, -1}, {-4, 4, -1}};
  ground.indices = {0, 1, 2, 0, 2, 3};
  add(scene.mesh, ground, 1.0f, vec3(0.0f));
  return scene;
}

std::array<vec3, 9> in_rows(float spacing) {
  std::array<vec3, 9> places;
  for (int i = 0; i < 9; ++i) {
    const int column = i % 3 - 1, row = i / 3 - 1;
    places[std::size_t(i)] = {spacing * float(column), spacing * float(row), 0.0f};
  }
  return places;
}

/// ALEXANDRA: thirteen boxes and a sphere of 80 triangles.
GridScene boxes_and_sphere() {
  GridScene scene{"ALEXANDRA", "5.11 - 5.14", {}, 1, {1, 3, 6, 10, 15, 30}};
  add(scene.mesh, ball(10, 5), 1.0f, vec3(0.0f));
  for (int i = 0; i < 13; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / 13.0;
    add(scene.mesh, box(), 0.3f, vec3(core::dvec3(2.5 * std::cos(turn), 2.5 * std::sin(turn), 0.4 * (i % 3) - 0.4)));
  }
  return scene;
}

// --- tracing ---------------------------------------------------------------------------------------------------------

template <Find find>
Hit search(const TriangleSet& triangles, const UniformGrid& grid, const Ray& ray) {
  const UnitRay unit(triangles.space(), ray);
  if (unit.misses()) return {};
  Query<find, false> query(triangles, ray, unit);
  GridDda::walk(grid, unit, query);
  return query.hit();
}

template <class Work>
double processor_ms(const Work& work) {
  const std::clock_t start = std::clock();
  work();
  return 1e3 * double(std::clock() - start) / CLOCKS_PER_SEC;
}

void lower(double& least, double ms) {
  least = least == 0.0 ? ms : std::min(least, ms);
}

const Traversal& grid_traversal() {
  return *std::find_if(traversals().begin(), traversals().end(),
                       [](const Traversal& t) { return t.structure == Structure::kGrid; });
}

/// A scene with all rays of its image.
struct Searched {
  TriangleSet triangles;
  std::vector<core::Aabb> boxes;
  std::vector<Ray> primary, shadow;
  std::vector<Hit> hits;

  Searched(const GridScene& scene, const Image& image)
      : triangles(scene.mesh.positions, scene.mesh.indices), boxes(triangles.boxes()) {
    primary = primary_rays(triangles.space(), image);
    const core::Aabb& bounds = triangles.space().bounds;
    const UniformGrid grid = build_grid(boxes, bounds, automatic_resolution(boxes, bounds));
    for (const Ray& ray : primary) hits.push_back(search<Find::kNearest>(triangles, grid, ray));
    for (int light = 0; light < scene.lights; ++light) {
      const auto rays = shadow_rays(triangles, primary, hits, light_over(triangles.space(), 2.0 * light));
      shadow.insert(shadow.end(), rays.begin(), rays.end());
    }
  }
};

/// Triangles and rays in GPU memory.
struct OnGpu {
  GpuTriangles triangles;
  RayBatch primary, shadow;

  static core::Expected<OnGpu> create(const gl::Context& context, const Searched& on, int width) {
    auto triangles = upload(context, on.triangles);
    if (!triangles) return tl::unexpected(triangles.error());
    auto primary = RayBatch::create(context, on.triangles, on.primary, std::uint32_t(width));
    if (!primary) return tl::unexpected(primary.error());
    auto shadow = RayBatch::create(context, on.triangles, on.shadow);
    if (!shadow) return tl::unexpected(shadow.error());
    return OnGpu{std::move(*triangles), std::move(*primary), std::move(*shadow)};
  }
};

UniformGrid run_on_cpu(const Searched& on, const Cell& cells, GridImage& result) {
  UniformGrid grid;
  lower(result.build_ms, processor_ms([&] { grid = build_grid(on.boxes, on.triangles.space().bounds, cells); }));
  result.references = grid.triangles.size();
  result.lit = 0;
  lower(result.cpu_ms, processor_ms([&] {
          for (std::size_t i = 0; i < on.primary.size(); ++i)
            result.disagreements += search<Find::kNearest>(on.triangles, grid, on.primary[i]) != on.hits[i];
          for (const Ray& ray : on.shadow) result.lit += !search<Find::kAny>(on.triangles, grid, ray);
        }));
  return grid;
}

core::Expected<void> run_on_gpu(const gl::Context& context, GpuTracer& tracer, const Searched& on,
                                const OnGpu& uploaded, const UniformGrid& grid, GridImage& result) {
  const auto structure = upload(context, on.triangles, grid);
  if (!structure) return tl::unexpected(structure.error());
  core::Expected<void> done;
  const auto trace = [&](Ask ask, const RayBatch& rays, bool tiles) {
    if (done) done = tracer.trace(grid_traversal(), ask, uploaded.triangles, *structure, rays, {.tiles = tiles});
  };
  const double seconds = seconds_on_gpu(context, [&] {
    trace(Ask::kNearest, uploaded.primary, true);
    trace(Ask::kAny, uploaded.shadow, false);
  });
  if (!done) return done;
  lower(result.gpu_ms, 1e3 * seconds);
  const std::vector<GpuAnswer> answers = uploaded.primary.read();
  for (std::size_t i = 0; i < answers.size(); ++i) result.disagreements += answers[i].hit() != on.hits[i];
  std::size_t lit = 0;
  for (const GpuAnswer& answer : uploaded.shadow.read()) lit += !answer.hit();
  result.disagreements += std::max(lit, result.lit) - std::min(lit, result.lit);
  return {};
}

}  // namespace

std::vector<GridScene> grid_scenes() {
  std::vector<GridScene> scenes{sphere_and_box("PRI_I", 13, 8), sphere_and_box("PRI_II", 12, 12),
                                sphere_and_box("PRI_III", 14, 13), sphere_and_box("PRI_IV", 18, 14),
                                sphere_and_box("PRI_V", 27, 12)};
  scenes.push_back(nine_objects("DIST_I", in_rows(2.6f)));
  std::array<vec3, 9> uneven = in_rows(1.7f);
  for (std::size_t i = 0; i < uneven.size(); ++i) uneven[i] += i % 2 == 0 ? vec3(1.2f, 1.2f, 0) : vec3(-0.6f, -1, 0);
  scenes.push_back(nine_objects("DIST_II", uneven));
  scenes.push_back(nine_objects("DIST_III", in_rows(0.5f)));
  scenes.push_back({"BUNNY", "5.8 5.9 5.10", make_scan(69'698), 1, {20, 41, 80, 123, 200, 300}});
  scenes.push_back({"DRAGON", "5.11 - 5.14", make_scan(100'000), 1, {20, 46, 92, 138, 180, 230}});
  scenes.push_back(boxes_and_sphere());
  return scenes;
}

core::Expected<GridRun> run_grids(const gl::Context& context, GpuTracer& tracer, const GridScene& scene,
                                  const Image& image, int passes, const std::function<void(const std::string&)>& step) {
  const Searched on(scene, image);
  auto uploaded = OnGpu::create(context, on, image.width);
  if (!uploaded) return tl::unexpected(uploaded.error());
  GridRun run{&scene, on.triangles.size(), {}};
  for (const int size : scene.sizes) run.images.push_back({.size = size});
  for (int pass = 0; pass < passes; ++pass)
    for (GridImage& result : run.images) {
      step(scene.name + ", " + std::to_string(result.size) + " cells along each axis");
      const UniformGrid grid = run_on_cpu(on, {result.size, result.size, result.size}, result);
      GridImage unmeasured;  // drivers finish a program when it first runs
      const bool first = pass == 0 && &result == run.images.data();
      auto done = first ? run_on_gpu(context, tracer, on, *uploaded, grid, unmeasured) : core::Expected<void>();
      if (done) done = run_on_gpu(context, tracer, on, *uploaded, grid, result);
      if (!done) return tl::unexpected(done.error());
    }
  return run;
}

}  // namespace sightline::study::rays
