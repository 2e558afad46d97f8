// Families of box/view pairs for the exactness test: typical ones, and those at the limits of the number formats, of
// projections and of the planes' last bits. Everything follows from the generator's state.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "exact_reference.h"
#include "scenes.h"

namespace sightline::tests {

inline constexpr std::size_t kBlockBoxes = 1024, kBlockViews = 8;

/// Every box is to be paired with every view.
struct PairBlock {
  core::dvec3 origin{0.0};
  std::vector<core::View> views;
  std::vector<core::Aabb> boxes;
};

// --- views -----------------------------------------------------------------------------------------------------------

inline core::ClipDepth any_depth(Random& random) {
  return core::ClipDepth(whole(random, 0, 2));
}

/// The volume of a view of reversed depth, for any depth.
inline core::View with_any_depth(Random& random, const core::View& view) {
  const core::ClipDepth depth = any_depth(random);
  if (depth == view.clip_depth()) return view;
  const double near = core::near_depth(depth), far = core::far_depth(depth);
  core::dmat4 clip = view.clip_from_eye();
  for (int column = 0; column < 4; ++column) clip[column][2] = far * clip[column][3] + (near - far) * clip[column][2];
  const auto other = core::View::from_matrices(view.eye_from_world(), clip, depth);
  return other ? *other : view;
}

/// Another near plane, through `point`, that is not parallel to the screen (E. Lengyel, "Oblique view frustum depth
/// projection and clipping", 2005). The far plane tilts with it.
inline core::View with_oblique_near_plane(Random& random, const core::View& view, const core::dvec3& point) {
  core::dmat4 clip = view.clip_from_world();
  const core::dvec3 normal = tests::point(random, magnitude(random, 1e-3, 1e3));
  const core::dvec4 plane(normal, -glm::dot(normal, point));
  const double near = core::near_depth(view.clip_depth()), sign = core::far_depth(view.clip_depth()) > near ? 1 : -1;
  for (int column = 0; column < 4; ++column) clip[column][2] = near * clip[column][3] + sign * plane[column];
  const auto other = core::View::from_matrices(core::dmat4(1.0), clip, view.clip_depth());
  return other ? *other : view;
}

/// Perspective (to infinity or not), asymmetric, orthographic or oblique, of any depth convention.
inline core::View any_view(Random& random, const core::dvec3& origin, double half) {
  core::View view = random_view(random, origin, half);
  view = with_any_depth(random, view);
  if (chance(random, 0.15)) view = with_oblique_near_plane(random, view, origin + point(random, half));
  return view;
}

/// Projections at their limits: very narrow, nearly flat, near planes of nanometres, depth ranges of 1 : 10^8.
inline core::View degenerate_view(Random& random, const core::dvec3& origin, double half) {
  core::Pose pose;
  pose.eye = origin + point(random, half);
  pose.target = origin + point(random, half);
  const double degree = std::numbers::pi / 180.0;
  const double fovy = chance(random, 0.5) ? 0.01 * degree : 179.9 * degree;
  const double near = half * (chance(random, 0.5) ? 1e-9 : 1e-3);
  const double far = chance(random, 0.3) ? core::kInfiniteFar : near * 1e8;
  const auto view = core::View::perspective(pose, fovy, magnitude(random, 0.5, 2.0), near, far);
  if (!view) return random_view(random, origin, half);
  return with_any_depth(random, *view);
}

inline double step(double x, int ulps) {
  for (; ulps > 0; --ulps) x = std::nextafter(x, std::numeric_limits<double>::max());
  for (; ulps < 0; ++ulps) x = std::nextafter(x, std::numeric_limits<double>::lowest());
  return x;
}
inline float step(float x, int ulps) {
  for (; ulps > 0; --ulps) x = std::nextafterf(x, core::Aabb::kFar);
  for (; ulps < 0; ++ulps) x = std::nextafterf(x, -core::Aabb::kFar);
  return x;
}

/// A view whose planes differ in the last bits: what is a close call for one view is one for the other.
inline core::View nudged(Random& random, const core::View& view) {
  core::dmat4 clip = view.clip_from_world();
  for (int i = 0; i < 16; ++i)
    if (chance(random, 0.3)) clip[i / 4][i % 4] = step(clip[i / 4][i % 4], whole(random, -1, 1));
  auto other = core::View::from_matrices(core::dmat4(1.0), clip, view.clip_depth());
  if (!other) return view;
  other->section_mode = view.section_mode;
  other->sections = view.sections;
  for (core::Plane& section : other->sections) section.offset = step(section.offset, whole(random, -1, 1));
  return *other;
}

// --- boxes -----------------------------------------------------------------------------------------------------------

/// A point of one face of the view volume, in world coordinates; anything when the matrix has no good inverse.
inline core::dvec3 point_on_face(Random& random, const core::dmat4& world_from_clip, const core::dvec3& origin,
                                 double half) {
  core::dvec4 clip(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, 0, 1), 1.0);
  const int axis = whole(random, 0, 2);
  clip[axis] = axis == 2 ? double(whole(random, 0, 1)) : chance(random, 0.5) ? 1.0 : -1.0;
  const core::dvec4 world = world_from_clip * clip;
  const core::dvec3 p = core::dvec3(world) / world.w;
  const bool usable = core::is_finite(p) && glm::length(p - origin) < 1e12 * half;
  return usable ? p : origin + point(random, half);
}

