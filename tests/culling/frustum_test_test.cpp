// The eight-lane tests against their one-box twins, and planes at the edges of the number range.
#include "sightline/culling/frustum_test.h"

#include <gtest/gtest.h>

#include "scenes.h"

namespace sightline::tests {
namespace {

using core::Aabb;
using core::ItemBounds;
using core::View;
using culling::CullPlanes;
using culling::kLanes;

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

TEST(FrustumTest, LanesAnswerLikeSingleBoxes) {
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const core::dvec3 origin = chance(random, 0.5) ? core::dvec3(0.0) : point(random, 1e7);
    auto boxes = random_boxes(random, 200, 20.0);
    if (chance(random, 0.5)) spoil(random, boxes);
    const ItemBounds bounds = bounds_of(boxes, origin);
    View view = random_view(random, origin, 20.0);
    if (chance(random, 0.6)) add_sections(random, origin, 20.0, view);
    const CullPlanes planes(view, bounds);
    for (std::size_t first = 0; first < boxes.size(); first += 3) {
      const culling::PlaneMask mask = planes.all() & std::uint32_t(random());
      const unsigned visible = planes.visible(bounds, first, mask);
      culling::BoxLanes lanes;
      culling::LaneResult result;
      for (int i = 0; i < kLanes; ++i)
        for (int axis = 0; axis < 6; ++axis) lanes[axis][i] = bounds.coordinate(axis)[first + std::size_t(i)];
      planes.classify(lanes, mask, result);
      for (std::size_t i = 0; i < std::size_t(kLanes) && first + i < boxes.size(); ++i) {
        const Aabb box = bounds.box(first + i);
        ASSERT_EQ((visible >> i & 1u) != 0, planes.visible(box, mask));
        ASSERT_EQ((result.outside >> i & 1u) != 0, planes.outside(box, mask));
        ASSERT_EQ(result.mask[i], planes.remaining(box, mask));
        if (box.empty()) continue;
        ASSERT_FALSE(planes.outside(box, mask) && planes.visible(box, mask));
        if (!planes.outside(box, mask) && planes.remaining(box, mask) == 0) {
          ASSERT_TRUE(planes.visible(box, mask));
        }
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
