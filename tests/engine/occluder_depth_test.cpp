// The occluder raster, and occluder polygons within solids, beside the depth of the same items drawn: nowhere nearer,
// and hardly less.
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/culling/occlusion/occluder_raster.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/culling/occlusion/solid_occluders.h"
#include "sightline/engine/engine.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/render/image/image.h"
#include "sightline/tests/core/primitive_samples.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests::occluder_depth_test {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec3;
using core::View;

class OccluderDepth : public GlTest {};

dmat3 half(double x, double y, double z) {
  return dmat3(0.5 * x, 0, 0, 0, 0.5 * y, 0, 0, 0, 0.5 * z);
}

Affine random_placement(Random& random) {
  const dvec3 at(uniform(random, -6, 6), uniform(random, -6, 6), uniform(random, -6, 6));
  const double a = uniform(random, 0, 7), b = uniform(random, 0, 7);
  const dmat3 turn = dmat3(std::cos(a), std::sin(a), 0, -std::sin(a), std::cos(a), 0, 0, 0, 1) *
                     dmat3(1, 0, 0, 0, std::cos(b), std::sin(b), 0, -std::sin(b), std::cos(b));
  return {uniform(random, 0, 1) < 0.3 ? dmat3(1.0) : turn, at};
}

/// The least depth of a pixel and its neighbours: at the same place a rasteriser that moves corners by parts of a pixel
/// shows one between theirs.
float nearest_around(const image::DepthImage& depth, int x, int y) {
  float nearest = std::numeric_limits<float>::infinity();
  for (int row = std::max(y - 1, 0); row <= std::min(y + 1, depth.height - 1); ++row)
    for (int column = std::max(x - 1, 0); column <= std::min(x + 1, depth.width - 1); ++column)
      nearest = std::min(nearest, depth.metres[std::size_t(row * depth.width + column)]);
  return nearest;
}

