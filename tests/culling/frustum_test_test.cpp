// The kernels' item test against the one-box test, and planes at the edges of the number range.
#include "sightline/culling/frustum/frustum_test.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "scenes.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/linear_culler.h"

namespace sightline::tests::frustum_test_test {
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

View matrix_view(const core::dmat4& clip, core::ClipDepth depth = core::ClipDepth::kMinusOneToOne) {
  return *View::from_matrices(core::dmat4(1.0), clip, depth);
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
        culling::cull_slots(bounds, planes, mask, core::kLayerModel, {core::Slot(first), std::uint32_t(end - first)},
                            set);
        ASSERT_EQ(set.sorted_slots(), expected);
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
  const View view = random_view(random, core::dvec3(0.0), 20.0);
  const core::dmat4 clip = view.clip_from_world();
  const CullPlanes planes(view, bounds);
  for (const double scale : {0x1p-900, 0x1p-120, 0x1p120, 0x1p900}) {
    const CullPlanes scaled(matrix_view(clip * scale, view.clip_depth()), bounds);
    for (std::size_t i = 0; i < bounds.size(); ++i)
      ASSERT_EQ(planes.visible(bounds.box(i), planes.all()), scaled.visible(bounds.box(i), scaled.all())) << scale;
  }
}

/// Twin of the planes' set-up: the formula as the header and the error analysis state it, with ldexp and
/// core::round_up.
struct TwinPlane {
  culling::FloatPlane f;
  double normal[3], offset, magnitude, tiny;

  /// True when this is a plane to test.
  bool set(const core::Plane& plane, const ItemBounds& bounds) {
    const core::dvec3 n = plane.normal;
    if (!core::is_finite(n) || !std::isfinite(plane.offset)) return false;
    const double largest = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
    if (largest == 0.0) return false;
    int exponent = 0;
    std::frexp(largest, &exponent);
    const core::Aabb& extent = bounds.extent();
    const double d = std::ldexp(plane.offset, -exponent - 4);
    double reach = 0.0, sizes = 4.0, extents = 4.0;
    offset = magnitude = 0.0;
    for (int i = 0; i < 3; ++i) {
      const double o = bounds.origin[i];
      const double m =
          extent.empty() ? 0.0 : std::max(std::abs(double(extent.min[i])), std::abs(double(extent.max[i])));
      normal[i] = std::ldexp(n[i], -exponent - 4);
      offset += normal[i] * o;
      magnitude += std::abs(normal[i] * o);
      reach += std::abs(normal[i]) * m;
      sizes += std::abs(o) + m;
      extents += m;
      f.normal[i] = float(normal[i]);
      f.p_axis[i] = std::uint8_t(normal[i] >= 0.0 ? i + 3 : i);
      f.n_axis[i] = std::uint8_t(normal[i] >= 0.0 ? i : i + 3);
    }
    if (!(magnitude < 0x1p900) || std::isinf(d)) return false;
    offset += d;
    magnitude += std::abs(d);
    tiny = 0x1p-1070 * sizes;
    const double error = 8.0 * 0x1p-53 * (magnitude + reach) + tiny;
    if (std::abs(offset) - error > 0x1p127) return false;
    offset = std::clamp(offset, -0x1p127, 0x1p127);
    f.offset = float(offset);
    const double band = 5.01 * 0x1p-24 * (reach + std::abs(offset)) + 0x1p-149 * extents + 2.0 * error;
    f.band = band < double(Aabb::kFar) ? core::round_up(band) : std::numeric_limits<float>::max();
    return true;
  }

