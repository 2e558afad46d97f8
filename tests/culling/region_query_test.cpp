// Items in regions against points of their shapes, and boxes against their triangles.
#include "sightline/culling/queries/region_query.h"

#include <algorithm>
#include <functional>
#include <limits>

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
      for (const core::ItemId item : within) ASSERT_TRUE(has(crossed, item)) << "item " << to_index(item);
      for (core::ItemId item{0}; to_index(item) < world.scene.item_slots(); ++item) {
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
          ASSERT_TRUE(has(crossed, item))
              << "item " << to_index(item) << " of kind " << core::name_of(world.scene.kind(item));
        }
        if (!all && view.section_mode != core::SectionMode::kUnion) {
          ASSERT_FALSE(has(within, item)) << "item " << to_index(item);
        }
        tight += any;
      }
      // A box that holds a whole region crosses none of its sides; of such regions some point is kept.
      for (const auto& [solid, mesh] : world.boxes) {
        ASSERT_EQ(has(within, solid), has(within, mesh)) << "item " << to_index(solid);
        if (has(crossed, mesh)) {
          ASSERT_TRUE(has(crossed, solid)) << "item " << to_index(solid);
        }
        if (has(crossed, solid) && !has(crossed, mesh)) {
          const auto box = std::get<core::Box>(world.scene.primitive(solid));
          const core::Affine placed = world.snapshot->world_from_item(world.snapshot->slot(solid));
          bool holds = false;
          for (int sample = 0; sample < 200'000 && !holds; ++sample) {
            const dvec3 p = 0.5 * dvec3(box.size_x, box.size_y, box.size_z) * point(random, 1.0);
            holds = keeps(view, core::transform_point(placed, p), -1e-7);
          }
          ASSERT_TRUE(holds) << "item " << to_index(solid) << " is reported, but no part of it lies in the region";
        }
      }
    }
  }
  EXPECT_GT(inside, 500);
  EXPECT_GT(crossing, inside + 500);
  EXPECT_GT(tight, crossing * 4 / 5) << "most of what crosses, meshes left out, has points in the region";
}

using Planes = std::vector<core::Plane>;

/// The planes of a view, or of each of its parts where sections unite; of unit length, about a point.
std::vector<Planes> parts_of(const core::View& view, const dvec3& about) {
  const auto add = [&](const core::Plane& plane, Planes& planes) {
    const double length = glm::length(plane.normal);
    if (length > 0.0) planes.push_back({plane.normal / length, core::evaluate(plane, about) / length});
  };
  Planes common;
  for (const core::Plane& plane : core::frustum_planes(view.clip_from_world(), view.clip_depth())) add(plane, common);
  if (view.section_mode == core::SectionMode::kIntersection || view.sections.empty()) {
    for (const core::Plane& plane : view.sections) add(plane, common);
    return {common};
  }
  std::vector<Planes> parts;
  for (const core::Plane& plane : view.sections) {
    parts.push_back(common);
    add(plane, parts.back());
  }
  return parts;
}

bool keep(const Planes& planes, const dvec3& p, double room) {
  return std::all_of(planes.begin(), planes.end(),
                     [&](const core::Plane& plane) { return core::evaluate(plane, p) >= -room; });
}

/// Calls visit(the point nearest to `from` where some of the planes are 0) for one, two and three planes, until it
/// returns true.
template <class Visit>
bool any_foot(const Planes& planes, const dvec3& from, const Visit& visit) {
  const auto foot = [&](std::initializer_list<std::size_t> chosen) {
    dvec3 normals[3], found = from;
    int count = 0;
    // Each plane is reached along what its normal has across those before.
    for (const std::size_t i : chosen) {
      dvec3 along = planes[i].normal;
      for (int k = 0; k < count; ++k) along -= glm::dot(along, normals[k]) * normals[k];
      const double length = glm::length(along);
      if (length < 1e-9) return false;
      normals[count++] = along / length;
      found -= core::evaluate(planes[i], found) / length * normals[count - 1];
    }
    return visit(found);
  };
  for (std::size_t a = 0; a < planes.size(); ++a) {
    if (foot({a})) return true;
    for (std::size_t b = a + 1; b < planes.size(); ++b) {
      if (foot({a, b})) return true;
      for (std::size_t c = b + 1; c < planes.size(); ++c)
        if (foot({a, b, c})) return true;
    }
  }
  return false;
}

