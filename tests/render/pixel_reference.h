// What a pixel should show of a solid: the double-precision intersection of the ray through its centre, the slow,
// obvious way.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sightline/core/view.h"
#include "sightline/gpuprims/primitives.h"

namespace sightline::tests {

inline bool sections_keep(const core::View& view, const core::dvec3& p) {
  if (view.sections.empty()) return true;
  const bool unite = view.section_mode == core::SectionMode::kUnion;
  for (const core::Plane& plane : view.sections)
    if ((core::evaluate(plane, p) >= 0.0) == unite) return unite;
  return !unite;
}

/// Where the ray's own t enters what the sections keep: candidates for cut faces.
inline std::vector<double> section_entries(const core::View& view, const core::dvec3& origin,
                                           const core::dvec3& direction) {
  std::vector<double> entries;
  for (const core::Plane& plane : view.sections) {
    const double t = -core::evaluate(plane, origin) / glm::dot(plane.normal, direction);
    const double step = 1e-9 * std::abs(t) + 1e-15 * glm::length(origin);
    if (std::isfinite(t) && !sections_keep(view, origin + (t - step) * direction) &&
        sections_keep(view, origin + (t + step) * direction))
      entries.push_back(t);
  }
  return entries;
}

/// origin + t * direction in the world, t in eye depth; what is nearer than t_near or farther than t_far is not shown.
struct PixelRay {
  core::dvec3 origin, direction;
  double t_near, t_far;
};

inline PixelRay pixel_ray(const core::View& view, int width, int height, int x, int y) {
  using core::dvec3, core::dvec4;
  const core::dmat4 eye_from_clip = glm::inverse(view.clip_from_eye());
  const core::dmat4 world_from_eye = glm::inverse(view.eye_from_world());
  const bool reversed = view.clip_depth() != core::ClipDepth::kMinusOneToOne;
  const dvec4 far = eye_from_clip * dvec4(0.0, 0.0, reversed ? 0.0 : 1.0, 1.0);
  const double t_far = far.w > 1e-12 ? -far.z / far.w : std::numeric_limits<double>::infinity();
  const dvec4 p =
      eye_from_clip * dvec4(2.0 * (x + 0.5) / width - 1.0, 1.0 - 2.0 * (y + 0.5) / height, reversed ? 1.0 : -1.0, 1.0);
  dvec3 near = dvec3(p) / p.w, direction(0.0, 0.0, -1.0);
  const double t_near = -near.z;
  if (view.orthographic()) {
    near.z = 0.0;
  } else {
    direction = near / -near.z;
    near = dvec3(0.0);
  }
  return {dvec3(world_from_eye * dvec4(near, 1.0)), core::dmat3(world_from_eye) * direction, t_near, t_far};
}

/// Eye depth of the first crossing that the view keeps, or of the face where a section cuts the solid, infinity for
/// none.
inline double first_shown(const core::Primitive& primitive, const core::Affine& world_from_item, const core::View& view,
                          const PixelRay& ray) {
  const core::dmat3 item_from_world = glm::inverse(world_from_item.linear);
  const gpuprims::Hits hits = gpuprims::intersect(
      primitive, {item_from_world * (ray.origin - world_from_item.origin), item_from_world * ray.direction});
  double first = std::numeric_limits<double>::infinity();
  for (int i = 0; i < hits.count; ++i) {
    const double t = hits.hit[i].t;
    if (t >= ray.t_near && t <= ray.t_far && sections_keep(view, ray.origin + t * ray.direction))
      first = std::min(first, t);
  }
  if (hits.count == 0) return first;
  for (const double t : section_entries(view, ray.origin, ray.direction)) {
    int before = 0;
    while (before < hits.count && hits.hit[before].t < t) ++before;
    if (t >= ray.t_near && t <= ray.t_far && before % 2 == 1) first = std::min(first, t);
  }
  return first;
}

}  // namespace sightline::tests
