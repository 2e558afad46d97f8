// Pins each line of core/conventions.h, and the outward rounding of core/aabb.h.
#include "sightline/core/conventions.h"

#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sightline/core/aabb.h"
#include "sightline/core/affine.h"
#include "sightline/core/primitive.h"
#include "sightline/core/view.h"

namespace sightline::core::conventions_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr float kMaxFloat = std::numeric_limits<float>::max();

std::array<Plane, kFrustumPlaneCount> planes_of(const View& view) {
  return frustum_planes(view.clip_from_world(), view.clip_depth());
}

double depth_at(const View& view, const dvec3& world) {
  const dvec4 clip = view.clip_from_world() * dvec4(world, 1.0);
  return clip.z / clip.w;
}

/// At (10, 20, 30), looking along +y, 90 degrees high, square.
Pose test_pose() {
  return {{10, 20, 30}, {10, 21, 30}, {0, 0, 1}};
}

TEST(Conventions, WorldIsRightHandedAndEyeSpaceLooksDownMinusZ) {
  // Facing +y with z up, +x lies to the right: so it is in a right-handed world.
  const dmat4 eye = look_at(test_pose()).value();
  EXPECT_EQ(dvec3(eye * dvec4(11, 20, 30, 1)), dvec3(1, 0, 0));
  EXPECT_EQ(dvec3(eye * dvec4(10, 20, 31, 1)), dvec3(0, 1, 0));
  EXPECT_EQ(dvec3(eye * dvec4(10, 21, 30, 1)), dvec3(0, 0, -1));
  EXPECT_DOUBLE_EQ(glm::determinant(dmat3(eye)), 1.0);
  const Pose standard;
  EXPECT_EQ(standard.up, dvec3(0, 0, 1)) << "Z is up";
}

TEST(Conventions, MatricesTakeColumnVectorsAndChainFromTheRight) {
  const Affine world_from_node = translation({1, 2, 3});
  const Affine node_from_item{dmat3(2.0), dvec3(0.0)};
  const dvec3 p(1, 1, 1);
  EXPECT_EQ(transform_point(world_from_node * node_from_item, p), dvec3(3, 4, 5)) << "item to node to world";
  EXPECT_EQ(transform_point(world_from_node * node_from_item, p),
            transform_point(world_from_node, transform_point(node_from_item, p)));
  const View view = View::perspective(test_pose(), 1.0, 1.5, 0.1, 100.0).value();
  EXPECT_EQ(view.clip_from_world(), view.clip_from_eye() * view.eye_from_world());
  EXPECT_EQ(dvec3(view.eye_from_world()[3]), dvec3(view.eye_from_world() * dvec4(0, 0, 0, 1)))
      << "the translation is the last column";
}

TEST(Conventions, PlanesPointInsideInTheOrderLeftRightBottomTopNearFar) {
  EXPECT_EQ(kLeft, 0);
  EXPECT_EQ(kRight, 1);
  EXPECT_EQ(kBottom, 2);
  EXPECT_EQ(kTop, 3);
  EXPECT_EQ(kNear, 4);
  EXPECT_EQ(kFar, 5);
  EXPECT_EQ(kFrustumPlaneCount, 6);
  EXPECT_EQ(evaluate({{0, 0, 2}, -4}, {7, 7, 3}), 2.0) << "dot(n, p) + d";

  const View views[] = {View::perspective(test_pose(), kPi / 2, 1.0, 1.0, 100.0).value(),
                        View::orthographic(test_pose(), 40.0, 1.0, 1.0, 100.0).value()};
  for (const View& view : views) {
    const auto planes = planes_of(view);
    // At 20 m ahead both views are 40 m wide and high. Each point lies outside one plane alone.
    const dvec3 centre(10, 40, 30);
    const dvec3 outside[] = {centre - dvec3(21, 0, 0), centre + dvec3(21, 0, 0), centre - dvec3(0, 0, 21),
                             centre + dvec3(0, 0, 21), dvec3(10, 20.5, 30),      dvec3(10, 121, 30)};
    for (int i = 0; i < kFrustumPlaneCount; ++i) {
      EXPECT_GT(evaluate(planes[i], centre), 0.0);
      for (int j = 0; j < kFrustumPlaneCount; ++j) {
        if (i == j) {
          EXPECT_LT(evaluate(planes[i], outside[j]), 0.0) << "plane " << i;
        } else {
          EXPECT_GT(evaluate(planes[i], outside[j]), 0.0) << "plane " << i << " point " << j;
        }
      }
    }
  }
}

