// The tracer against brute force.
#include "sightline/raytrace/tracer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/tests/core/primitive_samples.h"
#include "sightline/tests/raytrace/brute_force.h"
#include "sightline/tests/support/instruction_sets.h"

namespace sightline::raytrace::tracer_test {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec3;
using core::Kind;
using core::Ray;
using core::Scene;
using core::Slot;
using core::Snapshot;
using core::vec3;
using tests::Random;
using tests::uniform;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

int whole(Random& random, int low, int high) {
  return std::uniform_int_distribution<int>(low, high)(random);
}
bool chance(Random& random, double probability) {
  return uniform(random, 0.0, 1.0) < probability;
}
dvec3 point(Random& random, double half) {
  const double x = uniform(random, -half, half), y = uniform(random, -half, half);
  return {x, y, uniform(random, -half, half)};
}

// --- comparison ------------------------------------------------------------------------------------------------------

void check_nearest(const Tracer& tracer, const Ray& ray, const RayFilter& filter,
                   const std::vector<Crossing>& expected) {
  const auto hit = tracer.nearest(ray, filter);
  ASSERT_TRUE(hit) << hit.error().message;
  double surely = kInfinity;
  for (const Crossing& c : expected)
    if (c.sure) surely = std::min(surely, c.t + c.error);
  const auto any = tracer.any(ray, filter);
  ASSERT_TRUE(any);
  if (!*hit) {
    ASSERT_EQ(surely, kInfinity) << "brute force hits at " << surely;
    if (expected.empty()) {
      ASSERT_FALSE(*any);
    }
    return;
  }
  const Hit& h = **hit;
  ASSERT_FALSE(expected.empty()) << "hit in slot " << h.slot << " at " << h.t << ", brute force has none";
  if (surely < kInfinity) {
    ASSERT_TRUE(*any);
  }
  ASSERT_GE(h.t, ray.t_min);
  ASSERT_LE(h.t, ray.t_max);
  double error = kInfinity, best = kInfinity;
  for (const Crossing& c : expected)
    if (c.slot == h.slot && std::abs(c.t - h.t) - c.error < best) best = std::abs(c.t - h.t) - c.error, error = c.error;
  ASSERT_LE(best, 0.0) << "slot " << h.slot << " is hit at " << h.t << ", off by " << best + error;
  ASSERT_LE(h.t - error, surely) << "slot " << h.slot << " is not the nearest";
  ASSERT_EQ(h.item, tracer.snapshot().item(h.slot));
  ASSERT_NEAR(glm::length(h.normal), 1.0, 1e-9);
}

/// Each sure crossing is reported, and nothing that is no crossing.
void check_all(const Tracer& tracer, const Ray& ray, const RayFilter& filter, const std::vector<Crossing>& expected) {
  std::vector<Hit> hits;
  ASSERT_TRUE(tracer.all(ray, hits, filter));
  for (std::size_t i = 1; i < hits.size(); ++i) ASSERT_LE(hits[i - 1].t, hits[i].t);
  for (const Hit& h : hits)
    ASSERT_TRUE(std::any_of(expected.begin(), expected.end(),
                            [&](const Crossing& c) { return c.slot == h.slot && std::abs(c.t - h.t) <= c.error; }))
        << "slot " << h.slot << " (" << core::name_of(tracer.snapshot().kind(h.slot)) << ") at " << h.t;
  for (const Crossing& c : expected)
    if (c.sure) {
      ASSERT_TRUE(std::any_of(hits.begin(), hits.end(),
                              [&](const Hit& h) { return c.slot == h.slot && std::abs(c.t - h.t) <= c.error; }))
          << "missed slot " << c.slot << " at " << c.t;
    }
}

// --- scenes ----------------------------------------------------------------------------------------------------------

core::Mesh tessellated(const core::Primitive& solid, int segments) {
  return gpuprims::tessellate(solid, {.fixed_segments = segments});
}

/// A closed mesh with large and small, flat and long triangles.
core::Mesh random_mesh(Random& random) {
  const float size = float(std::pow(10.0, uniform(random, -2.0, 2.0)));
  switch (whole(random, 0, 3)) {
    case 0:
      return tessellated(core::Sphere{size}, whole(random, 4, 24));
    case 1:
      return tessellated(core::Cylinder{size, 30.0f * size}, whole(random, 3, 16));
    case 2:
      return tessellated(core::CircularTorus{2.0f * size, size, 7.0f}, whole(random, 4, 16));
    default:
      return tessellated(core::Box{size, 2.0f * size, 0.01f * size}, 4);
  }
}

struct World {
  Scene scene;
  std::unique_ptr<Snapshot> snapshot;
  double half = 1.0;
  dvec3 centre{0.0};