  bool passes(const Aabb& box) const {
    const auto p = [&](int i) { return normal[i] >= 0.0 ? box.max[i] : box.min[i]; };
    const float s = ((f.normal[0] * p(0) + f.normal[1] * p(1)) + f.normal[2] * p(2)) + f.offset;
    if (s >= f.band) return true;
    if (s < -f.band) return false;
    double exact = 0.0, size = magnitude;
    for (int i = 0; i < 3; ++i) {
      exact += normal[i] * double(p(i));
      size += std::abs(normal[i] * double(p(i)));
    }
    return !(exact + offset < -(8.0 * 0x1p-53 * size + tiny));
  }
};

void expect_planes_of_twin(const View& view, const ItemBounds& bounds, Random& random) {
  std::vector<TwinPlane> twins;
  TwinPlane twin;
  for (const core::Plane& plane : core::frustum_planes(view.clip_from_world(), view.clip_depth()))
    if (twin.set(plane, bounds)) twins.push_back(twin);
  for (const core::Plane& plane : view.sections)
    if (twin.set(moved_outwards(plane, bounds), bounds)) twins.push_back(twin);
  const CullPlanes planes(view, bounds);
  ASSERT_EQ(planes.plane_count(), int(twins.size()));
  for (std::size_t k = 0; k < twins.size(); ++k) {
    const culling::FloatPlane &a = planes.planes()[k], &b = twins[k].f;
    for (int i = 0; i < 3; ++i) {
      ASSERT_EQ(std::bit_cast<std::uint32_t>(a.normal[i]), std::bit_cast<std::uint32_t>(b.normal[i]));
      ASSERT_EQ(a.p_axis[i], b.p_axis[i]);
      ASSERT_EQ(a.n_axis[i], b.n_axis[i]);
    }
    ASSERT_EQ(std::bit_cast<std::uint32_t>(a.offset), std::bit_cast<std::uint32_t>(b.offset));
    ASSERT_EQ(a.band, b.band);
    // The double form shows in points next to the plane.
    const core::Aabb& extent = bounds.extent();
    for (int sample = 0; sample < 20; ++sample) {
      core::dvec3 p;
      for (int i = 0; i < 3; ++i)
        p[i] = std::uniform_real_distribution<double>(0.0, 1.0)(random) * double(extent.max[i] - extent.min[i]) +
               double(extent.min[i]);
      const int axis = whole(random, 0, 2);
      const TwinPlane& t = twins[k];
      double rest = t.offset;
      for (int i = 0; i < 3; ++i) rest += i == axis ? 0.0 : t.normal[i] * p[i];
      const double there = -rest / t.normal[axis];
      if (std::abs(there) < double(extent.max[axis])) p[axis] = there;
      const Aabb box{core::vec3(p), core::vec3(p)};
      ASSERT_EQ(planes.visible(box, PlaneMask(1) << k), t.passes(box));
    }
  }
}

TEST(FrustumTest, PlanesAreThoseOfThePlainFormula) {
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const core::dvec3 origin = point(random, std::pow(10.0, whole(random, -3, 8)));
    const ItemBounds bounds = bounds_of(random_boxes(random, 5, std::pow(10.0, whole(random, -40, 37))), origin);
    View view = random_view(random, origin, 20.0);
    core::dmat4 clip = view.clip_from_world();
    switch (seed % 6) {
      case 1:  // any size, down to denormals and up to the edge
        for (int c = 0; c < 4; ++c)
          for (int r = 0; r < 4; ++r) clip[c][r] *= std::ldexp(1.0, whole(random, -1074, 900) / (1 + int(seed % 4)));
        break;
      case 2:
        clip *= std::ldexp(1.0, chance(random, 0.5) ? whole(random, -1074, -960) : whole(random, 900, 990));
        break;
      case 3:
        clip[whole(random, 0, 3)] = core::dvec4(0.0);
        break;
      case 4:
        for (int r = whole(random, 0, 3), c = 0; c < 4; ++c) clip[c][r] = chance(random, 0.5) ? 0.0 : 1e30;
        break;
      case 5:
        clip[3] *= std::ldexp(1.0, whole(random, 0, 900));
        break;
      default:
        break;
    }
    auto spoiled = View::from_matrices(core::dmat4(1.0), clip, core::ClipDepth::kMinusOneToOne);
    if (seed % 6 != 0 && spoiled) view = *spoiled;
    if (chance(random, 0.5)) add_sections(random, origin, 20.0, view);
    view.section_mode = core::SectionMode::kIntersection;
    ASSERT_NO_FATAL_FAILURE(expect_planes_of_twin(view, bounds, random));
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
}  // namespace sightline::tests::frustum_test_test
