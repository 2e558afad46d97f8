// What a pixel should show: the double-precision intersection of the ray through its centre with everything, the slow,
// obvious way.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "sightline/core/mesh.h"
#include "sightline/core/view.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::tests {

using core::dvec3;
using core::dvec4;

inline bool sections_keep(const core::View& view, const dvec3& p) {
  if (view.sections.empty()) return true;
  const bool unite = view.section_mode == core::SectionMode::kUnion;
  for (const core::Plane& plane : view.sections)
    if ((core::evaluate(plane, p) >= 0.0) == unite) return unite;
  return !unite;
}

/// Where the ray's own t enters what the sections keep, and the plane it enters through: candidates for cut faces.
struct SectionEntry {
  double t;
  dvec3 normal;  ///< of the plane, in the world
};
inline std::vector<SectionEntry> section_entries(const core::View& view, const dvec3& origin, const dvec3& direction) {
  std::vector<SectionEntry> entries;
  for (const core::Plane& plane : view.sections) {
    const double t = -core::evaluate(plane, origin) / glm::dot(plane.normal, direction);
    const double step = 1e-9 * std::abs(t) + 1e-14 * glm::length(origin);
    if (std::isfinite(t) && !sections_keep(view, origin + (t - step) * direction) &&
        sections_keep(view, origin + (t + step) * direction))
      entries.push_back({t, plane.normal});
  }
  return entries;
}

/// origin + t * direction in the world, t in eye depth; what is nearer than t_near or farther than t_far is not shown.
struct PixelRay {
  dvec3 origin, direction;
  double t_near, t_far;
};

/// Through pixel x, y from the top left, 0, 0 being the first pixel's centre.
inline PixelRay pixel_ray(const core::View& view, int width, int height, double x, double y) {
  const core::dmat4 eye_from_clip = glm::inverse(view.clip_from_eye());
  const core::dmat4 world_from_eye = glm::inverse(view.eye_from_world());
  const dvec4 far = eye_from_clip * dvec4(0.0, 0.0, core::far_depth(view.clip_depth()), 1.0);
  const double t_far = far.w > 1e-12 ? -far.z / far.w : std::numeric_limits<double>::infinity();
  const dvec4 p = eye_from_clip * dvec4(2.0 * (x + 0.5) / width - 1.0, 1.0 - 2.0 * (y + 0.5) / height,
                                        core::near_depth(view.clip_depth()), 1.0);
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

/// What a ray meets first of what a view shows.
struct RayHit {
  double depth = std::numeric_limits<double>::infinity();  ///< in eye space; infinity: nothing
  dvec3 normal{0.0};                                       ///< unit, in eye space, towards the eye
  bool cut = false;                                        ///< on the face where a section cuts a solid
  std::vector<core::ItemId> items;  ///< that show just there: several where solids overlap on a cut face

  bool hit() const { return std::isfinite(depth); }
};

/// An item and its shape, a primitive or a mesh.
struct Shape {
  core::ItemId item{0};
  core::Affine world_from_item = {};
  core::Primitive primitive = core::Sphere{};
  const core::Mesh* mesh = nullptr;
  bool closed = true;  ///< sections show a face where they cut it
};

/// Crossings with a mesh in the mesh's own coordinates, normals as the vertices' are interpolated, or the triangles'.
inline std::vector<gpuprims::Hit> intersect(const core::Mesh& mesh, const dvec3& origin, const dvec3& direction) {
  std::vector<gpuprims::Hit> hits;
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const std::uint32_t* at = &mesh.indices[i];
    const dvec3 a(mesh.positions[at[0]]), u = dvec3(mesh.positions[at[1]]) - a, v = dvec3(mesh.positions[at[2]]) - a;
    const dvec3 across = glm::cross(u, v), from_a = origin - a, moment = glm::cross(from_a, direction);
    const double volume = -glm::dot(direction, across);
    const double p = glm::dot(v, moment) / volume, q = -glm::dot(u, moment) / volume;
    if (!(p >= 0.0 && q >= 0.0 && p + q <= 1.0)) continue;
    dvec3 normal = across;
    if (!mesh.normals.empty())
      normal =
          (1.0 - p - q) * dvec3(mesh.normals[at[0]]) + p * dvec3(mesh.normals[at[1]]) + q * dvec3(mesh.normals[at[2]]);
    hits.push_back({glm::dot(from_a, across) / volume, normal, core::Face::kSide});
  }
  std::sort(hits.begin(), hits.end(), [](const gpuprims::Hit& a, const gpuprims::Hit& b) { return a.t < b.t; });
  return hits;
}

