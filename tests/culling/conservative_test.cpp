// The conservative promise against exact arithmetic: 10^6 random and adversarial pairs of box and view, none lost.
//
// Extra are boxes kept although, exactly, their p-vertex is outside some plane. Beyond those, testing plane by plane
// keeps boxes that pass every plane and still miss the volume (near its edges); that is inherent, and only printed.
#include <algorithm>
#include <cstdio>

#include <gtest/gtest.h>

#include "exact_reference.h"
#include "scenes.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/linear_culler.h"

namespace sightline::tests {
namespace {

using core::Aabb;
using core::dvec3;
using core::View;

struct Tally {
  std::uint64_t pairs = 0, kept = 0, extra = 0, lost = 0, rationals = 0, sampled = 0, missing_the_volume = 0;

  void print(const char* what) const {
    std::printf(
        "%s: %llu pairs, %llu kept, %llu lost, %llu extra, %llu planes decided in rationals; "
        "of %llu kept boxes sampled %llu pass every plane exactly and miss the volume\n",
        what, ull(pairs), ull(kept), ull(lost), ull(extra), ull(rationals), ull(sampled), ull(missing_the_volume));
  }
  static unsigned long long ull(std::uint64_t n) { return n; }
};

/// Culls the boxes both ways and compares with the exact answer; every `sample`-th kept one is intersected, too.
void compare(const std::vector<Aabb>& boxes, const dvec3& origin, const View& view, std::uint64_t sample,
             Tally& tally) {
  const Scene scene(boxes, origin);
  ExactVolume exact(view);
  core::VisibleSet set;
  scene.culler->cull(view, set);
  const auto slots = set.sorted_slots();
  culling::LinearCuller(scene.bounds).cull(view, set);
  ASSERT_EQ(slots, set.items);
  for (core::Slot slot = 0; slot < boxes.size(); ++slot) {
    const Aabb box = scene.bounds.box(slot);
    const bool kept = std::binary_search(slots.begin(), slots.end(), slot);
    const bool expected = exact.passes(origin, box);
    ++tally.pairs;
    tally.kept += kept;
    tally.extra += kept && !expected;
    tally.lost += !kept && expected;
    if (kept && expected && sample != 0 && !exact.has_union() && tally.kept % sample == 0) {
      ++tally.sampled;
      tally.missing_the_volume += !exact.meets(origin, box);
    }
    ASSERT_TRUE(kept || !expected) << "lost slot " << slot;
  }
  tally.rationals += exact.decided_in_rationals;
}

dvec3 random_origin(Random& random) {
  return chance(random, 0.3) ? dvec3(0.0) : chance(random, 0.5) ? point(random, 1e3) : point(random, 1e7);
}

TEST(Conservative, RandomBoxes) {
  Tally tally;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const double half = magnitude(random, 1e-2, 1e4);
    const dvec3 origin = random_origin(random);
    View view = random_view(random, origin, half);
    if (chance(random, 0.2)) add_sections(random, origin, half, view);
    auto boxes = random_boxes(random, 1000, half);
    ASSERT_NO_FATAL_FAILURE(compare(boxes, origin, view, 50, tally));
  }
  tally.print("random");
  EXPECT_EQ(tally.lost, 0u);
  EXPECT_LE(double(tally.extra), 1e-4 * double(tally.kept));
}

// --- adversarial -----------------------------------------------------------------------------------------------------

/// Projections at their limits: very narrow, nearly flat, near planes of nanometres, depth ranges of 1 : 10^9.
View degenerate_view(Random& random, const dvec3& origin, double half) {
  core::Pose pose;
  pose.eye = origin + point(random, half);
  pose.target = origin + point(random, half);
  const double degree = std::numbers::pi / 180.0;
  const double fovy = chance(random, 0.5) ? 0.01 * degree : 179.9 * degree;
  const double near = half * (chance(random, 0.5) ? 1e-9 : 1e-3);
  auto view = View::perspective(pose, fovy, magnitude(random, 0.5, 2.0), near,
                                chance(random, 0.3) ? core::kInfiniteFar : near * 1e9);
  return view ? *view : random_view(random, origin, half);
}

/// A point of one face of the view volume, in world coordinates; anything when the matrix has no good inverse.
dvec3 point_on_face(Random& random, const View& view, const dvec3& origin, double half) {
  core::dvec4 clip(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, 0, 1), 1.0);
  const int axis = whole(random, 0, 2);
  clip[axis] = axis == 2 ? double(whole(random, 0, 1)) : chance(random, 0.5) ? 1.0 : -1.0;
  const core::dvec4 world = glm::inverse(view.clip_from_world()) * clip;
  const dvec3 p = dvec3(world) / world.w;
  const bool usable = core::is_finite(p) && glm::length(p - origin) < 1e12 * half;
  return usable ? p : origin + point(random, half);
}