  Affine placement(Random& random, double size) const {
    Affine a = tests::random_affine(random, 1.0, 0.0);
    if (chance(random, 0.5)) a.linear = tests::random_rotation(random);
    if (chance(random, 0.2)) a.linear = core::dmat3(1.0);
    a.linear *= size;
    a.origin = centre + point(random, half);
    return a;
  }
  Tracer tracer() const { return std::move(*Tracer::create(*snapshot, 2)); }
};

constexpr Kind kSolids[] = {
    Kind::kPyramid,       Kind::kBox,   Kind::kRectangularTorus, Kind::kCircularTorus, Kind::kEllipticalDish,
    Kind::kSphericalDish, Kind::kSnout, Kind::kCylinder,         Kind::kSphere,        Kind::kLine};

core::ItemId add_item(World& world, Random& random, std::span<const core::MeshId> meshes) {
  const core::NodeId node = world.scene.add_node(world.scene.root());
  if (chance(random, 0.3)) world.scene.set_layers(node, std::uint32_t(whole(random, 1, 3)));
  if (chance(random, 0.4)) {
    const auto mesh = meshes[std::size_t(whole(random, 0, int(meshes.size()) - 1))];
    return world.scene.add_mesh_instance(node, mesh, world.placement(random, 0.1 * world.half));
  }
  const Kind kind = kSolids[whole(random, 0, 9)];
  core::Primitive solid = tests::random_primitive(kind, random);
  // Sizes over six orders of magnitude would hide most of a scene within a few giants.
  const core::AabbD box = core::bounds(solid, {});
  const double size = glm::length(box.size());
  return world.scene.add_primitive(node, solid,
                                   world.placement(random, uniform(random, 0.02, 0.3) * world.half / size));
}

/// `twins`: each item is there twice.
std::unique_ptr<World> random_world(Random& random, int items, double away, bool twins = false) {
  auto world = std::make_unique<World>();
  world->half = std::pow(10.0, uniform(random, -1.0, 3.0));
  world->centre = point(random, away);
  std::vector<core::MeshId> meshes;
  for (int i = 0; i < 4; ++i) meshes.push_back(*world->scene.add_mesh(random_mesh(random)));
  for (int i = 0; i < items; ++i) {
    Random again = random;
    add_item(*world, random, meshes);
    if (twins) add_item(*world, again, meshes);
  }
  EXPECT_TRUE(world->scene.commit());
  world->snapshot = std::make_unique<Snapshot>(world->scene);
  return world;
}

/// A place in or around the scene, often on a corner of a mesh or box.
dvec3 interesting_point(const World& world, Random& random) {
  const Snapshot& snapshot = *world.snapshot;
  const auto slot = Slot(whole(random, 0, int(snapshot.size()) - 1));
  if (snapshot.vacant(slot) || chance(random, 0.3)) return world.centre + point(random, 1.3 * world.half);
  if (int(snapshot.kind(slot)) >= core::kPrimitiveKindCount) {
    const core::Mesh& mesh = snapshot.mesh(slot);
    const auto corner = [&] {
      return dvec3(mesh.positions[std::size_t(whole(random, 0, int(mesh.positions.size()) - 1))]);
    };
    const dvec3 a = corner();
    return core::transform_point(snapshot.world_from_item(slot), chance(random, 0.5) ? a : 0.5 * (a + corner()));
  }
  if (chance(random, 0.5))
    return core::transform_point(snapshot.world_from_item(slot), tests::random_point(snapshot.primitive(slot), random));
  const core::Aabb box = snapshot.bounds().box(slot);
  dvec3 p = snapshot.bounds().origin + dvec3(box.min);
  for (int axis = 0; axis < 3; ++axis)
    if (chance(random, 0.5)) p[axis] = snapshot.bounds().origin[axis] + double(box.max[axis]);
  return p;
}

Ray random_ray(const World& world, Random& random) {
  Ray ray;
  const dvec3 target = interesting_point(world, random);
  ray.origin = interesting_point(world, random);
  if (chance(random, 0.1)) ray.origin = world.centre + 1e4 * world.half * tests::random_direction(random);
  ray.direction = target - ray.origin;
  if (chance(random, 0.3)) {
    ray.direction = dvec3(0.0);
    ray.direction[whole(random, 0, 2)] = chance(random, 0.5) ? 1.0 : -1.0;
    if (chance(random, 0.3)) ray.direction[whole(random, 0, 2)] += 1e-30;
    if (chance(random, 0.7)) ray.origin = target - 3.0 * world.half * ray.direction;
  }
  if (ray.direction == dvec3(0.0)) ray.direction = {0.0, 0.0, 1.0};
  ray.direction *= std::pow(10.0, uniform(random, -3.0, 3.0));
  if (chance(random, 0.3)) ray.t_min = uniform(random, -2.0, 1.0);
  if (chance(random, 0.2)) ray.t_min = -kInfinity;
  if (chance(random, 0.3)) ray.t_max = ray.t_min + uniform(random, 0.0, 3.0);
  return ray;
}

RayFilter random_filter(const World& world, Random& random) {
  RayFilter filter;
  if (chance(random, 0.3)) filter.layers = std::uint32_t(whole(random, 0, 3));
  if (chance(random, 0.4)) {
    if (chance(random, 0.5)) filter.section_mode = core::SectionMode::kUnion;
    for (int i = whole(random, 1, 3); i > 0; --i) {
      const dvec3 normal = chance(random, 0.1) ? dvec3(0.0) : tests::random_direction(random);
      filter.sections.push_back({normal, -glm::dot(normal, world.centre + point(random, world.half))});
    }
  }
  filter.cuts = filter.sections.size() != 2;
  return filter;
}

void check_rays(const World& world, const Tracer& tracer, Random& random, int rays) {
  for (int i = 0; i < rays; ++i) {
    SCOPED_TRACE(testing::Message() << "ray " << i);
    const Ray ray = random_ray(world, random);
    const RayFilter filter = random_filter(world, random);
    const auto expected = brute_force(*world.snapshot, ray, filter);
    ASSERT_NO_FATAL_FAILURE(check_nearest(tracer, ray, filter, expected));
    ASSERT_NO_FATAL_FAILURE(check_all(tracer, ray, filter, expected));
  }
}

bool same(const dvec3& a, const dvec3& b) {
  return a == b || (std::isnan(a.x) && std::isnan(b.x));
}

/// Rays by themselves, up to `most` beside each other, and from one point.
std::vector<Ray> random_stream(const World& world, Random& random, std::size_t count, int most) {
  std::vector<Ray> rays;
  while (rays.size() < count) {
    const Ray ray = random_ray(world, random);
    rays.push_back(ray);
    if (chance(random, 0.5)) continue;
    const double spread = std::pow(10.0, uniform(random, -6.0, -0.5));
    const bool pinhole = chance(random, 0.7), mixed = chance(random, 0.2);
    for (int i = whole(random, 1, most); i > 0; --i) {
      Ray& next = rays.emplace_back(ray);
      next.direction += spread * glm::length(ray.direction) * point(random, 1.0);
      if (next.direction == dvec3(0.0)) next.direction = ray.direction;
      if (!pinhole) next.origin += spread * world.half * point(random, 1.0);
      if (mixed) next.t_max = next.t_min + uniform(random, -0.5, 3.0);
    }
  }
  rays.resize(count);
  return rays;
}

/// First hits are those of whole hits, bit for bit.
void check_first_hits(const Tracer& tracer, const std::vector<Ray>& rays, const std::vector<Hit>& hits,
                      const RayFilter& filter) {
  std::vector<FirstHit> first(rays.size(), FirstHit{.slot = 12345});
  ASSERT_TRUE(tracer.nearest(rays, first, filter));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(first[i].slot, hits[i].slot) << "ray " << i;
    if (hits[i].slot == core::kNone) continue;
    ASSERT_EQ(first[i].t, hits[i].t) << "ray " << i;
  }
}