TEST(Conventions, DepthIsOneAtTheNearPlaneAndZeroAtTheFarPlane) {
  const auto ahead = [](double distance) { return dvec3(10.0, 20.0 + distance, 30.0); };
  const View finite = View::perspective(test_pose(), 1.0, 1.5, 0.25, 100.0).value();
  EXPECT_NEAR(depth_at(finite, ahead(0.25)), 1.0, 1e-13);
  EXPECT_NEAR(depth_at(finite, ahead(100.0)), 0.0, 1e-13);
  const View ortho = View::orthographic(test_pose(), 10.0, 1.0, -5.0, 100.0).value();
  EXPECT_NEAR(depth_at(ortho, ahead(-5.0)), 1.0, 1e-13);
  EXPECT_NEAR(depth_at(ortho, ahead(100.0)), 0.0, 1e-13);
  EXPECT_NEAR(depth_at(ortho, ahead(47.5)), 0.5, 1e-13);
  const View infinite = View::perspective(test_pose(), 1.0, 1.5, 0.25).value();
  EXPECT_NEAR(depth_at(infinite, ahead(0.25)), 1.0, 1e-13);
  EXPECT_NEAR(depth_at(infinite, ahead(0.5)), 0.5, 1e-13) << "near / distance";
  EXPECT_GT(depth_at(infinite, ahead(1e12)), 0.0);
  EXPECT_LT(depth_at(infinite, ahead(1e12)), 1e-12);
  double last = 2.0;
  for (double d = 0.25; d < 99.0; d *= 1.1) {
    EXPECT_LT(depth_at(finite, ahead(d)), last) << "nearer is greater";
    last = depth_at(finite, ahead(d));
  }
}

TEST(Conventions, ClassicDepthRunsFromMinusOneToOne) {
  EXPECT_EQ(View::perspective(test_pose(), 1.0, 1.0, 0.1).value().clip_depth(), ClipDepth::kReversedZeroToOne);
  // glFrustum of 90 degrees, near 1, far 3.
  dmat4 clip(0.0);
  clip[0][0] = clip[1][1] = 1.0;
  clip[2][2] = -2.0;
  clip[3][2] = -3.0;
  clip[2][3] = -1.0;
  const auto planes = frustum_planes(clip, ClipDepth::kMinusOneToOne);
  EXPECT_NEAR(evaluate(planes[kNear], {0, 0, -1}), 0.0, 1e-15);
  EXPECT_NEAR(evaluate(planes[kFar], {0, 0, -3}), 0.0, 1e-15);
  EXPECT_LT(evaluate(planes[kNear], {0, 0, -0.9}), 0.0);
  EXPECT_LT(evaluate(planes[kFar], {0, 0, -3.1}), 0.0);
}

TEST(Conventions, PlainDepthRunsFromZeroToOne) {
  EXPECT_EQ(near_depth(ClipDepth::kReversedZeroToOne), 1.0);
  EXPECT_EQ(far_depth(ClipDepth::kReversedZeroToOne), 0.0);
  EXPECT_EQ(near_depth(ClipDepth::kMinusOneToOne), -1.0);
  EXPECT_EQ(far_depth(ClipDepth::kMinusOneToOne), 1.0);
  EXPECT_EQ(near_depth(ClipDepth::kZeroToOne), 0.0);
  EXPECT_EQ(far_depth(ClipDepth::kZeroToOne), 1.0);
  // As of Vulkan: 90 degrees, near 1, far 3.
  dmat4 clip(0.0);
  clip[0][0] = clip[1][1] = 1.0;
  clip[2][2] = -1.5;
  clip[3][2] = -1.5;
  clip[2][3] = -1.0;
  const auto planes = frustum_planes(clip, ClipDepth::kZeroToOne);
  EXPECT_NEAR(evaluate(planes[kNear], {0, 0, -1}), 0.0, 1e-15);
  EXPECT_NEAR(evaluate(planes[kFar], {0, 0, -3}), 0.0, 1e-15);
  EXPECT_LT(evaluate(planes[kNear], {0, 0, -0.9}), 0.0);
  EXPECT_LT(evaluate(planes[kFar], {0, 0, -3.1}), 0.0);
}

TEST(Conventions, AnglesAreRadiansCounterClockwiseFromPlusXTowardsPlusY) {
  const Primitive quarter = CircularTorus{10.0f, 1.0f, float(kPi / 2)};
  EXPECT_NEAR(support(quarter, {0, 1, 0}), 11.0, 1e-6);
  EXPECT_NEAR(support(quarter, {0, -1, 0}), 0.0, 1e-6) << "nothing swept towards -Y";
  EXPECT_NEAR(support(quarter, {-1, 0, 0}), 0.0, 1e-6);
}

