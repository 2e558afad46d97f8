// What holds for every kind: dispatch, undefined input, absolute lengths.
#include "sightline/gpuprims/internal/primitives.h"

#include <limits>

#include <gtest/gtest.h>

namespace sightline::gpuprims::primitives_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();

/// One of each kind that the ray below meets.
const core::Primitive kPrimitives[] = {core::Pyramid{4, 4, 3, 3, 0.5f, 0, 4},
                                       core::Box{4, 4, 4},
                                       core::RectangularTorus{0.1f, 4, 4, 3},
                                       core::CircularTorus{2, 2, 3},
                                       core::EllipticalDish{4, 3},
                                       core::SphericalDish{4, 3},
                                       core::Snout{2, 3, 4, 0, 0, 0.1f, 0, 0, 0},
                                       core::Cylinder{3, 4},
                                       core::Sphere{6}};
const Ray kRay{{0.7, 9.0, 0.6}, {0.05, -1.0, 0.02}};

TEST(EveryPrimitive, IsHitThroughTheDispatch) {
  for (const core::Primitive& primitive : kPrimitives)
    EXPECT_GE(intersect(primitive, kRay).count, 2) << core::name_of(core::kind_of(primitive));
  EXPECT_EQ(intersect(core::Primitive(core::Line{-1, 1}), kRay).count, 0);
}

TEST(EveryPrimitive, HidesWithAnUndefinedParameterOrRay) {
  for (const core::Primitive& primitive : kPrimitives) {
    SCOPED_TRACE(core::name_of(core::kind_of(primitive)));
    const auto values = core::parameters(primitive);
    for (std::size_t i = 0; i < values.size(); ++i) {
      for (const float bad : {kNan, kInfinity, -kInfinity}) {
        std::vector<float> changed(values.begin(), values.end());
        changed[i] = bad;
        const core::Primitive undefined = core::make_primitive(core::kind_of(primitive), changed);
        EXPECT_EQ(intersect(undefined, kRay).count, 0) << "parameter " << i << " is " << bad;
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      for (const double bad : {double(kNan), double(kInfinity)}) {
        Ray ray = kRay;
        ray.origin[axis] = bad;
        EXPECT_EQ(intersect(primitive, ray).count, 0) << "origin";
        ray = kRay;
        ray.direction[axis] = bad;
        EXPECT_EQ(intersect(primitive, ray).count, 0) << "direction";
      }
    }
    EXPECT_EQ(intersect(primitive, {kRay.origin, core::dvec3(0.0)}).count, 0) << "no direction";
  }
}

TEST(EveryPrimitive, TakesDirectionsOfAnyLength) {
  for (const core::Primitive& primitive : kPrimitives) {
    SCOPED_TRACE(core::name_of(core::kind_of(primitive)));
    const Hits expected = intersect(primitive, kRay);
    for (const int exponent : {-1000, -300, 300, 1000}) {
      const double scale = std::ldexp(1.0, exponent);
      const Hits hits = intersect(primitive, {kRay.origin, scale * kRay.direction});
      ASSERT_EQ(hits.count, expected.count) << exponent;
      for (int i = 0; i < hits.count; ++i) EXPECT_EQ(hits.hit[i].t, expected.hit[i].t / scale) << exponent;
    }
  }
}

TEST(EveryPrimitive, TakesNegativeLengthsAsAbsolute) {
  const core::Primitive negative[] = {core::Pyramid{-4, -4, -3, -3, 0.5f, 0, -4},
                                      core::Box{-4, -4, -4},
                                      core::RectangularTorus{-0.1f, -4, -4, -3},
                                      core::CircularTorus{-2, -2, -3},
                                      core::EllipticalDish{-4, -3},
                                      core::SphericalDish{-4, -3},
                                      core::Snout{-2, -3, -4, 0, 0, 0.1f, 0, 0, 0},
                                      core::Cylinder{-3, -4},
                                      core::Sphere{-6}};
  for (std::size_t k = 0; k < std::size(negative); ++k) {
    SCOPED_TRACE(core::name_of(core::kind_of(negative[k])));
    const Hits a = intersect(negative[k], kRay), b = intersect(kPrimitives[k], kRay);
    ASSERT_EQ(a.count, b.count);
    for (int i = 0; i < a.count; ++i) EXPECT_EQ(a.hit[i].t, b.hit[i].t);
  }
}

}  // namespace
}  // namespace sightline::gpuprims::primitives_test