/// The stream's answers are those of single rays, bit for bit.
void check_streams(const World& world, const Tracer& tracer, Random& random, std::size_t count, int most = 40) {
  const std::vector<Ray> rays = random_stream(world, random, count, most);
  std::vector<Hit> hits(count, Hit{.slot = 12345});
  const RayFilter filter = random_filter(world, random);
  ASSERT_TRUE(tracer.nearest(rays, hits, filter));
  ASSERT_NO_FATAL_FAILURE(check_first_hits(tracer, rays, hits, filter));
  const auto any = std::make_unique<bool[]>(count);
  ASSERT_TRUE(tracer.any(rays, {any.get(), count}, filter));
  for (std::size_t i = 0; i < count; ++i) {
    SCOPED_TRACE(testing::Message() << "ray " << i);
    ASSERT_EQ(any[i], *tracer.any(rays[i], filter));
    const std::optional<Hit> alone = *tracer.nearest(rays[i], filter);
    const FirstHit first = *tracer.first(rays[i], filter);
    ASSERT_EQ(first.slot, alone ? alone->slot : core::kNone);
    ASSERT_EQ(first.t, alone ? alone->t : first.t);
    // Two meshes in one place.
    if (alone && hits[i].slot != alone->slot && hits[i].t == alone->t && hits[i].triangle != core::kNone) continue;
    ASSERT_EQ(hits[i].slot, alone ? alone->slot : core::kNone);
    if (!alone) continue;
    ASSERT_EQ(hits[i].item, alone->item);
    ASSERT_EQ(hits[i].t, alone->t);
    ASSERT_EQ(hits[i].triangle, alone->triangle);
    ASSERT_EQ(hits[i].face, alone->face);
    ASSERT_TRUE(same(hits[i].point, alone->point));
    ASSERT_TRUE(same(hits[i].normal, alone->normal));
  }
}