/// Whether a point is no farther than that from what planes keep.
bool within_distance(const Planes& planes, const dvec3& p, double distance) {
  return keep(planes, p, 0.0) || any_foot(planes, p, [&](const dvec3& foot) {
           return glm::length(foot - p) <= distance && keep(planes, foot, 1e-9);
         });
}

/// Whether planes keep any point, all moved outwards by `room`. What they keep must be bounded, so it has a corner.
bool keep_any(Planes planes, double room) {
  for (core::Plane& plane : planes) plane.offset += room;
  return any_foot(planes, dvec3(0.0), [&](const dvec3& foot) { return keep(planes, foot, 1e-9); });
}

Planes planes_of(const core::Box& box, const core::Affine& placed) {
  Planes planes;
  const double half[] = {0.5 * box.size_x, 0.5 * box.size_y, 0.5 * box.size_z};
  for (int axis = 0; axis < 3; ++axis) {
    const double scale = glm::length(placed.linear[axis]);
    const dvec3 normal = placed.linear[axis] / scale;
    for (const double sign : {1.0, -1.0})
      planes.push_back({sign * normal, scale * half[axis] - sign * glm::dot(normal, placed.origin)});
  }
  return planes;
}

/// Whether planes, all moved outwards by `room`, keep any point of a triangle.
bool keep_any_of(const Planes& planes, const core::Mesh& mesh, const core::Affine& placed, double room) {
  for (std::size_t first = 0; first < mesh.indices.size(); first += 3) {
    std::vector<dvec3> polygon, rest;
    for (std::size_t i = first; i < first + 3; ++i)
      polygon.push_back(core::transform_point(placed, dvec3(mesh.positions[mesh.indices[i]])));
    for (const core::Plane& plane : planes) {
      rest.clear();
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const dvec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double at_a = core::evaluate(plane, a) + room, at_b = core::evaluate(plane, b) + room;
        if (at_a >= 0.0) rest.push_back(a);
        if (at_a * at_b < 0.0) rest.push_back(glm::mix(a, b, at_a / (at_a - at_b)));
      }
      polygon.swap(rest);
    }
    if (!polygon.empty()) return true;
  }
  return false;
}

/// Whether planes, all moved outwards by `room`, keep balls about points.
bool wholly_in(const Planes& planes, const std::vector<dvec3>& points, double radius, double room) {
  return std::all_of(points.begin(), points.end(), [&](const dvec3& p) { return keep(planes, p, room - radius); });
}

/// A box of any size that stands askew, so that most of those near to large items are parted by the items' sides alone.
core::View small_region(const World& world, Random& random) {
  const core::dmat3 axes = tests::random_rotation(random);
  const dvec3 middle = world.centre + point(random, 8.0);
  std::vector<core::Plane> planes;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = std::pow(10.0, uniform(random, -2.0, 0.3));
    for (const double sign : {1.0, -1.0})
      planes.push_back({sign * axes[axis], half - sign * glm::dot(axes[axis], middle)});
  }
  return region_view(planes);
}

