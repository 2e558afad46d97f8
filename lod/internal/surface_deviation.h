// A proven bound of how far one triangulated surface lies from another. Internal to lod.
//
// The distance to a convex set is a convex function. So of all points of a convex polygon, one of its corners is the
// farthest from a given triangle, and any division of a surface into convex polygons, each with some triangle of the
// other surface, proves a bound: the largest distance of a corner from its polygon's triangle. The division decides
// only how tight the bound is. Here the planes that halve the angles between neighbouring triangles of the other
// surface divide it, so that each polygon lies above its triangle, and polygons that still lie far from it are
// bisected. (Compare R. Straub, "Approximate Error Bounds", 2007; M. Guthe, P. Borodin, R. Klein, "Fast and accurate
// Hausdorff distance calculation between meshes", 2005, which search for the distance itself.)
//
// Bounds of several steps add up, and do so triangle by triangle: a polygon's distance and the errors of its two
// triangles bound how far its points lie from a third surface. So what is far off in one step and what is in another
// are only added where they lie above each other.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "sightline/core/conventions.h"

namespace sightline::lod {

/// Every point of one surface has a point of the other within `distance` metres; where both have normals, they differ
/// by at most `angle` radians. Triangles so thin that rounding decides where they face have none.
struct Deviation {
  double distance = 0.0, angle = 0.0;

  void grow(const Deviation& other) {
    distance = std::max(distance, other.distance);
    angle = std::max(angle, other.angle);
  }
};

/// Triangles as corners, indices of points that they share: equal positions have equal indices.
struct Triangles {
  std::span<const core::dvec3> points;
  std::span<const std::uint32_t> corners;  ///< three each
  /// How far the points of each triangle are known to lie from a third surface, in metres; none: not at all.
  std::span<const float> errors = {};
};

/// Bounds distances to one surface. Keeps its memory from surface to surface.
class SurfaceDeviation {
 public:
  /// Bounds the deviation of each point of `from` from `to`, not of `to` from `from`. Both have the same points, all
  /// finite; triangles may be degenerate, repeated, or meet at edges in any number. The bound is rounded outwards, and
  /// seldom exceeds the largest distance by more than an eighth. `to` must have a triangle unless `from` has none.
  ///
  /// Where triangles have errors, `distance` and what follows are sums of a distance and the errors of both triangles.
  Deviation bound(const Triangles& from, const Triangles& to);

  /// The deviation of the points of each triangle of `from` alone.
  std::span<const double> of_from() const { return of_from_; }
  /// The deviation of those points alone that were shown to lie near this triangle of `to`.
  std::span<const double> of_to() const { return of_to_; }
  /// How often polygons were cut or handed on to the next triangle.
  std::int64_t steps() const { return steps_; }

 private:
  static constexpr std::uint32_t kNone = core::kNone;
  static constexpr int kMostCorners = 10, kManyCorners = 7;
  static constexpr double kAny = std::numeric_limits<double>::infinity();
  static constexpr double kBeside = 1e-13;  // of barycentric coordinates: less than that is rounding

  struct Face {
    core::dvec3 corners[3];
    core::dvec3 normal;           // of unit length, or 0
    double normal_rounding;       // largest distance from the exact one
    core::dvec3 gradients[2];     // of the barycentric coordinates of corners 1 and 2; not numbers for slivers
    core::dvec3 cuts[3];          // unit normal of the plane through edge k that parts this face from its neighbour
    double heights[3];            // squares of them, of corners 1, 2 and 0
    double error;                 // of Triangles
    std::uint32_t neighbours[3];  // across edge k, from corner k to the next; kNone: none