TEST(Tracer, StreamsAgreeWithSingleRays) {
  tests::for_each_instruction_set([] {
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
      SCOPED_TRACE(testing::Message() << "seed " << seed);
      Random random(seed);
      const int items = whole(random, 1, seed % 2 == 0 ? 4 : 200);
      const auto world = random_world(random, items, seed % 3 == 0 ? 1e7 : 10.0, seed % 4 == 0);
      const Tracer tracer = world->tracer();
      for (const std::size_t count : {1u, 15u, 16u, 17u, 2000u})
        ASSERT_NO_FATAL_FAILURE(check_streams(*world, tracer, random, count));
      // Packets that walk as one.
      ASSERT_NO_FATAL_FAILURE(check_streams(*world, tracer, random, 2000, 400));
    }
  });
}

TEST(Tracer, AgreesWithBruteForce) {
  tests::for_each_instruction_set([] {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      SCOPED_TRACE(testing::Message() << "seed " << seed);
      Random random(seed);
      const auto world = random_world(random, whole(random, 1, 300), seed % 3 == 0 ? 1e7 : 10.0);
      const Tracer tracer = world->tracer();
      ASSERT_NO_FATAL_FAILURE(check_rays(*world, tracer, random, 300));
    }
  });
}

/// Rays pass an only item by without entering it, and mostly it is placed without a rotation. Every other solid is a
/// ring, with a hole that rays pass through.
TEST(Tracer, MeetsAnOnlyItem) {
  tests::for_each_instruction_set([] {
    for (std::uint64_t seed = 1; seed <= 48; ++seed) {
      SCOPED_TRACE(testing::Message() << "seed " << seed);
      Random random(seed);
      World world;
      Affine placement;
      if (chance(random, 0.3)) placement.linear = tests::random_rotation(random);
      world.centre = placement.origin = point(random, seed % 3 == 0 ? 1e7 : 10.0);
      if (seed % 2 == 0) {
        const auto mesh = world.scene.add_mesh(random_mesh(random));
        world.scene.add_mesh_instance(world.scene.root(), *mesh, placement);
      } else if (seed % 4 == 1) {
        const auto tube = float(std::pow(10.0, uniform(random, -3.0, 0.1)));
        const core::CircularTorus ring{1.0f, tube, 7.0f};
        world.scene.add_primitive(world.scene.root(), ring, placement);
      } else {
        const core::Primitive solid = tests::random_primitive(kSolids[seed / 4 % 9], random);
        world.scene.add_primitive(world.scene.root(), solid, placement);
      }
      ASSERT_TRUE(world.scene.commit());
      world.snapshot = std::make_unique<Snapshot>(world.scene);
      world.half = 0.5 * glm::length(world.snapshot->bounds().fitted_bounds().bounds.size());
      const Tracer tracer = world.tracer();
      ASSERT_NO_FATAL_FAILURE(check_rays(world, tracer, random, 200));
      ASSERT_NO_FATAL_FAILURE(check_streams(world, tracer, random, 400));
    }
  });
}

/// Edits of all kinds: near and far moves, hidden and shown items, new and removed ones.
TEST(Tracer, FollowsEdits) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const auto world = random_world(random, seed == 1 ? 0 : 200, 1e3);
    std::vector<core::MeshId> meshes;
    for (std::size_t i = 0; i < world->scene.mesh_slots(); ++i) meshes.push_back(world->scene.mesh_at(i));
    Tracer tracer = world->tracer();
    for (int round = 0; round < 12; ++round) {
      SCOPED_TRACE(testing::Message() << "round " << round);
      Scene& scene = world->scene;
      for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item) {
        if (!scene.contains_item(item) || !chance(random, 0.1)) continue;
        Affine placed = scene.placement(item);
        switch (whole(random, 0, 4)) {
          case 0:
            scene.remove_item(item);
            break;
          case 1:
            scene.set_visible(item, !scene.item_visible(item));
            break;
          case 2:
            placed.origin += point(random, world->half);
            scene.set_placement(item, placed);
            break;
          case 3:
            scene.set_layers(scene.node_of(item), std::uint32_t(whole(random, 1, 3)));
            break;
          default:
            placed.origin += point(random, 0.01 * world->half);
            scene.set_placement(item, placed);
        }
      }
      if (round % 4 == 1) meshes.push_back(*scene.add_mesh(random_mesh(random)));
      for (int i = whole(random, 0, 20); i > 0; --i) add_item(*world, random, meshes);
      const auto delta = scene.commit();
      ASSERT_TRUE(delta);
      ASSERT_TRUE(tracer.update(world->snapshot->apply(*delta)));
      if (world->snapshot->size() == 0) continue;
      ASSERT_NO_FATAL_FAILURE(check_rays(*world, tracer, random, 60));
      ASSERT_NO_FATAL_FAILURE(check_streams(*world, tracer, random, 100));
    }
  }
}