/// Boxes, their triangles and spheres are reported by their very shapes, but for rounding, by both rules.
TEST(RegionQuery, BoxesTrianglesAndSpheresAreExact) {
  constexpr double kRoom = 1e-7;
  int crossed_ones = 0, whole_ones = 0, left_out = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    World world(random, 0, seed % 2 == 0 ? 1e5 : 10.0);
    std::vector<core::Primitive> solids;
    for (int i = 0; i < 60; ++i) {
      const auto length = [&] { return float(std::pow(10.0, uniform(random, -1.5, 0.8))); };
      const core::Affine placed{uniform(random, 0.5, 2.0) * tests::random_rotation(random),
                                world.centre + point(random, 10.0)};
      if (i % 3 == 0) {
        world.scene.add_primitive(world.scene.root(), core::Sphere{length()}, placed);
        continue;
      }
      const core::Box box{length(), length(), length()};
      core::Mesh triangle;
      for (int k = 0; k < 3; ++k) triangle.positions.emplace_back(double(box.size_x) * point(random, 1.0));
      triangle.indices = {0, 1, 2};
      if (i % 3 == 1)
        world.scene.add_primitive(world.scene.root(), box, placed);
      else if (i % 6 == 2)
        world.scene.add_mesh_instance(world.scene.root(), *world.scene.add_mesh(triangle), placed);
      else
        world.scene.add_mesh_instance(world.scene.root(), *world.scene.add_mesh(mesh_of(box)), placed);
    }
    ASSERT_TRUE(world.scene.commit());
    world.snapshot = std::make_unique<core::Snapshot>(world.scene);
    const core::Snapshot& snapshot = *world.snapshot;
    for (int i = 0; i < 60; ++i) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", region " << i);
      const core::View view = i % 3 == 0 ? small_region(world, random) : random_region(world, random);
      const std::vector<Planes> parts = parts_of(view, world.centre);
      const auto any_part = [&](const auto& test) { return std::any_of(parts.begin(), parts.end(), test); };
      const auto crossed = world.items_in(view, RegionRule::kCrossing),
                 within = world.items_in(view, RegionRule::kWholly);
      for (core::ItemId item{0}; to_index(item) < world.scene.item_slots(); ++item) {
        const Slot slot = snapshot.slot(item);
        core::Affine placed = snapshot.world_from_item(slot);
        placed.origin -= world.centre;
        std::vector<dvec3> points{placed.origin};
        double radius = 0.0;
        std::function<bool(const Planes&, double)> crosses;
        if (int(snapshot.kind(slot)) >= core::kPrimitiveKindCount) {
          points.clear();
          for (const core::vec3& p : snapshot.mesh(slot).positions)
            points.push_back(core::transform_point(placed, dvec3(p)));
          crosses = [&](const Planes& part, double room) {
            return keep_any_of(part, snapshot.mesh(slot), placed, room);
          };
        } else if (snapshot.kind(slot) == Kind::kBox) {
          const auto box = std::get<core::Box>(world.scene.primitive(item));
          points.clear();
          for (const core::vec3& p : mesh_of(box).positions) points.push_back(core::transform_point(placed, dvec3(p)));
          crosses = [&, solid = planes_of(box, placed)](const Planes& part, double room) {
            Planes both = part;
            both.insert(both.end(), solid.begin(), solid.end());
            return keep_any(both, room);
          };
        } else {
          radius = 0.5 * std::get<core::Sphere>(world.scene.primitive(item)).diameter * glm::length(placed.linear[0]);
          crosses = [&](const Planes& part, double room) { return within_distance(part, points[0], radius + room); };
        }
        const bool is_crossed = has(crossed, item), is_whole = has(within, item);
        if (is_crossed) {
          ASSERT_TRUE(any_part([&](const Planes& part) { return crosses(part, kRoom); })) << "item " << to_index(item);
        } else {
          ASSERT_FALSE(any_part([&](const Planes& part) { return crosses(part, -kRoom); }))
              << "item " << to_index(item);
        }
        const auto whole = [&](double room) {
          return any_part([&](const Planes& part) { return wholly_in(part, points, radius, room); });
        };
        ASSERT_TRUE(is_whole ? whole(kRoom) : !whole(-kRoom)) << "item " << to_index(item);
        crossed_ones += is_crossed && !is_whole, whole_ones += is_whole, left_out += !is_crossed;
      }
    }
  }
  EXPECT_GT(crossed_ones, 700);
  EXPECT_GT(whole_ones, 1000);
  EXPECT_GT(left_out, 10'000);
}