float step(float x, int ulps) {
  for (; ulps > 0; --ulps) x = std::nextafterf(x, core::Aabb::kFar);
  for (; ulps < 0; ++ulps) x = std::nextafterf(x, -core::Aabb::kFar);
  return x;
}

/// A box whose p-vertex lies on `plane` near `target`, as closely as floats allow, then off it by a few steps.
Aabb box_at_plane(Random& random, const ExactPlane& plane, const dvec3& origin, const dvec3& target, double half) {
  std::array<float, 3> p;
  std::size_t steepest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = core::round_down(target[int(i)] - origin[int(i)]);
    if (std::abs(plane.rounded(i)) > std::abs(plane.rounded(steepest))) steepest = i;
  }
  long double rest = static_cast<long double>(plane.a[3]) + plane.b[3];
  for (std::size_t i = 0; i < 3; ++i) {
    const long double n = static_cast<long double>(plane.a[i]) + plane.b[i];
    rest += n * (static_cast<long double>(origin[int(i)]) + (i == steepest ? 0.0f : p[i]));
  }
  const double solved = double(-rest / (static_cast<long double>(plane.a[steepest]) + plane.b[steepest]));
  if (std::isfinite(solved)) p[steepest] = core::round_down(solved);
  if (chance(random, 0.7)) p[steepest] = step(p[steepest], whole(random, -2, 2));
  if (chance(random, 0.2)) p[std::size_t(whole(random, 0, 2))] = 0.0f;

  Aabb box;
  const int form = whole(random, 0, 2);
  for (std::size_t i = 0; i < 3; ++i) {
    const double size = form == 0 ? 0.0 : half * magnitude(random, 1e-9, form == 1 ? 1e-6 : 0.3);
    const bool positive = plane.rounded(i) >= 0.0;
    box.max[int(i)] = positive ? p[i] : core::round_up(double(p[i]) + size);
    box.min[int(i)] = positive ? core::round_down(double(p[i]) - size) : p[i];
  }
  return box;
}

TEST(Conservative, AdversarialBoxes) {
  Tally tally;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(1000 + seed);
    const double half = magnitude(random, 1e-2, 1e4);
    dvec3 origin = random_origin(random);
    View view = chance(random, 0.4) ? degenerate_view(random, origin, half) : random_view(random, origin, half);
    if (chance(random, 0.2)) add_sections(random, origin, half, view);
    // With the origin on a face, coordinates near zero resolve the plane far below any rounding error of the test.
    const bool fine = chance(random, 0.5);
    if (fine) origin = point_on_face(random, view, origin, half);
    const ExactVolume exact(view);
    std::vector<Aabb> boxes;
    while (boxes.size() < 1000) {
      const auto& planes = exact.planes();
      const ExactPlane& plane = planes[std::size_t(whole(random, 0, int(planes.size()) - 1))];
      const dvec3 target = fine ? origin + point(random, half * magnitude(random, 1e-20, 1.0))
                                : point_on_face(random, view, origin, half);
      boxes.push_back(box_at_plane(random, plane, origin, target, half));
    }
    ASSERT_NO_FATAL_FAILURE(compare(boxes, origin, view, 0, tally));
  }
  tally.print("adversarial");
  EXPECT_EQ(tally.lost, 0u);
  EXPECT_GT(tally.rationals, 1000u) << "the boxes are meant to be close calls";
  EXPECT_GT(tally.kept, tally.pairs / 20);
}

/// Boxes that touch axis-parallel planes without any rounding, and boxes one step away.
TEST(Conservative, TouchingBoxesAreKept) {
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
}  // namespace sightline::tests