/// Items that were hidden when the tracer was made have a slot already when they are shown.
TEST(Tracer, SeesItemsThatWereHiddenAtFirst) {
  Random random(8);
  const auto world = random_world(random, 0, 0.0);
  std::vector<core::ItemId> items;
  for (int i = 0; i < 40; ++i) {
    items.push_back(world->scene.add_primitive(world->scene.root(), core::Sphere{0.5f}, core::translation({i, 0, 0})));
    world->scene.set_visible(items.back(), i % 2 == 0);
  }
  ASSERT_TRUE(world->scene.commit());
  world->snapshot = std::make_unique<Snapshot>(world->scene);
  Tracer tracer = world->tracer();
  for (int shown = 0; shown < 40; ++shown) {
    world->scene.set_visible(items[std::size_t(shown)], shown % 2 == 1);
    const auto delta = world->scene.commit();
    ASSERT_TRUE(delta);
    ASSERT_TRUE(tracer.update(world->snapshot->apply(*delta)));
    for (int i = 0; i < 40; ++i) {
      const auto hit = tracer.nearest({.origin = {i, -5, 0}});
      ASSERT_TRUE(hit);
      ASSERT_EQ(hit->has_value(), i % 2 == (i <= shown ? 1 : 0)) << "item " << i << ", edit " << shown;
    }
  }
}

/// A closed mesh in a scene of its own, where it stands.
std::unique_ptr<World> world_of(core::Mesh mesh, const Affine& placement) {
  auto world = std::make_unique<World>();
  const auto id = *world->scene.add_mesh(std::move(mesh));
  world->scene.add_mesh_instance(world->scene.root(), id, placement);
  EXPECT_TRUE(world->scene.commit());
  world->snapshot = std::make_unique<Snapshot>(world->scene);
  return world;
}

/// Rays through corners and along edges: in and out in turn, as often out as in, and nothing twice.
TEST(Tracer, ClosedMeshesAreEnteredAndLeftInTurn) {
  Random random(3);
  const core::Primitive solids[] = {core::Sphere{2}, core::Cylinder{1, 3}, core::CircularTorus{2, 1, 7},
                                    core::Box{1, 2, 3}, core::Snout{1, 0.5f, 2, 0.5f, 0, 0, 0, 0, 0}};
  for (const core::Primitive& solid : solids)
    for (int placed = 0; placed < 4; ++placed) {
      Affine placement;
      if (placed == 1) placement = core::translation({1e7, -1e7, 3e6});
      if (placed == 2) placement.linear = tests::random_rotation(random);
      if (placed == 3) placement = tests::random_affine(random, 1.0, 100.0);
      const core::Mesh mesh = tessellated(solid, 8);
      const auto world = world_of(mesh, placement);
      const Tracer tracer = world->tracer();
      const Affine world_from_item = world->snapshot->world_from_item(0);
      std::size_t most = 0;
      for (int i = 0; i < 4000; ++i) {
        const auto corner = [&] {
          return dvec3(mesh.positions[std::size_t(whole(random, 0, int(mesh.positions.size()) - 1))]);
        };
        const dvec3 a = corner(), b = chance(random, 0.5) ? corner() : 0.5 * (corner() + corner());
        dvec3 direction = b - a;
        if (chance(random, 0.4)) {
          direction = dvec3(0.0);
          direction[whole(random, 0, 2)] = 1.0;
        }
        if (direction == dvec3(0.0)) continue;
        Ray ray;
        ray.direction = world_from_item.linear * direction;
        ray.origin = core::transform_point(world_from_item, a) - uniform(random, 5.0, 10.0) * ray.direction;
        ray.t_min = -kInfinity;
        std::vector<Hit> hits;
        ASSERT_TRUE(tracer.all(ray, hits));
        ASSERT_EQ(hits.size() % 2, 0u) << "ray " << i;
        int inside = 0;
        bool grazes = false;  // then the normal does not tell an entry from an exit
        for (const Hit& h : hits) {
          const double cosine = glm::dot(h.normal, glm::normalize(ray.direction));
          inside += cosine < 0.0 ? 1 : -1;
          grazes |= std::abs(cosine) < 1e-5;
        }
        if (!grazes) {
          ASSERT_EQ(inside, 0) << "ray " << i;
        }
        most = std::max(most, hits.size());
      }
      EXPECT_GE(most, 2u);
    }
}

