// The conservative promise against exact arithmetic: 10^7 box/view pairs in a long run, none lost.
// SIGHTLINE_EXACT_PAIRS=1000000000 asks for as many; the families share them, and each draws the same pairs in every
// run, so a longer run begins with a shorter one's.
//
// Extra are boxes kept although, exactly, their p-vertex is outside some plane. Beyond those, testing plane by plane
// keeps boxes that pass every plane and still miss the volume (near its edges); that is inherent, and only printed.
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include <gtest/gtest.h>

#include "box_view_pairs.h"
#include "exact_reference.h"
#include "scenes.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/frustum_test.h"
#include "sightline/culling/frustum/linear_culler.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests::conservative_test {
namespace {

using core::Aabb;
using core::dvec3;
using core::View;

double pairs_wanted() {
  double pairs = repeated(10'000'000);
  if (const char* text = std::getenv("SIGHTLINE_EXACT_PAIRS")) pairs = std::strtod(text, nullptr);
  return pairs;
}

struct Tally {
  std::uint64_t pairs = 0, kept = 0, extra = 0, lost = 0, rationals = 0;
  std::uint64_t beyond_promise = 0;  // extra by more than CullPlanes promises
  std::uint64_t sampled = 0, missing_the_volume = 0;

  void print(const char* what) const {
    std::printf(
        "%-10s %llu pairs, %llu kept, %llu lost, %llu extra (%llu by more than 2e-15), %llu planes decided in "
        "rationals",
        what, ull(pairs), ull(kept), ull(lost), ull(extra), ull(beyond_promise), ull(rationals));
    if (sampled != 0)
      std::printf("; of %llu kept boxes sampled %llu pass every plane exactly and miss the volume", ull(sampled),
                  ull(missing_the_volume));
    std::printf("\n");
  }
  static unsigned long long ull(std::uint64_t n) { return n; }
};

constexpr std::uint64_t kSamples = 250;

/// Both cullers and the one-box test against the exact answer.
void compare(const PairBlock& block, bool sample, Tally& tally) {
  const Scene scene(block.boxes, block.origin);
  core::VisibleSet set;
  for (const View& view : block.views) {
    scene.culler->cull(view, set);
    const auto slots = scene.occupied(set);
    culling::LinearCuller(scene.bounds).cull(view, set);
    ASSERT_EQ(slots, set.sorted_slots());
    const culling::CullPlanes planes(view, scene.bounds);
    View moved = view;
    for (core::Plane& section : moved.sections) section = moved_outwards(section, scene.bounds);
    ExactVolume exact(moved);
    auto next = slots.begin();
    for (core::Slot slot = 0; slot < scene.bounds.size(); ++slot) {
      const Aabb box = scene.bounds.box(slot);
      const bool kept = next != slots.end() && *next == slot;
      next += kept;
      if (kept != (!planes.nothing_visible() && planes.visible(box, planes.all())))
        FAIL() << "the one-box test says otherwise of slot " << slot;
      const bool expected = exact.passes(block.origin, box);
      ++tally.pairs;
      tally.kept += kept;
      tally.extra += kept && !expected;
      tally.lost += !kept && expected;
      if (!kept && expected) FAIL() << "lost slot " << slot;
      if (kept && !expected && !exact.nearly_passes(block.origin, box, 2e-15L)) ++tally.beyond_promise;
      if (sample && tally.sampled < kSamples && kept && expected && !exact.has_union() && tally.kept % 1000 == 0) {
        ++tally.sampled;
        tally.missing_the_volume += !exact.meets(block.origin, box);
      }
    }
    tally.rationals += exact.decided_in_rationals;
  }
}

class Conservative : public testing::TestWithParam<std::size_t> {};

TEST_P(Conservative, LosesNothing) {
  const PairFamily& family = kPairFamilies[GetParam()];
  const bool random_family = family.make == random_pairs;
  Tally tally;
  for (std::uint64_t seed = 1; double(tally.pairs) < family.share * pairs_wanted(); ++seed) {
    SCOPED_TRACE(testing::Message() << "block " << seed);
    Random random((std::uint64_t(GetParam()) << 32) + seed);
    ASSERT_NO_FATAL_FAILURE(compare(family.make(random), random_family, tally));
  }
  tally.print(family.name);
  EXPECT_GT(tally.pairs, 0u) << "SIGHTLINE_EXACT_PAIRS is no number";
  EXPECT_EQ(tally.lost, 0u);
  if (family.make != matrix_pairs) {  // there planes overflow and are dropped, or underflow
    EXPECT_EQ(tally.beyond_promise, 0u);
  }
  if (random_family) {
    EXPECT_LE(double(tally.extra), 1e-4 * double(tally.kept));
  }
  if (pairs_wanted() < 1e7) return;  // blocks differ: few of them need not hold everything
  EXPECT_GT(tally.kept, tally.pairs / 50);
  EXPECT_LT(tally.kept, tally.pairs - tally.pairs / 50);
  if (!random_family) {
    EXPECT_GT(tally.rationals, tally.pairs / 1000) << "the boxes are meant to be close calls";
  }
}

INSTANTIATE_TEST_SUITE_P(Families, Conservative, testing::Range(std::size_t(0), kPairFamilies.size()),
                         [](const auto& family) { return kPairFamilies[family.param].name; });

/// The filter never contradicts the rationals, and leaves them only what is close.
TEST(ExactReference, FilterIsNeverWrong) {
  std::uint64_t decided = 0, left = 0;
  const auto check = [&](const ExactPlane& plane, const dvec3& origin, const core::vec3& corner) {
    const int filtered = plane.filtered_sign(origin, corner);
    ++(filtered != 0 ? decided : left);
    if (filtered != 0) {
      ASSERT_EQ(filtered, plane.exact_sign(origin, corner));
    }
  };
  Random random(77);
  for (int i = 0; i < 40000; ++i) {
    SCOPED_TRACE(testing::Message() << "plane " << i);
    const double low = chance(random, 0.3) ? 1e-320 : 1e-8, high = chance(random, 0.3) ? 1.7e308 : 1e8;
    std::array<double, 4> a, b;
    for (std::size_t k = 0; k < 4; ++k) {
      a[k] = (chance(random, 0.5) ? 1.0 : -1.0) * magnitude(random, low, high);
      // The sum of the two cancels to nothing, to last bits, or not at all.
      b[k] = chance(random, 0.3) ? 0.0 : chance(random, 0.5) ? step(-a[k], whole(random, -2, 2)) : -a[k] * 1e-17;
    }
    const dvec3 origin = random_origin(random);
    core::vec3 corner(point(random, magnitude(random, 1e-30, 1e30)));
    // The offset that brings the point onto the plane, in double and then split in two: off by 2^-53 and by 2^-106.
    mpq_class rest = 0;
    const ExactPlane through_zero(a, b);
    for (int k = 0; k < 3; ++k)
      rest -= through_zero.exact[std::size_t(k)] * (mpq_class(origin[k]) + mpq_class(double(corner[k])));
    const double first = rest.get_d();
    if (std::isfinite(first)) {
      a[3] = first;
      b[3] = mpq_class(rest - mpq_class(first)).get_d();
      if (chance(random, 0.4)) b[3] *= 1.0 + uniform(random, -1e-3, 1e-3);
      if (chance(random, 0.1)) b[3] = 0.0;
    }
    const ExactPlane plane(a, b);
    ASSERT_NO_FATAL_FAILURE(check(plane, origin, corner));
    corner[i % 3] = step(corner[i % 3], whole(random, -2, 2));
    ASSERT_NO_FATAL_FAILURE(check(plane, origin, corner));
  }
  EXPECT_GT(decided, 10000u);
  EXPECT_GT(left, 10000u);
}

/// What is no number never becomes a view; in section planes it hides nothing (see matrix_pairs).
TEST(ExactReference, ViewsAreFinite) {
  for (int i = 0; i < 16; ++i) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e200}) {
      core::dmat4 clip(1.0);
      clip[i / 4][i % 4] = bad;
      // 1e200 is finite, and its product with the other matrix is not.
      EXPECT_FALSE(View::from_matrices(core::dmat4(1e200), clip, core::ClipDepth::kMinusOneToOne)) << i;
    }
  }
}