/// A box whose p-vertex lies on `plane` near `target`, as closely as floats allow, then off it by a few steps. It is up
/// to `largest` metres long.
inline core::Aabb box_at_plane(Random& random, const ExactPlane& plane, const core::dvec3& origin,
                               const core::dvec3& target, double largest) {
  std::array<float, 3> p;
  std::size_t steepest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = core::round_down(target[int(i)] - origin[int(i)]);
    if (std::abs(plane.rounded[i]) > std::abs(plane.rounded[steepest])) steepest = i;
  }
  long double rest = plane.rounded[3];
  for (std::size_t i = 0; i < 3; ++i)
    rest += plane.rounded[i] * (static_cast<long double>(origin[int(i)]) + (i == steepest ? 0.0f : p[i]));
  const double solved = double(-rest / plane.rounded[steepest]);
  if (std::isfinite(solved)) p[steepest] = core::round_down(solved);
  if (chance(random, 0.7)) p[steepest] = step(p[steepest], whole(random, -2, 2));
  if (chance(random, 0.2)) p[std::size_t(whole(random, 0, 2))] = 0.0f;

  core::Aabb box;
  const int form = whole(random, 0, 2);
  for (std::size_t i = 0; i < 3; ++i) {
    const double size = form == 0 ? 0.0 : largest * magnitude(random, 1e-9, form == 1 ? 1e-6 : 1.0);
    const bool positive = plane.rounded[i] >= 0.0L;
    box.max[int(i)] = positive ? p[i] : core::round_up(double(p[i]) + size);
    box.min[int(i)] = positive ? core::round_down(double(p[i]) - size) : p[i];
  }
  return box;
}

/// Boxes at the planes of `view`, and views that differ from it in last bits.
inline PairBlock touching_block(Random& random, core::dvec3 origin, double half, const core::View& view) {
  PairBlock block;
  const core::dmat4 world_from_clip = glm::inverse(view.clip_from_world());
  // With the origin on a face, coordinates near zero resolve the plane far below any rounding error of the test.
  const bool fine = chance(random, 0.5);
  if (fine) origin = point_on_face(random, world_from_clip, origin, half);
  block.origin = origin;
  // One box that is huge or far away widens the float test's band for all: half of the blocks have none.
  const bool compact = chance(random, 0.5);
  const double largest = !compact && chance(random, 0.2) ? 1e30 : 0.3 * half;
  const ExactVolume exact(view);
  while (block.boxes.size() < kBlockBoxes) {
    const ExactPlane& plane = exact.planes()[std::size_t(whole(random, 0, int(exact.planes().size()) - 1))];
    const core::dvec3 target = fine ? origin + point(random, half * magnitude(random, 1e-20, 1.0))
                                    : point_on_face(random, world_from_clip, origin, half);
    const core::Aabb box = box_at_plane(random, plane, origin, target, largest);
    const core::vec3 reach = glm::max(glm::abs(box.min), glm::abs(box.max));
    const bool near = std::max({reach.x, reach.y, reach.z}) < 4.0 * half;
    block.boxes.push_back(near || !compact ? box : random_box(random, half));
  }
  block.views.push_back(view);
  while (block.views.size() < kBlockViews) block.views.push_back(nudged(random, view));
  return block;
}

// --- families --------------------------------------------------------------------------------------------------------

inline core::dvec3 random_origin(Random& random) {
  return chance(random, 0.3) ? core::dvec3(0.0) : point(random, chance(random, 0.5) ? 1e3 : 1e7);
}

inline PairBlock random_pairs(Random& random) {
  PairBlock block;
  const double half = magnitude(random, 1e-2, 1e4);
  block.origin = random_origin(random);
  block.boxes = random_boxes(random, kBlockBoxes, half);
  while (block.views.size() < kBlockViews) {
    block.views.push_back(any_view(random, block.origin, half));
    if (chance(random, 0.2)) add_sections(random, block.origin, half, block.views.back());
  }
  return block;
}

inline PairBlock touching_pairs(Random& random) {
  const double half = magnitude(random, 1e-2, 1e4);
  const core::dvec3 origin = random_origin(random);
  return touching_block(random, origin, half, any_view(random, origin, half));
}