/// From within a closed mesh no ray gets out unseen.
TEST(Tracer, ClosedMeshesAreWatertight) {
  tests::for_each_instruction_set([] {
    Random random(4);
    const core::Mesh mesh = tessellated(core::Sphere{2}, 24);
    for (const double away : {0.0, 1e7}) {
      const auto world = world_of(mesh, core::translation(dvec3(away, 0.5 * away, -away)));
      const Tracer tracer = world->tracer();
      const Affine world_from_item = world->snapshot->world_from_item(0);
      for (int i = 0; i < 20'000; ++i) {
        const dvec3 target(mesh.positions[std::size_t(whole(random, 0, int(mesh.positions.size()) - 1))]);
        Ray ray;
        ray.origin = core::transform_point(world_from_item, point(random, 0.3));
        ray.direction = core::transform_point(world_from_item, target) - ray.origin;
        ASSERT_TRUE(*tracer.any(ray)) << "ray " << i;
        const auto hit = tracer.nearest(ray);
        ASSERT_TRUE(*hit) << "ray " << i;
        ASSERT_NEAR((*hit)->t, 1.0, 0.05);
      }
    }
  });
}

TEST(Tracer, InstructionSetsGiveTheSameAnswer) {
  Random random(5);
  const auto world = random_world(random, 300, 100.0);
  const Tracer tracer = world->tracer();
  for (int i = 0; i < 2000; ++i) {
    const Ray ray = random_ray(*world, random);
    std::optional<std::optional<Hit>> first;
    tests::for_each_instruction_set([&] {
      const std::optional<Hit> hit = *tracer.nearest(ray);
      if (!first) first = hit;
      ASSERT_EQ(hit.has_value(), first->has_value()) << "ray " << i;
      if (!hit) return;
      ASSERT_EQ(hit->t, (*first)->t) << "ray " << i;
      ASSERT_EQ(hit->slot, (*first)->slot) << "ray " << i;
      ASSERT_EQ(hit->triangle, (*first)->triangle) << "ray " << i;
    });
  }
}

TEST(Tracer, HitsOfExtremeMeshes) {
  for (const float size : {1e-30f, 1e-12f, 1.0f, 1e15f, 1e30f}) {
    core::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}};
    mesh.indices = {0, 1, 2};
    const auto world = world_of(mesh, {});
    const Tracer tracer = world->tracer();
    const double s = size;
    const auto hit = tracer.nearest({.origin = {0.25 * s, 0.25 * s, 2.0 * s}, .direction = {0, 0, -s}});
    ASSERT_TRUE(hit && *hit) << size;
    EXPECT_NEAR((*hit)->t, 2.0, 1e-9);
    EXPECT_LT(glm::length((*hit)->normal - dvec3(0, 0, 1)), 1e-12);
    EXPECT_EQ((*hit)->triangle, 0u);
    EXPECT_FALSE(*tracer.any({.origin = {0.75 * s, 0.75 * s, 2.0 * s}, .direction = {0, 0, -s}}));
  }
}

/// The faces that a ray meets in turn.
std::vector<Face> faces_along(const core::Primitive& solid, const dvec3& origin, const dvec3& direction) {
  Scene scene;
  scene.add_primitive(scene.root(), solid, {dmat3{{0, 2, 0}, {-2, 0, 0}, {0, 0, 2}}, {5, 6, 7}});
  EXPECT_TRUE(scene.commit());
  const Snapshot snapshot(scene);
  const auto tracer = Tracer::create(snapshot);
  EXPECT_TRUE(tracer);
  const Affine placed = snapshot.world_from_item(0);
  const Ray ray{core::transform_point(placed, origin), placed.linear * direction, -kInfinity};
  std::vector<Hit> hits;
  EXPECT_TRUE(tracer->all(ray, hits));
  std::vector<Face> faces;
  for (const Hit& hit : hits) faces.push_back(hit.face);
  const auto nearest = tracer->nearest(ray);
  EXPECT_TRUE(nearest && *nearest && (*nearest)->face == faces.at(0));
  return faces;
}