TEST_F(OccluderDepth, IsNowhereNearerThanWhatIsDrawn) {
  std::int64_t drawn = 0, covered = 0, moved = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    core::Scene scene;
    const core::Mesh mesh = gpuprims::tessellate(core::Sphere{1.6f});
    const core::MeshId mesh_id = scene.add_mesh(mesh).value();
    std::vector<std::pair<int, Affine>> items;
    const core::Box box{float(uniform(random, 0.2, 4.0)), float(uniform(random, 0.2, 4.0)), 2.0f};
    const core::Cylinder cylinder{0.8f, 3.0f};
    for (int i = 0; i < 12; ++i) {
      const Affine place = random_placement(random);
      items.emplace_back(i % 3, place);
      if (i % 3 == 0) scene.add_primitive(scene.root(), box, place);
      if (i % 3 == 1) scene.add_primitive(scene.root(), cylinder, place);
      if (i % 3 == 2) scene.add_mesh_instance(scene.root(), mesh_id, place);
    }
    const int width = 150 + int(seed), height = 90;
    engine::EngineConfig config;
    config.draw = config.drawing.ids = true;
    config.width = width, config.height = height;
    config.context.application = &*context;
    auto engine = engine::Engine::create(scene, config);
    ASSERT_TRUE(engine) << engine.error().message;
    for (int i = 0; i < 6; ++i) {
      const core::Pose pose{dvec3(uniform(random, -9, 9), uniform(random, -9, 9), uniform(random, -9, 9)),
                            dvec3(uniform(random, -2, 2), uniform(random, -2, 2), 0.0)};
      View view = i == 0 ? *View::orthographic(pose, 14.0, double(width) / height, -3.0, 40.0)
                         : *View::perspective(pose, 1.2, double(width) / height, i == 1 ? 2.0 : 0.05);
      if (i == 2) view.sections = {{{0, 1, 0}, 1.0}};
      ASSERT_TRUE(engine->frame(view));
      const image::DepthImage depth = *engine->read_depth(view);
      culling::OccluderRaster solids, all;
      solids.begin(view, width, height);
      all.begin(view, width, height);
      for (const auto& [kind, place] : items) {
        for (culling::OccluderRaster* raster : {&solids, &all}) {
          if (kind == 0)
            raster->add_cube(place * Affine{half(box.size_x, box.size_y, box.size_z), {}});
          else if (kind == 1)
            raster->add_cylinder(place * Affine{half(2 * cylinder.radius, 2 * cylinder.radius, cylinder.height), {}},
                                 16);
          else if (raster == &all)
            raster->add_mesh(mesh.positions, mesh.indices, place);
        }
      }
      std::vector<float> of_solids(std::size_t(width) * std::size_t(height)), of_all = of_solids;
      solids.distances(of_solids);
      all.distances(of_all);
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const float exact = depth.metres[std::size_t((height - 1 - y) * width + x)];
          // Depth of orthographic views is linear, of 43 m in 24 bits.
          const auto nearer_than = [&](float shown, float found) {
            const float margin = culling::OcclusionTest::kDistanceMargin * std::abs(found) + (i == 0 ? 1e-5f : 0.0f);
            return std::isfinite(found) && !(shown <= found + margin);
          };
          const std::size_t at = std::size_t(y * width + x);
          ASSERT_FALSE(nearer_than(exact, of_solids[at]))
              << "view " << i << ", pixel " << x << " " << y << ": " << of_solids[at] << " and " << exact;
          if (i == 2) continue;
          drawn += std::isfinite(exact);
          covered += std::isfinite(of_all[at]);
          moved += nearer_than(nearest_around(depth, x, height - 1 - y), of_all[at]);
        }
      }
    }
  }
  EXPECT_LT(moved, covered / 10'000) << "a rasteriser moves meshes by parts of a pixel";
  EXPECT_GT(drawn, 100'000);
  EXPECT_GT(covered, drawn * 85 / 100);
}

/// Solids of all kinds, far from the world's origin too, seen by shaders in float.
TEST_F(OccluderDepth, OfInnerOccludersIsNowhereNearerThanTheSolids) {
  std::int64_t drawn = 0, covered = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const dvec3 middle = seed % 2 == 0 ? dvec3(0.0) : dvec3(4e5, 6e6, 100.0);
    core::Scene scene;
    for (int i = 0; i < 60; ++i) {
      const auto length = [&] { return float(std::pow(10.0, uniform(random, -2.0, 0.5))); };
      const auto shift = [&] { return float(uniform(random, -0.5, 0.5)); };
      const auto angle = [&] { return float(uniform(random, 0.1, 6.2)); };
      Affine place = random_placement(random);
      place.origin += middle;
      scene.add_primitive(scene.root(), primitive_of(core::Kind(i % 9), length, shift, angle), place);
    }
    engine::EngineConfig config;
    config.draw = true;
    const bool large = seed % 8 == 0;  // and through narrow angles, where floats lose most of a pixel
    config.width = large ? 900 : 130 + int(seed), config.height = large ? 600 : 90;
    config.context.application = &*context;
    auto engine = engine::Engine::create(scene, config);
    ASSERT_TRUE(engine) << engine.error().message;
    culling::SolidOccluders solids;
    culling::DepthPyramid pyramid;
    core::VisibleSet all;
    all.ranges.push_back({0, core::Slot(engine->snapshot().size())});
    for (int i = 0; i < 5; ++i) {
      const dvec3 aside(uniform(random, -20, 20), uniform(random, -20, 20), uniform(random, -20, 20));
      const core::Pose pose{middle + aside, middle + 0.1 * aside};
      const double aspect = double(config.width) / config.height;
      const double angle = large ? std::pow(10.0, uniform(random, -2.0, 0.1)) : uniform(random, 0.2, 1.2);
      const View view =
          i == 0 ? *View::orthographic(pose, 14.0, aspect, -3.0, 60.0) : *View::perspective(pose, angle, aspect, 0.05);
      ASSERT_TRUE(engine->frame(view));
      const image::DepthImage depth = *engine->read_depth(view);
      solids.begin(engine->snapshot(), view, config.width, config.height, 0x1p-8f + 0x1p-12f);
      solids.add(all);
      solids.build(pyramid);
      for (int y = 0; y < config.height; ++y)
        for (int x = 0; x < config.width; ++x) {
          const float exact = depth.metres[std::size_t((config.height - 1 - y) * config.width + x)];
          const float found = pyramid.row(0, y)[x];
          const float margin = culling::OcclusionTest::kDistanceMargin * std::abs(found) + (i == 0 ? 1e-5f : 0.0f);
          ASSERT_FALSE(std::isfinite(found) && !(exact <= found + margin))
              << "view " << i << ", pixel " << x << " " << y << ": " << found << " and " << exact;
          drawn += std::isfinite(exact);
          covered += std::isfinite(found);
        }
    }
  }
  EXPECT_GT(drawn, 100'000);
  EXPECT_GT(covered, drawn * 65 / 100);
  RecordProperty("percent_covered", int(100 * covered / drawn));
}

}  // namespace
}  // namespace sightline::tests::occluder_depth_test