inline PairBlock degenerate_pairs(Random& random) {
  const double half = magnitude(random, 1e-2, 1e4);
  const core::dvec3 origin = random_origin(random);
  return touching_block(random, origin, half, degenerate_view(random, origin, half));
}

/// Ten thousand kilometres away, seen from nearby.
inline PairBlock distant_pairs(Random& random) {
  const double half = magnitude(random, 1e-2, 1e2);
  core::dvec3 origin = point(random, 1e7);
  origin[whole(random, 0, 2)] = chance(random, 0.5) ? 1e7 : -1e7;
  return touching_block(random, origin, half, any_view(random, origin, half));
}

/// One to eight section planes, all of them or any.
inline PairBlock section_pairs(Random& random) {
  const double half = magnitude(random, 1e-2, 1e4);
  const core::dvec3 origin = random_origin(random);
  core::View view = any_view(random, origin, half);
  add_sections(random, origin, half, view);
  return touching_block(random, origin, half, view);
}

/// Boxes without size, of denormals, of 10^30 m, of all there is; inverted and empty ones.
inline PairBlock odd_box_pairs(Random& random) {
  PairBlock block = chance(random, 0.5) ? random_pairs(random) : touching_pairs(random);
  for (core::Aabb& box : block.boxes) {
    const core::vec3 centre = 0.5f * (box.min + box.max);
    const float huge = chance(random, 0.2) ? core::Aabb::kFar : 1e30f;
    switch (whole(random, 0, 9)) {
      case 0:
        box = {centre, centre};
        break;
      case 1:
        box = {core::vec3(-huge), core::vec3(huge)};
        break;
      case 2:
        box.max[whole(random, 0, 2)] = huge;
        break;
      case 3:
        box.min = box.max = core::vec3(point(random, 1e30));
        break;
      case 4:
        box = {core::vec3(1e-42f), core::vec3(3e-42f)};
        break;
      default:
        break;
    }
  }
  spoil(random, block.boxes);
  return block;
}

/// Sixteen finite numbers that are no camera: overflow and underflow in every sum, rows of zeros; section planes of
/// any size, infinite or NaN.
inline core::View matrix_view(Random& random, const core::dvec3& origin, double half) {
  const double low = chance(random, 0.3) ? 1e-320 : chance(random, 0.5) ? 1e-3 : 1e300;
  const double high = chance(random, 0.5) ? 1.79e308 : low * 1e6;
  const auto number = [&] {
    const double x = chance(random, 0.15) ? 0.0 : std::min(magnitude(random, low, high), 1.79e308);
    return chance(random, 0.5) ? x : -x;
  };
  core::dmat4 clip;
  for (int i = 0; i < 16; ++i) clip[i / 4][i % 4] = number();
  if (chance(random, 0.1)) clip = glm::transpose(clip), clip[whole(random, 0, 3)] = {0, 0, 0, number()};
  if (chance(random, 0.5)) clip[3] = {0, 0, 0, std::abs(number())};
  const core::ClipDepth depth = any_depth(random);
  const auto made = core::View::from_matrices(core::dmat4(1.0), clip, depth);
  if (!made) return random_view(random, origin, half);  // a camera of another depth
  core::View view = *made;
  if (chance(random, 0.3)) add_sections(random, origin, half, view);
  for (core::Plane& section : view.sections) {
    if (chance(random, 0.3)) section = {{number(), number(), number()}, number()};
    const double bad =
        chance(random, 0.5) ? std::numeric_limits<double>::quiet_NaN() : std::numeric_limits<double>::infinity();
    if (chance(random, 0.1)) section.normal[whole(random, 0, 2)] = bad;
    if (chance(random, 0.1)) section.offset = -bad;
  }
  return view;
}

inline PairBlock matrix_pairs(Random& random) {
  const double half = magnitude(random, 1e-2, 1e4);
  const core::dvec3 origin = random_origin(random);
  if (chance(random, 0.5)) return touching_block(random, origin, half, matrix_view(random, origin, half));
  PairBlock block = odd_box_pairs(random);
  for (core::View& view : block.views) view = matrix_view(random, block.origin, half);
  return block;
}

struct PairFamily {
  const char* name;
  double share;  // of all pairs
  PairBlock (*make)(Random&);
};

inline constexpr std::array<PairFamily, 7> kPairFamilies{{{"random", 0.5, random_pairs},
                                                          {"touching", 0.1, touching_pairs},
                                                          {"degenerate", 0.1, degenerate_pairs},
                                                          {"distant", 0.1, distant_pairs},
                                                          {"sections", 0.1, section_pairs},
                                                          {"odd_boxes", 0.05, odd_box_pairs},
                                                          {"matrices", 0.05, matrix_pairs}}};

}  // namespace sightline::tests
