// Rays, triangles, and the one intersection routine that all traversals share.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "sightline/core/aabb.h"

namespace sightline::study::rays {

/// Points origin + t * direction, 0 <= t <= t_max. Where a coordinate is not finite, or the direction is zero or close
/// to it, the ray hits nothing.
struct Ray {
  static constexpr double kLeastDirection = 1e-300;  ///< of the largest component
  core::dvec3 origin{0.0}, direction{0.0, 0.0, 1.0};
  double t_max = std::numeric_limits<double>::infinity();
};

struct Hit {
  double t = std::numeric_limits<double>::infinity();
  std::uint32_t triangle = core::kNone;
  explicit operator bool() const { return triangle != core::kNone; }
  bool operator==(const Hit&) const = default;
};

/// Space as the structures have it: a cube around the scene becomes the unit cube, so that floats serve for any scene
/// and rounding errors are absolute.
struct UnitSpace {
  /// Each triangle's box is larger than the triangle by this on every side, in units of the cube. A hit point lies in
  /// the box that is larger by half of it. The other half (2^-19) covers the rounding of any traversal, some ten times
  /// 2^-24: a traversal that takes a point for one in a neighbouring cell finds the triangle there, too.
  static constexpr float kSlack = 0x1p-18f;

  core::dvec3 corner{0.0};
  double size = 1.0;  ///< of the cube, in units of the scene
  core::Aabb bounds;  ///< of all boxes with their slack, in units of the cube; empty for no triangles

  core::dvec3 from_scene(const core::dvec3& p) const { return (p - corner) / size; }
};

/// A ray from where it enters the bounds, for traversals: parameters start there at 0.
struct UnitRay {
  /// No less than this in absolute value, so that nothing divides by zero. Over a path through the cube it shifts a
  /// point by 2^-59 only.
  static constexpr double kLeastDirection = 0x1p-60;

  core::vec3 origin{0.0f};
  core::vec3 direction{0.0f};  ///< the largest component is 1 or -1
  core::vec3 inverse{0.0f};    ///< 1 / direction
  float exit = -1.0f;          ///< parameter where the ray ends or leaves the bounds; negative: it misses them
  double entry = 0.0, scale = 1.0;

  UnitRay(const UnitSpace& space, const Ray& ray);

  bool misses() const { return exit < 0.0f; }
  /// A parameter of the ray as a parameter of this.
  float from_ray(double t) const { return float(t * scale - entry); }
  bool negative(int axis) const { return direction[axis] < 0.0f; }
  /// Where it meets the plane at `position` across the axis.
  float at(int axis, float position) const { return (position - origin[axis]) * inverse[axis]; }
  float point(int axis, float t) const { return origin[axis] + t * direction[axis]; }
};

/// A ray made ready for the triangle test of S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection"
/// (2013).
struct ShearedRay {
  core::dvec3 origin, direction;
  core::dvec3 shear;
  int x, y, z;

  explicit ShearedRay(const Ray& ray);
};

/// Triangles with what depends on them alone. Immutable.
class TriangleSet {
 public:
  using Corners = std::array<core::vec3, 3>;

  /// `indices`: three per triangle, below positions.size(). Positions must be finite. Triangles may be degenerate;
  /// those without area are never hit.
  TriangleSet(std::span<const core::vec3> positions, std::span<const std::uint32_t> indices);

  std::uint32_t size() const { return std::uint32_t(corners_.size()); }
  const Corners& corners(std::uint32_t triangle) const { return corners_[triangle]; }
  const UnitSpace& space() const { return space_; }
  /// One per triangle, in unit space, with slack.
  std::vector<core::Aabb> boxes() const;

  /// Parameter of the hit, infinity for none. Both sides of a triangle count, and so do its edges: no ray passes
  /// between two triangles that share an edge. Computed in double. Hits closer than 0 or farther than `t_max` are none.
  double intersect(const ShearedRay& ray, std::uint32_t triangle, double t_max) const;

  /// The obvious search, for tests: every triangle. Of equal parameters the lowest triangle.
  Hit brute_force(const Ray& ray) const;

 private:
  std::vector<Corners> corners_;
  UnitSpace space_;
};

// --- shared by the builders of structures ----------------------------------------------------------------------------

/// A triangle's box, or the part of it in a node.
struct Reference {
  core::Aabb box;
  std::uint32_t triangle;
};

inline float half_area(const core::Aabb& box) {
  const core::vec3 d = box.max - box.min;
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

inline int longest_axis(const core::Aabb& box) {
  const core::vec3 d = box.max - box.min;
  return d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
}

}  // namespace sightline::study::rays