/// A ball of radius 1 with a mesh beside it that is closed, inside out or open, cut by planes.
TEST(Tracer, SectionsCutSolidsAndClosedMeshesOpen) {
  core::Mesh closed = tessellated(core::Box{2, 2, 2}, 4), inverted = closed, open = closed;
  for (std::size_t i = 0; i < inverted.indices.size(); i += 3) std::swap(inverted.indices[i], inverted.indices[i + 1]);
  open.indices.resize(open.indices.size() - 3);
  Scene scene;
  scene.add_primitive(scene.root(), core::Sphere{2});
  const std::vector<core::Mesh> meshes{closed, inverted, open};
  for (int i = 0; i < 3; ++i)
    scene.add_mesh_instance(scene.root(), *scene.add_mesh(meshes[std::size_t(i)]),
                            core::translation({3.0 * (i + 1), 0, 0}));
  ASSERT_TRUE(scene.commit());
  const Snapshot snapshot(scene);
  const auto tracer = Tracer::create(snapshot);
  ASSERT_TRUE(tracer);
  RayFilter filter;
  filter.sections = {{{0, 0, -2}, 1.0}};  // below z = 0.5
  for (const bool cuts : {true, false})
    for (int i = 0; i < 4; ++i) {
      SCOPED_TRACE(testing::Message() << "item " << i << ", cuts " << cuts);
      filter.cuts = cuts;
      const Ray down{{3.0 * i + 0.1, 0.2, 9.0}, {0, 0, -1}}, up{{3.0 * i + 0.1, 0.2, -9.0}, {0, 0, 1}};
      const auto hit = tracer->nearest(down, filter);
      ASSERT_TRUE(hit && *hit);
      EXPECT_EQ((*hit)->item, core::ItemId(i));
      const bool cut = cuts && i < 3;
      EXPECT_EQ((*hit)->face == Face::kCut, cut);
      if (cut) {
        EXPECT_EQ((*hit)->t, 8.5);
        EXPECT_EQ((*hit)->normal, dvec3(0, 0, 1));
        EXPECT_EQ((*hit)->triangle, core::kNone);
      }
      std::vector<Hit> hits;
      ASSERT_TRUE(tracer->all(down, hits, filter));
      EXPECT_EQ(hits.size(), cut ? 2u : 1u);
      Ray short_ray = down;
      short_ray.t_max = 8.6;
      EXPECT_EQ(*tracer->any(short_ray, filter), cut);
      ASSERT_TRUE(tracer->all(up, hits, filter));
      EXPECT_EQ(hits.size(), 1u) << "from within what is kept";
      Ray inside = down;
      inside.t_min = 8.7;
      EXPECT_NE((*tracer->nearest(inside, filter))->face, Face::kCut) << "the ray begins within";
    }
  filter.cuts = true;
  filter.section_mode = core::SectionMode::kUnion;
  filter.sections = {{{0, 0, -1}, -0.5}, {{0, 0, 1}, -0.5}};  // without the middle
  std::vector<Hit> hits;
  ASSERT_TRUE(tracer->all({{0, 0, 9}, {0, 0, -1}}, hits, filter));
  ASSERT_EQ(hits.size(), 3u);
  EXPECT_EQ(hits[0].face, Face::kSide);
  EXPECT_EQ(hits[1].face, Face::kCut);
  EXPECT_EQ(hits[1].t, 9.5);
  EXPECT_EQ(hits[1].normal, dvec3(0, 0, 1));
}

TEST(Tracer, TellsFaces) {
  using Faces = std::vector<Face>;
  const core::Box box{2, 4, 6};
  EXPECT_EQ(faces_along(box, {-9, 0, 0}, {1, 0, 0}), (Faces{Face::kMinX, Face::kMaxX}));
  EXPECT_EQ(faces_along(box, {0, 9, 0}, {0, -1, 0}), (Faces{Face::kMaxY, Face::kMinY}));
  EXPECT_EQ(faces_along(box, {0, 0, -9}, {0, 0, 1}), (Faces{Face::kBottom, Face::kTop}));
  const core::Pyramid pyramid{4, 4, 2, 2, 0, 0, 2};
  EXPECT_EQ(faces_along(pyramid, {9, 0, 0}, {-1, 0, 0}), (Faces{Face::kMaxX, Face::kMinX}));
  EXPECT_EQ(faces_along(pyramid, {0, -9, 0}, {0, 1, 0}), (Faces{Face::kMinY, Face::kMaxY}));
  EXPECT_EQ(faces_along(pyramid, {0, 0, 9}, {0, 0, -1}), (Faces{Face::kTop, Face::kBottom}));
  EXPECT_EQ(faces_along(core::Cylinder{1, 2}, {0, -9, 0.5}, {0, 1, 0}), (Faces{Face::kSide, Face::kSide}));
  EXPECT_EQ(faces_along(core::Cylinder{1, 2}, {0.5, 0, -9}, {0, 0, 1}), (Faces{Face::kBottom, Face::kTop}));
  EXPECT_EQ(faces_along(core::Sphere{2}, {0, -9, 0.5}, {0, 1, 0}), (Faces{Face::kSide, Face::kSide}));
  EXPECT_EQ(faces_along(core::EllipticalDish{1, 2}, {0.5, 0, 9}, {0, 0, -1}), (Faces{Face::kSide, Face::kBottom}));
  EXPECT_EQ(faces_along(core::SphericalDish{1, 0.5f}, {0.5, 0, -9}, {0, 0, 1}), (Faces{Face::kBottom, Face::kSide}));
  const core::Snout snout{1, 0.5f, 2, 0, 0, 0.2f, 0, 0, 0};
  EXPECT_EQ(faces_along(snout, {0, 0, -9}, {0, 0, 1}), (Faces{Face::kBottom, Face::kTop}));
  EXPECT_EQ(faces_along(snout, {0, -9, 0}, {0, 1, 0}), (Faces{Face::kSide, Face::kSide}));
  const core::Snout steep{1, 2, 2, 0, 0, 0, 0, 1.4f, 0};  // the top plane does not close it
  EXPECT_EQ(faces_along(steep, {1.5, 0, 9}, {0, 0, -1}), (Faces{Face::kTopLevel, Face::kSide}));
  const core::CircularTorus elbow{2, 0.5f, 1.5f};
  EXPECT_EQ(faces_along(elbow, {2.2, -9, 0}, {0, 1, 0}), (Faces{Face::kBottom, Face::kSide}));
  EXPECT_EQ(faces_along(elbow, {1.5, 1.5, 9}, {0, 0, -1}), (Faces{Face::kSide, Face::kSide}));
  const double end = 1.5;
  EXPECT_EQ(faces_along(elbow, dvec3(2 * std::cos(end) - std::sin(end), 2 * std::sin(end) + std::cos(end), 0),
                        {std::sin(end), -std::cos(end), 0})
                .at(0),
            Face::kTop);
  const core::RectangularTorus ring{1, 2, 1, 3.0f};
  EXPECT_EQ(faces_along(ring, {0, 9, 0}, {0, -1, 0}), (Faces{Face::kSide, Face::kInner}));
  EXPECT_EQ(faces_along(ring, {0, 1.5, -9}, {0, 0, 1}), (Faces{Face::kBelow, Face::kAbove}));
  EXPECT_EQ(faces_along(ring, {1.5, -9, 0}, {0, 1, 0}), (Faces{Face::kBottom, Face::kSide}));
  EXPECT_EQ(name_of(Face::kTriangle), "triangle");
  EXPECT_EQ(name_of(Face::kMaxY), "max_y");
}

