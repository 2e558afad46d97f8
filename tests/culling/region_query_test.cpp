// Items in regions against points of their shapes, and boxes against their triangles.
#include "sightline/culling/queries/region_query.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/tests/core/primitive_samples.h"

namespace sightline::culling::region_query_test {
namespace {

using core::dvec3;
using core::Kind;
using core::Slot;
using tests::Random;
using tests::uniform;

dvec3 point(Random& random, double half) {
  const double x = uniform(random, -half, half), y = uniform(random, -half, half);
  return {x, y, uniform(random, -half, half)};
}

/// The twelve triangles of a box.
core::Mesh mesh_of(const core::Box& box) {
  core::Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.emplace_back((i & 1 ? 0.5f : -0.5f) * box.size_x, (i & 2 ? 0.5f : -0.5f) * box.size_y,
                                (i & 4 ? 0.5f : -0.5f) * box.size_z);
  for (const int face : {0x0132, 0x4675, 0x0451, 0x2376, 0x0264, 0x1573}) {
    const auto corner = [&](int i) { return std::uint32_t(face >> (12 - 4 * i) & 15); };
    for (const int i : {0, 1, 2, 0, 2, 3}) mesh.indices.push_back(corner(i));
  }
  return mesh;
}

struct World {
  core::Scene scene;
  dvec3 centre;
  std::unique_ptr<core::Snapshot> snapshot;
  std::vector<std::pair<core::ItemId, core::ItemId>> boxes;  // each as a solid and as a mesh

  World(Random& random, int items, double away) : centre(point(random, away)) {
    for (int i = 0; i < items; ++i) {
      const core::Primitive solid = tests::random_primitive(
          Kind(std::uniform_int_distribution<int>(0, core::kPrimitiveKindCount - 1)(random)), random);
      const double size = glm::length(core::bounds(solid, {}).size());
      const double scale = uniform(random, 0.5, 4.0) / size;
      const core::Affine placed{scale * tests::random_rotation(random), centre + point(random, 10.0)};
      const core::ItemId item = scene.add_primitive(scene.root(), solid, placed);
      if (const auto* box = std::get_if<core::Box>(&solid))
        boxes.emplace_back(item, scene.add_mesh_instance(scene.root(), *scene.add_mesh(mesh_of(*box)), placed));
    }
    EXPECT_TRUE(scene.commit());
    snapshot = std::make_unique<core::Snapshot>(scene);
  }