TEST(Conventions, FrontFacesAreCounterClockwise) {
  // A triangle whose right-hand normal points at the eye must come out counter-clockwise on a screen with y up.
  const View view = View::perspective(test_pose(), kPi / 2, 1.0, 1.0).value();
  const dvec3 triangle[] = {{10, 40, 30}, {11, 40, 30}, {10, 40, 31}};
  const dvec3 normal = glm::cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
  ASSERT_GT(glm::dot(normal, test_pose().eye - triangle[0]), 0.0);
  dvec2 screen[3];
  for (int i = 0; i < 3; ++i) {
    const dvec4 clip = view.clip_from_world() * dvec4(triangle[i], 1.0);
    screen[i] = dvec2(clip) / clip.w;
  }
  const dvec2 a = screen[1] - screen[0], b = screen[2] - screen[0];
  EXPECT_GT(a.x * b.y - a.y * b.x, 0.0);
}

TEST(Conventions, BoxesAreClosed) {
  EXPECT_FALSE((AabbD{dvec3(1.0), dvec3(1.0)}).empty()) << "a point is a box";
  EXPECT_FALSE((Aabb{vec3(1.0f), vec3(1.0f)}).empty());
  EXPECT_TRUE(AabbD{}.empty());
  EXPECT_TRUE(Aabb{}.empty());
  EXPECT_TRUE((AabbD{dvec3(std::nan("")), dvec3(1.0)}).empty());
  // A box that touches a plane has a corner that evaluates to 0, which counts as inside.
  const Plane plane{{1, 0, 0}, -2.0};
  EXPECT_GE(evaluate(plane, {2, 5, 5}), 0.0);
}

TEST(Conventions, EmptyBoxesAreNeutralForGrow) {
  const AabbD d{dvec3(-1, 2, 3), dvec3(4, 5, 6)};
  AabbD grown = d;
  grown.grow(AabbD{});
  EXPECT_EQ(grown.min, d.min);
  EXPECT_EQ(grown.max, d.max);
  AabbD from_empty;
  from_empty.grow(d);
  EXPECT_EQ(from_empty.min, d.min);
  EXPECT_EQ(from_empty.size(), dvec3(5, 3, 3));
  EXPECT_EQ(AabbD{}.size(), dvec3(0.0));
  Aabb f{vec3(-1.0f), vec3(1.0f)};
  f.grow(Aabb{});
  EXPECT_EQ(f.min, vec3(-1.0f));
  EXPECT_EQ(f.max, vec3(1.0f));
}

TEST(Conventions, LayersAndKindsAreFixed) {
  EXPECT_EQ(kNone, 0xffffffffu);
  EXPECT_NE(kDefaultLayerMask & kLayerModel, 0u);
  EXPECT_EQ(kDefaultLayerMask & kLayerObstruction, 0u);
  EXPECT_EQ(kDefaultLayerMask & kLayerInsulation, 0u);
}

// --- outward rounding ------------------------------------------------------------------------------------------------

/// Checks both directions at x against the definition: the largest float <= x, the smallest float >= x.
void expect_tight(double x) {
  const float down = round_down(x), up = round_up(x);
  ASSERT_LE(double(down), x) << std::hexfloat << x;
  ASSERT_GE(double(up), x) << std::hexfloat << x;
  if (std::abs(x) >= double(Aabb::kFar)) return;
  ASSERT_GT(double(std::nextafterf(down, kMaxFloat)), x) << std::hexfloat << x;
  ASSERT_LT(double(std::nextafterf(up, -kMaxFloat)), x) << std::hexfloat << x;
}

TEST(OutwardRounding, IsTightForEveryExponent) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 2'000'000; ++i) {
    // Any double of magnitude below 3e38, by its bits.
    const double x = std::bit_cast<double>(random());
    if (std::isfinite(x) && std::abs(x) < 3e38) {
      ASSERT_NO_FATAL_FAILURE(expect_tight(x));
    }
    const float f = std::bit_cast<float>(std::uint32_t(random()));
    if (!std::isfinite(f) || std::abs(f) >= Aabb::kFar) continue;
    ASSERT_EQ(round_down(double(f)), f);
    ASSERT_EQ(round_up(double(f)), f);
    ASSERT_NO_FATAL_FAILURE(expect_tight(std::nextafter(double(f), 1e300)));
    ASSERT_NO_FATAL_FAILURE(expect_tight(std::nextafter(double(f), -1e300)));
  }
}