TEST(Tracer, EmptyScenesAreNeverHit) {
  Scene scene;
  ASSERT_TRUE(scene.commit());
  const Snapshot snapshot(scene);
  const auto tracer = Tracer::create(snapshot);
  ASSERT_TRUE(tracer);
  EXPECT_FALSE(*tracer->nearest({}));
  EXPECT_FALSE(*tracer->any({}));
  std::vector<Hit> hits(3);
  ASSERT_TRUE(tracer->all({}, hits));
  EXPECT_TRUE(hits.empty());
}

TEST(Tracer, RefusesRaysThatAreNone) {
  Random random(6);
  const auto world = random_world(random, 5, 0.0);
  const Tracer tracer = world->tracer();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Ray bad[5];
  bad[0].origin.y = nan;
  bad[1].direction.x = nan;
  bad[2].direction = dvec3(0.0);
  bad[3].t_max = nan;
  bad[4].direction.z = kInfinity;
  std::vector<Hit> hits;
  for (const Ray& ray : bad) {
    EXPECT_FALSE(tracer.nearest(ray));
    EXPECT_FALSE(tracer.first(ray));
    EXPECT_FALSE(tracer.any(ray));
    EXPECT_FALSE(tracer.all(ray, hits));
  }
  EXPECT_FALSE(*tracer.any({.t_min = 2.0, .t_max = 1.0}));

  RayFilter cut;
  cut.sections = {{{0, 0, 1}, 0.0}};
  for (const RayFilter& filter : {RayFilter(), cut})
    for (std::size_t at : {0u, 20u, 36u}) {
      std::vector<Ray> rays(37);
      rays[at] = bad[at % 5];
      std::vector<Hit> of_rays(rays.size());
      const auto traced = tracer.nearest(rays, of_rays, filter);
      ASSERT_FALSE(traced);
      EXPECT_EQ(traced.error().message.rfind("rays[" + std::to_string(at) + "]: ", 0), 0u) << traced.error().message;
      EXPECT_FALSE(tracer.nearest(rays, std::span(of_rays).first(3), filter));
      std::vector<FirstHit> first(rays.size());
      const auto firsts = tracer.nearest(rays, first, filter);
      ASSERT_FALSE(firsts);
      EXPECT_EQ(firsts.error().message, traced.error().message);
      bool hit[37];
      const auto any = tracer.any(rays, hit, filter);
      ASSERT_FALSE(any);
      EXPECT_EQ(any.error().message, traced.error().message);
      EXPECT_FALSE(tracer.any(rays, std::span(hit).first(3), filter));
    }
  EXPECT_TRUE(tracer.nearest(std::span<const Ray>(), std::span<Hit>()));
  EXPECT_TRUE(tracer.any(std::span<const Ray>(), std::span<bool>()));
}

}  // namespace
}  // namespace sightline::raytrace::tracer_test
