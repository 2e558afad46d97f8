// The headers of core in an application that is not compiled with the library's flags (cmake/SightlineTargets.cmake):
// here neighbouring roundings to float may be vectorised, and products contracted with sums. What the headers promise
// bit for bit must hold all the same, so it must not depend on code that is compiled here.
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/aabb.h"
#include "sightline/core/internal/instruction_set.h"
#include "sightline/core/view.h"

namespace sightline::core::embedder_flags_test {
namespace {

class EmbedderFlags : public testing::Test {
 protected:
  void SetUp() override {
#if defined(__FMA__)
    if (!supported(InstructionSet::kAvx2)) GTEST_SKIP() << "compiled for a processor with FMA";
#endif
  }
  double value() {
    return std::copysign(std::exp2(exponent_(random_)), sign_(random_));
  }
  dvec3 point() {
    return {value(), value(), value()};
  }

  std::mt19937_64 random_{5};

 private:
  std::uniform_real_distribution<double> exponent_{-20.0, 20.0}, sign_{-1.0, 1.0};
};

// One operation at a time, through memory.
double product(double a, double b) {
  volatile double exact = a * b;
  return exact;
}
double sum(double a, double b) {
  volatile double exact = a + b;
  return exact;
}
float below(double x) {
  volatile float f = float(x);
  return double(f) <= x ? f : std::nextafterf(f, -3e38f);
}

/// The smallest box around `box - origin`, as round_outwards() promises it.
void expect_rounded(const Aabb& out, const AabbD& box, const dvec3& origin) {
  for (int i = 0; i < 3; ++i) {
    const double low = sum(box.min[i], -origin[i]), high = sum(box.max[i], -origin[i]);
    ASSERT_EQ(out.min[i], below(std::nextafter(low, -INFINITY)));
    ASSERT_EQ(out.max[i], -below(std::nextafter(-high, -INFINITY)));
  }
}

TEST_F(EmbedderFlags, BoxesAreRoundedOutwards) {
  constexpr int kCount = 20'000;
  std::vector<AabbD> boxes(kCount);
  for (AabbD& box : boxes) box.grow(point()), box.grow(point());
  for (const dvec3& origin : {dvec3(0.0), point(), point()}) {
    std::vector<Aabb> out(kCount);
    for (int i = 0; i < kCount; ++i) out[i] = round_outwards(boxes[i], origin);
    for (int i = 0; i < kCount; ++i) ASSERT_NO_FATAL_FAILURE(expect_rounded(out[i], boxes[i], origin));
  }
  for (const AabbD& box : boxes) {
    const vec3 low(round_down(box.min.x), round_down(box.min.y), round_down(box.min.z));
    const vec3 high(round_up(box.max.x), round_up(box.max.y), round_up(box.max.z));
    for (int i = 0; i < 3; ++i) {
      ASSERT_EQ(low[i], below(box.min[i]));
      ASSERT_EQ(high[i], -below(-box.max[i]));
    }
  }
}

/// A contracted multiply-add would round another box than the one that is given.
TEST_F(EmbedderFlags, BoxesOfProductsAreRoundedOutwards) {
  for (int n = 0; n < 20'000; ++n) {
    const dvec3 half = point(), scale = point();
    const dvec3 size(std::abs(half.x * scale.x), std::abs(half.y * scale.y), std::abs(half.z * scale.z));
    const Aabb out = round_outwards({-size, size}, -0.999999 * size);
    AabbD exact;
    dvec3 origin;
    for (int i = 0; i < 3; ++i) {
      exact.max[i] = std::abs(product(half[i], scale[i]));
      exact.min[i] = -exact.max[i];
      origin[i] = product(-0.999999, exact.max[i]);
    }
    ASSERT_NO_FATAL_FAILURE(expect_rounded(out, exact, origin));
  }
}

/// The sixteen numbers that define a view's volume are the same for the application and for the cullers.
TEST_F(EmbedderFlags, TheMatrixOfAViewIsTheLibrarys) {
  int taken = 0;  // some look like projections of another depth, which are refused
  for (int n = 0; n < 1000; ++n) {
    dmat4 eye, clip;
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) {
        eye[c][r] = r < 3 ? value() : double(c == 3);  // affine
        clip[c][r] = value();
      }
    const auto view = View::from_matrices(eye, clip, ClipDepth::kReversedZeroToOne);
    if (!view) continue;
    ++taken;
    const dmat4 found = view->clip_from_world();
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) {
        double expected = product(clip[0][r], eye[c][0]);
        for (int k = 1; k < 4; ++k) expected = sum(expected, product(clip[k][r], eye[c][k]));
        ASSERT_EQ(found[c][r], expected);
      }
  }
  EXPECT_GT(taken, 500);
}

}  // namespace
}  // namespace sightline::core::embedder_flags_test