/// A rectangle's corners become those of the image, whatever their order.
TEST(RegionQuery, RectanglesBecomeImages) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const core::Pose pose{point(random, 10.0), point(random, 10.0), {0, 0, 1}};
    core::View view = seed % 2 == 0 ? *core::View::orthographic(pose, 25.0, 1.5, -50.0, 100.0)
                                    : *core::View::perspective(pose, 0.8, 1.5, 0.1);
    view.sections = {{{0, 0, 1}, 3.0}};
    view.section_mode = core::SectionMode::kUnion;
    view.layers = core::kLayerObstruction;
    const int width = std::uniform_int_distribution<int>(1, 900)(random),
              height = std::uniform_int_distribution<int>(1, 700)(random);
    const double x0 = uniform(random, -9.0, 900.0), x1 = uniform(random, -9.0, 900.0);
    const double y0 = uniform(random, -9.0, 700.0), y1 = seed % 5 == 0 ? y0 : uniform(random, -9.0, 700.0);
    const auto cropped = rectangle_view(view, width, height, x0, y0, x1, y1);
    ASSERT_TRUE(cropped);
    EXPECT_EQ(cropped->sections.size(), 1u);
    EXPECT_EQ(cropped->section_mode, view.section_mode);
    EXPECT_EQ(cropped->layers, view.layers);
    const double high = std::max(std::abs(y1 - y0), 2e-3), middle = 0.5 * (y0 + y1);
    for (const double u : {0.0, 0.3, 1.0})
      for (const double v : {0.0, 0.6, 1.0}) {
        const double x = std::min(x0, x1) + u * std::abs(x1 - x0), y = middle + (v - 0.5) * high;
        const core::dvec4 p =
            glm::inverse(view.clip_from_world()) * core::dvec4(2.0 * x / width - 1.0, 1.0 - 2.0 * y / height, 0.5, 1.0);
        const core::dvec4 clip = cropped->clip_from_world() * (p / p.w);
        EXPECT_NEAR(clip.x / clip.w, 2.0 * u - 1.0, 1e-6);
        EXPECT_NEAR(clip.y / clip.w, 1.0 - 2.0 * v, 1e-6);
      }
  }
}

TEST(RegionQuery, RegionsKeepTheirPlanesAndLayers) {
  const core::Plane plane{{0, 0, 1}, -1.0};
  const core::View view = region_view({plane}, core::kLayerObstruction);
  EXPECT_EQ(view.layers, core::kLayerObstruction);
  EXPECT_EQ(view.sections.size(), 1u);
  EXPECT_EQ(region_view({plane}).layers, core::kDefaultLayerMask);
  for (const core::Plane& none : core::frustum_planes(view.clip_from_world(), view.clip_depth())) {
    EXPECT_EQ(none.normal, dvec3(0.0));
    EXPECT_GE(none.offset, 0.0);
  }
}

TEST(RegionQuery, RefusesBadRectangles) {
  const core::View view = *core::View::perspective({}, 0.8, 1.5, 0.1);
  EXPECT_TRUE(rectangle_view(view, 10, 10, 5, 5, 5, 5));
  EXPECT_TRUE(rectangle_view(view, 1, 1, 0, 0, 1, 1));
  for (const int bad : {0, -1}) {
    const auto narrow = rectangle_view(view, bad, 10, 0, 0, 1, 1), low = rectangle_view(view, 10, bad, 0, 0, 1, 1);
    ASSERT_FALSE(narrow || low);
    EXPECT_NE(narrow.error().message.find("rectangle"), std::string::npos);
    EXPECT_NE(low.error().message.find("rectangle"), std::string::npos);
  }
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()})
    for (int i = 0; i < 4; ++i) {
      double at[] = {0, 0, 1, 1};
      at[i] = bad;
      const auto view_of_bad = rectangle_view(view, 10, 10, at[0], at[1], at[2], at[3]);
      ASSERT_FALSE(view_of_bad);
      EXPECT_NE(view_of_bad.error().message.find("rectangle"), std::string::npos);
    }
}

}  // namespace
}  // namespace sightline::culling::region_query_test