/// Boxes that touch axis-parallel planes without any rounding, and boxes one step away.
TEST(ConservativeByHand, TouchingBoxesAreKept) {
  for (const double offset : {0.0, 1e7}) {
    const dvec3 origin(offset);
    View view = *View::orthographic({origin, origin + dvec3(0, 1, 0), {0, 0, 1}}, 4.0, 1.0, 0.0, 4.0);
    view.sections = {{{-1, 0, 0}, offset + 1.0}};
    const auto keeps = [&](const Aabb& box) {
      const std::vector<Aabb> one{box};
      const Scene scene(one, origin);
      core::VisibleSet set;
      scene.culler->cull(view, set);
      return set.count() == 1;
    };
    for (const double size : {0.0, 1.0}) {
      EXPECT_TRUE(keeps({core::vec3(1, 1, 0), core::vec3(1 + size, 1 + size, size)})) << "section";
      EXPECT_TRUE(keeps({core::vec3(-2 - size, 1, 0), core::vec3(-2, 1 + size, size)})) << "left";
      EXPECT_TRUE(keeps({core::vec3(0, 1, 2), core::vec3(size, 1 + size, 2 + size)})) << "top";
      EXPECT_TRUE(keeps({core::vec3(0, -size, 0), core::vec3(size, 0, size)})) << "near";
      EXPECT_TRUE(keeps({core::vec3(0, 4, 0), core::vec3(size, 4 + size, size)})) << "far";
      EXPECT_FALSE(keeps({core::vec3(1.001f, 1, 0), core::vec3(1.001 + size, 1 + size, size)})) << "section";
      EXPECT_FALSE(keeps({core::vec3(-2.001 - size, 1, 0), core::vec3(-2.001f, 1 + size, size)})) << "left";
      EXPECT_FALSE(keeps({core::vec3(0, -0.001 - size, 0), core::vec3(size, -0.001f, size)})) << "near";
    }
  }
}

}  // namespace
}  // namespace sightline::tests::conservative_test