    /// Whether the point's projection lies inside, but for rounding. Not for slivers.
    bool is_above(const core::dvec3& point) const {
      const core::dvec3 p = point - corners[0];
      const double u = glm::dot(gradients[0], p), v = glm::dot(gradients[1], p);
      return std::min({u, v, 1.0 - u - v}) >= -kBeside;
    }
    /// Where it is less than `most`; else anything that is not. Most points lie above the face, or too far beside it,
    /// which is quick to see.
    double square_distance(const core::dvec3& point, double most = kAny) const {
      const core::dvec3 p = point - corners[0];
      const double u = glm::dot(gradients[0], p), v = glm::dot(gradients[1], p), w = 1.0 - u - v;
      const double height = glm::dot(normal, p), above = height * height;
      if (std::min({u, v, w}) >= -kBeside) return above;
      const auto beside = [](double coordinate, double height_square) {
        return coordinate < 0.0 ? coordinate * coordinate * height_square : 0.0;
      };
      const double least = above + std::max({beside(u, heights[0]), beside(v, heights[1]), beside(w, heights[2])});
      return least > most ? least : square_distance_beside(point);
    }
    double square_distance_beside(const core::dvec3& point) const;
    /// With the face's error; `most` as before.
    double distance(const core::dvec3& point, double most = kAny) const {
      const double left = std::max(most - error, 0.0);
      return std::sqrt(square_distance(point, left * left)) + error;
    }
  };
  struct Polygon {
    core::dvec3 corners[kMostCorners];
    int count = 0;
  };
  /// A part of the triangle that is covered, near a face. `from`: the face that has handed it on, or kNone.
  struct Piece {
    Polygon polygon;
    std::uint32_t face, from;
  };
  enum class Side { kInside, kOutside, kBoth };
  /// Around faces, for quick tests of many.
  static constexpr std::size_t kBalls = 16;
  struct Balls {
    float x[kBalls], y[kBalls], z[kBalls], radius[kBalls];
  };
  struct Probe {
    std::uint32_t face;  // near it
    double error;        // of its own triangle
    double distance;     // with both errors
    core::dvec3 point;
  };
  struct HalfEdge {
    std::uint32_t to, corner;  // the higher end; where it starts
  };
  struct Near {
    std::uint32_t face;
    double distance;  // with the face's error
  };

  void make_faces(const Triangles& to);
  void make_balls();
  void join_faces(const Triangles& to);
  void join(std::span<const std::uint32_t> corners, std::uint32_t a, std::uint32_t b);
  double probe(const Triangles& from, const Triangles& to);
  Near near(std::uint32_t face, const core::dvec3& point) const { return {face, faces_[face].distance(point)}; }
  Near nearest_from(Near start, const core::dvec3& point) const;
  Near nearest(Near start, const core::dvec3& point) const;
  Near start(const std::uint32_t* corners, const core::dvec3& centre) const;
  double farthest(const Polygon& polygon, std::uint32_t face, double most) const;
  static core::dvec3 centre_of(const Polygon& polygon);
  bool accept(const Polygon& polygon, std::uint32_t face, double most);
  bool is_nearer(std::uint32_t face, const Piece& piece) const;
  void cover(Piece piece);
  void refine(const Piece& piece);
  bool bisect(const Polygon& polygon, std::uint32_t face);
  Side split(const Polygon& polygon, const core::dvec3& normal, const core::dvec3& point, Polygon& inside,
             Polygon& outside) const;

  std::vector<Face> faces_;
  std::vector<Balls> balls_;               // of the faces
  core::dvec3 origin_{0.0};                // of the balls' centres
  std::vector<std::uint32_t> first_edge_;  // by point: of those whose lower end it is
  std::vector<HalfEdge> edges_;
  std::vector<std::uint32_t> seeds_;   // by point: a face near it, or kNone
  std::vector<std::uint32_t> starts_;  // by triangle: a face near it
  std::vector<Probe> probes_;
  std::vector<double> of_from_, of_to_;
  std::uint32_t triangle_ = 0;  // that is covered
  core::dvec3 normal_{0.0};     // of it
  double normal_rounding_ = 0;  // largest distance from the exact one
  double error_ = 0.0;          // of it
  std::vector<Piece> pieces_;   // of it, yet to be covered
  double rounding_ = 0.0;       // distances below it are rounding
  double bound_ = 0.0;          // so far
  double least_ = 0.0;          // distance that some point has, with the errors
  double cosine_ = 1.0;         // of the largest angle so far
  std::int64_t steps_ = 0;      // so far
  std::int64_t most_steps_ = 0;
};

}  // namespace sightline::lod
