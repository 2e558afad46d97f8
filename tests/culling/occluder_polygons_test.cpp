// Polygons of the occluder raster eight at a time against the same ones by themselves: meshes take triangles one by
// one.
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "scenes.h"
#include "sightline/culling/occlusion/internal/inner_occluders.h"
#include "sightline/culling/occlusion/occluder_raster.h"
#include "sightline/tests/support/instruction_sets.h"

namespace sightline::tests::occluder_polygons_test {
namespace {

using core::dvec3;
using core::View;
using culling::OccluderPolygon;
using culling::OccluderRaster;
using culling::WholeSolid;

constexpr int kWidth = 90, kHeight = 60;

/// From the origin, so that coordinates relative to the eye are those of the world.
View view_from_origin(Random& random) {
  const core::Pose pose{dvec3(0.0), random_direction(random), {0.1, 0.2, 1.0}};
  const double aspect = double(kWidth) / kHeight;
  return chance(random, 0.3) ? *View::orthographic(pose, 10.0, aspect, 0.1, 100.0)
                             : *View::perspective(pose, uniform(random, 0.4, 1.4), aspect, 0.1);
}

/// In front of the eye, 2 to 8 metres away.
dvec3 point_in_front(Random& random, const View& view) {
  const core::dmat4 world_from_eye = glm::inverse(view.eye_from_world());
  const double distance = magnitude(random, 2.0, 8.0);
  const dvec3 at{uniform(random, -0.6, 0.6) * distance, uniform(random, -0.6, 0.6) * distance, -distance};
  return dvec3(world_from_eye * core::dvec4(at, 1.0));
}

template <class Add>
std::vector<float> distances_of(const View& view, const Add& add) {
  OccluderRaster raster;
  raster.begin(view, kWidth, kHeight, 0.0f);
  add(raster);
  std::vector<float> distances(std::size_t(kWidth) * kHeight);
  raster.distances(distances);
  return distances;
}

/// Polygons of `count` corners, each as the only occluder polygon of a solid.
struct Polygons {
  std::vector<WholeSolid> solids;
  std::vector<OccluderPolygon> polygons;

  void add(std::span<const dvec3> corners) {
    OccluderPolygon occluder;
    std::copy(corners.begin(), corners.end(), occluder.corners.begin());
    occluder.count = int(corners.size());
    occluder.hexahedron = false;
    occluder.growth = 0.0;
    core::AabbD box{corners[0], corners[0]};
    for (const dvec3& corner : corners) box.min = glm::min(box.min, corner), box.max = glm::max(box.max, corner);
    solids.push_back({box, 1});
    polygons.push_back(occluder);
  }
  std::vector<float> distances(const View& view) const {
    return distances_of(view, [&](OccluderRaster& raster) { raster.add_within(solids, polygons); });
  }
};

TEST(OccluderPolygons, AreThoseOfMeshes) {
  std::size_t covered = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const View view = view_from_origin(random);
    Polygons polygons;
    std::vector<std::array<core::vec3, 3>> meshes;
    for (int i = whole(random, 1, 20); i > 0; --i) {
      std::array<dvec3, 3> corners{};
      const dvec3 middle = point_in_front(random, view);  // the box about the corners lies in front, too
      for (dvec3& corner : corners) corner = dvec3(core::vec3(middle + point(random, 0.9)));
      if (chance(random, 0.2)) corners[2] = dvec3(core::vec3(0.5 * corners[0] + 0.501 * corners[1]));  // a sliver
      polygons.add(corners);
      meshes.push_back({core::vec3(corners[0]), core::vec3(corners[1]), core::vec3(corners[2])});
    }
    const std::uint32_t indices[] = {0, 1, 2};
    const std::vector<float> expected = distances_of(view, [&](OccluderRaster& raster) {
      for (const auto& mesh : meshes) raster.add_mesh(mesh, indices, {});
    });
    covered += std::size_t(std::count_if(expected.begin(), expected.end(), [](float d) { return d < 1e30f; }));
    for_each_instruction_set([&] { ASSERT_EQ(polygons.distances(view), expected); });
  }
  EXPECT_GT(covered, 20'000u);
}

/// A corner that a polygon has twice changes nothing.
TEST(OccluderPolygons, MayRepeatCorners) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const View view = view_from_origin(random);
    Polygons quads, octagons;
    for (int i = whole(random, 1, 20); i > 0; --i) {
      const dvec3 middle = point_in_front(random, view), x = point(random, 0.9), y = point(random, 0.9);
      const std::array<dvec3, 4> quad{middle - x, middle - y, middle + x, middle + y};
      std::array<dvec3, 8> octagon{};
      for (std::size_t k = 0; k < 8; ++k) octagon[k] = quad[k / 2];
      quads.add(quad);
      octagons.add(octagon);
    }
    for_each_instruction_set([&] { ASSERT_EQ(octagons.distances(view), quads.distances(view)); });
  }
}

}  // namespace
}  // namespace sightline::tests::occluder_polygons_test