  std::vector<core::ItemId> items_in(const core::View& view, RegionRule rule) const {
    core::VisibleSet candidates;
    CpuCuller(snapshot->bounds()).cull(view, candidates);
    std::vector<core::ItemId> items;
    for (const Slot slot : items_in_region(*snapshot, view, candidates, rule)) items.push_back(snapshot->item(slot));
    std::sort(items.begin(), items.end());
    return items;
  }
};

bool has(const std::vector<core::ItemId>& items, core::ItemId item) {
  return std::binary_search(items.begin(), items.end(), item);
}

/// Whether the view's planes and sections keep a point by more than `margin`.
bool keeps(const core::View& view, const dvec3& p, double margin) {
  const auto kept = [&](const core::Plane& plane) {
    return plane.normal == dvec3(0.0) || core::evaluate(plane, p) > margin * glm::length(plane.normal);
  };
  const auto planes = core::frustum_planes(view.clip_from_world(), view.clip_depth());
  if (!std::all_of(planes.begin(), planes.end(), kept)) return false;
  if (view.sections.empty()) return true;
  return view.section_mode == core::SectionMode::kUnion ? std::any_of(view.sections.begin(), view.sections.end(), kept)
                                                        : std::all_of(view.sections.begin(), view.sections.end(), kept);
}

core::View random_region(const World& world, Random& random) {
  if (uniform(random, 0, 1) < 0.4) {
    std::vector<core::Plane> planes;
    for (int i = std::uniform_int_distribution<int>(1, 8)(random); i > 0; --i) {
      const dvec3 normal = uniform(random, 0.1, 3.0) * tests::random_direction(random);
      planes.push_back({normal, -glm::dot(normal, world.centre + point(random, 5.0))});
    }
    return region_view(planes);
  }
  const core::Pose pose{world.centre + point(random, 40.0), world.centre + point(random, 5.0), {0, 0, 1}};
  core::View view = uniform(random, 0, 1) < 0.3 ? *core::View::orthographic(pose, 25.0, 1.5, -50.0, 100.0)
                                                : *core::View::perspective(pose, 0.8, 1.5, 0.1);
  if (uniform(random, 0, 1) < 0.3) {
    for (int i = 0; i < 2; ++i) {
      const dvec3 normal = tests::random_direction(random);
      view.sections.push_back({normal, -glm::dot(normal, world.centre + point(random, 3.0))});
    }
    if (uniform(random, 0, 1) < 0.5) view.section_mode = core::SectionMode::kUnion;
  }
  const double x = uniform(random, 0, 600), y = uniform(random, 0, 400);
  const double w = std::pow(10.0, uniform(random, 0.0, 3.0)), h = std::pow(10.0, uniform(random, 0.0, 3.0));
  return *rectangle_view(view, 600, 400, x + w, y, x, y + h);
}

TEST(RegionQuery, AgreesWithPointsOfShapes) {
  int crossing = 0, inside = 0, tight = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    const World world(random, 150, seed % 2 == 0 ? 1e6 : 10.0);
    for (int i = 0; i < 60; ++i) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", region " << i);
      const core::View view = random_region(world, random);
      const auto crossed = world.items_in(view, RegionRule::kCrossing),
                 within = world.items_in(view, RegionRule::kWholly);
      crossing += int(crossed.size());
      inside += int(within.size());
      for (const core::ItemId item : within) ASSERT_TRUE(has(crossed, item)) << "item " << item;
      for (core::ItemId item = 0; item < world.scene.item_slots(); ++item) {
        const Slot slot = world.snapshot->slot(item);
        if (int(world.snapshot->kind(slot)) >= core::kPrimitiveKindCount) continue;
        const core::Affine placed = world.snapshot->world_from_item(slot);
        bool all = true, any = false;
        for (int sample = 0; sample < 60; ++sample) {
          const dvec3 p = core::transform_point(placed, tests::random_point(world.scene.primitive(item), random));
          any |= keeps(view, p, 1e-8);
          all &= keeps(view, p, -1e-6);
        }
        if (any) {
          ASSERT_TRUE(has(crossed, item)) << "item " << item << " of kind " << core::name_of(world.scene.kind(item));
        }
        if (!all && view.section_mode != core::SectionMode::kUnion) {
          ASSERT_FALSE(has(within, item)) << "item " << item;
        }
        tight += any;
      }
      // A box that holds a whole region crosses none of its sides; of such regions some point is kept.
      for (const auto& [solid, mesh] : world.boxes) {
        ASSERT_EQ(has(within, solid), has(within, mesh)) << "item " << solid;
        if (has(crossed, mesh)) {
          ASSERT_TRUE(has(crossed, solid)) << "item " << solid;
        }
        if (has(crossed, solid) && !has(crossed, mesh)) {
          const auto box = std::get<core::Box>(world.scene.primitive(solid));
          const core::Affine placed = world.snapshot->world_from_item(world.snapshot->slot(solid));
          bool holds = false;
          for (int sample = 0; sample < 200'000 && !holds; ++sample) {
            const dvec3 p = 0.5 * dvec3(box.size_x, box.size_y, box.size_z) * point(random, 1.0);
            holds = keeps(view, core::transform_point(placed, p), -1e-7);
          }
          ASSERT_TRUE(holds) << "item " << solid << " is reported, but no part of it lies in the region";
        }
      }
    }
  }
  EXPECT_GT(inside, 500);
  EXPECT_GT(crossing, inside + 500);
  EXPECT_GT(tight, crossing * 4 / 5) << "most of what crosses, meshes left out, has points in the region";
}

TEST(RegionQuery, RefusesBadRectangles) {
  const core::View view = *core::View::perspective({}, 0.8, 1.5, 0.1);
  EXPECT_FALSE(rectangle_view(view, 0, 10, 0, 0, 1, 1));
  EXPECT_FALSE(rectangle_view(view, 10, 10, std::nan(""), 0, 1, 1));
  EXPECT_TRUE(rectangle_view(view, 10, 10, 5, 5, 5, 5));
}

}  // namespace
}  // namespace sightline::culling::region_query_test