/// The ray's crossings with an item, in rising t, normals in the world.
inline std::vector<gpuprims::Hit> crossings(const Shape& shape, const PixelRay& ray) {
  const core::dmat3 item_from_world = glm::inverse(shape.world_from_item.linear);
  const dvec3 origin = item_from_world * (ray.origin - shape.world_from_item.origin);
  const dvec3 direction = item_from_world * ray.direction;
  std::vector<gpuprims::Hit> hits;
  if (shape.mesh) {
    hits = intersect(*shape.mesh, origin, direction);
  } else {
    const gpuprims::Hits found = gpuprims::intersect(shape.primitive, {origin, direction});
    hits.assign(found.hit.begin(), found.hit.begin() + found.count);
  }
  for (gpuprims::Hit& hit : hits) hit.normal = glm::transpose(item_from_world) * hit.normal;
  return hits;
}

/// What the ray meets first of all shapes: their surfaces, which are seen from both sides, and the faces where sections
/// cut closed ones.
inline RayHit first_hit(std::span<const Shape> shapes, const core::View& view, const PixelRay& ray) {
  RayHit first;
  const auto offer = [&](const Shape& shape, double t, const dvec3& normal, bool cut) {
    if (!(t >= ray.t_near && t <= ray.t_far)) return;
    const double alike = 1e-9 * (1.0 + std::abs(t));
    if (t > first.depth + alike) return;
    if (t < first.depth - alike) {
      const dvec3 n = glm::normalize(core::dmat3(view.eye_from_world()) * normal);
      first = {t, glm::dot(normal, ray.direction) > 0.0 ? -n : n, cut, {}};
    }
    first.items.push_back(shape.item);
  };
  const std::vector<SectionEntry> entries = section_entries(view, ray.origin, ray.direction);
  for (const Shape& shape : shapes) {
    const std::vector<gpuprims::Hit> hits = crossings(shape, ray);
    for (const gpuprims::Hit& hit : hits)
      if (sections_keep(view, ray.origin + hit.t * ray.direction)) offer(shape, hit.t, hit.normal, false);
    if (!shape.closed) continue;
    for (const SectionEntry& entry : entries) {
      const auto before =
          std::count_if(hits.begin(), hits.end(), [&](const gpuprims::Hit& hit) { return hit.t < entry.t; });
      if (before % 2 == 1) offer(shape, entry.t, entry.normal, true);
    }
  }
  return first;
}

/// Eye depth of the first crossing that the view keeps, or of the face where a section cuts the solid, infinity for
/// none.
inline double first_shown(const core::Primitive& primitive, const core::Affine& world_from_item, const core::View& view,
                          const PixelRay& ray) {
  const Shape shape{core::ItemId{0}, world_from_item, primitive, nullptr, true};
  return first_hit({&shape, 1}, view, ray).depth;
}

// --- rays through a pixel and close by: image_check.h says what they are for

inline constexpr double kReach = 1.0 / 32.0;  ///< pixels
inline constexpr double kSmooth = 2.0;        ///< degrees

/// What the rays through a pixel and close by see.
struct PixelHits {
  std::array<RayHit, 5> hits_around;  ///< the first through the centre
  int hits = 0;

  const RayHit& centre() const { return hits_around[0]; }
  bool clear() const { return hits == 0 || smooth; }
  bool smooth = false;  ///< all hit, and their normals agree
};

inline double degrees_between(const dvec3& a, const dvec3& b) {
  return glm::degrees(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
}

/// x, y as in pixel_ray(). `reach`: how far aside the four rays are.
inline PixelHits look_around(std::span<const Shape> shapes, const core::View& view, int width, int height, double x,
                             double y, double reach = kReach) {
  constexpr int kAside[5][2] = {{0, 0}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
  PixelHits around;
  around.smooth = true;
  for (int i = 0; i < 5; ++i) {
    const RayHit& seen_hit = around.hits_around[std::size_t(i)] =
        first_hit(shapes, view, pixel_ray(view, width, height, x + reach * kAside[i][0], y + reach * kAside[i][1]));
    around.hits += seen_hit.hit();
    around.smooth = around.smooth && seen_hit.hit() && seen_hit.items == around.centre().items &&
                    seen_hit.cut == around.centre().cut &&
                    degrees_between(seen_hit.normal, around.centre().normal) <= kSmooth;
  }
  return around;
}

inline std::vector<PixelHits> look_at(std::span<const Shape> shapes, const core::View& view, int width, int height,
                                      double reach = kReach) {
  std::vector<PixelHits> seen;
  seen.reserve(std::size_t(width) * std::size_t(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) seen.push_back(look_around(shapes, view, width, height, x, y, reach));
  return seen;
}

}  // namespace sightline::tests
