// The kernels' item test against the one-box test, and planes at the edges of the number range.
#include "sightline/culling/frustum_test.h"

#include <gtest/gtest.h>

#include "scenes.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/linear_culler.h"

namespace sightline::tests {
namespace {

using core::Aabb;
using core::ItemBounds;
using core::View;
using culling::CullPlanes;
using culling::PlaneMask;

ItemBounds bounds_of(const std::vector<Aabb>& boxes, const core::dvec3& origin) {
  ItemBounds bounds;
  bounds.origin = origin;
  bounds.resize(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) bounds.set(i, boxes[i]);
  return bounds;
}

View matrix_view(const core::dmat4& clip) {
  return *View::from_matrices(core::dmat4(1.0), clip, core::ClipDepth::kMinusOneToOne);
}

TEST(FrustumTest, KernelsAnswerLikeSingleBoxes) {
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const core::dvec3 origin = chance(random, 0.5) ? core::dvec3(0.0) : point(random, 1e7);
    auto boxes = random_boxes(random, 200, 20.0);
    if (chance(random, 0.5)) spoil(random, boxes);
    ItemBounds bounds = bounds_of(boxes, origin);
    if (chance(random, 0.3)) bounds.set_layers(std::size_t(whole(random, 0, 199)), 2);
    View view = random_view(random, origin, 20.0);
    if (chance(random, 0.6)) add_sections(random, origin, 20.0, view);
    const CullPlanes planes(view, bounds);
    for (int sample = 0; sample < 10; ++sample) {
      const PlaneMask mask = planes.all() & std::uint32_t(random());
      const std::size_t first = std::size_t(whole(random, 0, 199)), end = std::size_t(whole(random, int(first), 200));
      std::vector<core::Slot> expected;
      for (std::size_t i = first; i < end; ++i)
        if (planes.visible(bounds.box(i), mask) && bounds.layers(i) == core::kLayerModel)
          expected.push_back(core::Slot(i));
      for_each_instruction_set([&] {
        core::VisibleSet set;
        culling::cull_slots(bounds, planes, mask, core::kLayerModel, first, end, set);
        ASSERT_EQ(set.items, expected);
      });
    }
  }
}

/// What lets a node stand for the boxes within it.
TEST(FrustumTest, NodesNeverContradictTheirItems) {
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const core::dvec3 origin = chance(random, 0.5) ? core::dvec3(0.0) : point(random, 1e7);
    const ItemBounds bounds = bounds_of(random_boxes(random, 200, 20.0), origin);
    View view = random_view(random, origin, 20.0);
    if (chance(random, 0.6)) add_sections(random, origin, 20.0, view);
    const CullPlanes planes(view, bounds);
    for (std::size_t i = 0; i + 1 < bounds.size(); ++i) {
      Aabb node = bounds.box(i);
      node.grow(bounds.box(i + 1));
      const PlaneMask left = planes.remaining(node, planes.all());
      for (const std::size_t k : {i, i + 1}) {
        const Aabb box = bounds.box(k);
        ASSERT_FALSE(planes.outside(node, planes.all()) && planes.visible(box, planes.all()));
        ASSERT_EQ(planes.visible(box, left), planes.visible(box, planes.all())) << "a freed plane rejects";
      }
    }
  }
}

TEST(FrustumTest, AnswersDoNotDependOnTheMatrixScale) {
  Random random(11);
  const ItemBounds bounds = bounds_of(random_boxes(random, 500, 20.0), core::dvec3(0.0));
  const core::dmat4 clip = random_view(random, core::dvec3(0.0), 20.0).clip_from_world();
  const CullPlanes planes(matrix_view(clip), bounds);
  for (const double scale : {0x1p-900, 0x1p-120, 0x1p120, 0x1p900}) {
    const CullPlanes scaled(matrix_view(clip * scale), bounds);
    for (std::size_t i = 0; i < bounds.size(); ++i)
      ASSERT_EQ(planes.visible(bounds.box(i), planes.all()), scaled.visible(bounds.box(i), scaled.all())) << scale;
  }
}

TEST(FrustumTest, PlanesWithoutNormal) {
  const ItemBounds bounds = bounds_of({box_around(core::dvec3(0.0), core::dvec3(1.0))}, core::dvec3(0.0));
  core::dmat4 clip(0.0);
  clip[3][3] = 1.0;
  EXPECT_EQ(CullPlanes(matrix_view(clip), bounds).all(), 0u);
  EXPECT_FALSE(CullPlanes(matrix_view(clip), bounds).nothing_visible());
  clip[3][3] = 0.0;  // 0 >= 0 everywhere
  EXPECT_FALSE(CullPlanes(matrix_view(clip), bounds).nothing_visible());
  clip[3][3] = -1.0;
  EXPECT_TRUE(CullPlanes(matrix_view(clip), bounds).nothing_visible());
}

TEST(FrustumTest, PlanesOutOfReach) {
  const Aabb everywhere{core::vec3(-core::Aabb::kFar), core::vec3(core::Aabb::kFar)};
  const ItemBounds bounds = bounds_of({everywhere}, core::dvec3(0.0));
  core::dmat4 clip(0.0);
  clip[3][3] = 1.0;
  View view = matrix_view(clip);
  for (const double distance : {1e37, 2e38, 1e40, 1e150, 1e300}) {
    view.section_mode = core::SectionMode::kIntersection;
    view.sections = {{{1.0, 0.0, 0.0}, distance}};
    EXPECT_TRUE(CullPlanes(view, bounds).visible(everywhere, CullPlanes(view, bounds).all())) << distance;
    view.sections = {{{1.0, 0.0, 0.0}, -distance}};
    const CullPlanes planes(view, bounds);
    const bool reachable = distance <= 3e38;
    EXPECT_EQ(!planes.nothing_visible() && planes.visible(everywhere, planes.all()), reachable) << distance;
    // In a union such a plane adds nothing, and its opposite adds everything.
    view.section_mode = core::SectionMode::kUnion;
    view.sections.push_back({{-1e-300, 0.0, 0.0}, 1e300});
    EXPECT_FALSE(CullPlanes(view, bounds).nothing_visible());
    EXPECT_TRUE(CullPlanes(view, bounds).visible(everywhere, CullPlanes(view, bounds).all())) << distance;
  }
}

}  // namespace
}  // namespace sightline::tests