TEST(OutwardRounding, HoldsAtTheEndsOfTheRange) {
  const double tiny = std::numeric_limits<double>::denorm_min(), tiny_float = std::numeric_limits<float>::denorm_min();
  for (const double x : {0.0, tiny, tiny_float, 0.5 * tiny_float, 1.5 * tiny_float, 1e-40, 1.1754943508222875e-38, 1.0,
                         1e7 + 0.3, 16777217.0, 1e38, 2.9999999e38, 3.0e38, 3.1e38, 3.4028234663852886e38}) {
    expect_tight(x);
    expect_tight(-x);
  }
  EXPECT_EQ(round_down(tiny), 0.0f);
  EXPECT_EQ(round_up(tiny), std::numeric_limits<float>::denorm_min());
  EXPECT_EQ(round_down(-tiny), -std::numeric_limits<float>::denorm_min());
}

TEST(OutwardRounding, ClampsBeyondTheFloatRangeToFiniteValues) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const double x : {1e39, 1e300, inf}) {
    EXPECT_EQ(round_down(x), Aabb::kFar);
    EXPECT_TRUE(std::isfinite(round_down(-x)));
    EXPECT_TRUE(std::isfinite(round_up(x)));
    EXPECT_LE(round_down(-x), -Aabb::kFar);
    EXPECT_GE(round_up(x), Aabb::kFar);
    EXPECT_EQ(round_up(-x), -Aabb::kFar);
  }
}

/// Out of line and with neighbours, as compilers like to vectorise it.
struct Rounded {
  double x, y, z;
};
#if defined(__GNUC__)
__attribute__((noinline))
#endif
Rounded
through_float(double x, double y, double z) {
  return {double(float(x)), double(float(y)), double(float(z))};
}

TEST(OutwardRounding, CompilersKeepTheRoundingToFloat) {
  // g++ 12 does not, unless told to leave straight-line code alone: see cmake/SightlineTargets.cmake.
  const Rounded r = through_float(0.1, 0.2, 0.3);
  EXPECT_EQ(r.x, 0.100000001490116119384765625);
  EXPECT_EQ(r.y, 0.20000000298023223876953125);
  EXPECT_EQ(r.z, 0.300000011920928955078125);
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> value(-1e7, 1e7);
  for (int i = 0; i < 1000; ++i) {
    AabbD box;
    box.grow(dvec3(value(random), value(random), value(random)));
    const Aabb out = round_outwards(box, dvec3(0.0));
    const dvec3 back(out.min);
    for (int axis = 0; axis < 3; ++axis) ASSERT_LT(back[axis], box.min[axis]) << "a random double is no float";
  }
}

TEST(OutwardRounding, BoxesContainTheirOriginalRelativeToAnyOrigin) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> exponent(-12.0, 12.0), sign(-1.0, 1.0);
  const auto value = [&] { return std::copysign(std::pow(10.0, exponent(random)), sign(random)); };
  for (int i = 0; i < 200'000; ++i) {
    AabbD box;
    box.grow({value(), value(), value()});
    box.grow({value(), value(), value()});
    const dvec3 origin(value(), value(), value());
    const Aabb out = round_outwards(box, origin);
    for (int axis = 0; axis < 3; ++axis) {
      // The float value plus the origin, in more precision than the subtraction had.
      const long double lo = (long double)(out.min[axis]) + origin[axis],
                        hi = (long double)(out.max[axis]) + origin[axis];
      ASSERT_LE(lo, (long double)(box.min[axis]));
      ASSERT_GE(hi, (long double)(box.max[axis]));
      const double slack = 1e-6 * (1e-3 + std::abs(box.max[axis] - origin[axis])) + 1e-15 * std::abs(origin[axis]);
      ASSERT_NEAR(double(hi), box.max[axis], slack);
    }
  }
  // The subtraction itself rounds: to a float that is no bound.
  const AabbD speck{dvec3(-0x1p-60), dvec3(0x1p-60)};
  EXPECT_LT(round_outwards(speck, dvec3(1.0)).min.x, -1.0f);
  EXPECT_GT(round_outwards(speck, dvec3(-1.0)).max.x, 1.0f);
  EXPECT_TRUE(round_outwards(AabbD{}, dvec3(5.0)).empty());
}

}  // namespace
}  // namespace sightline::core::conventions_test
