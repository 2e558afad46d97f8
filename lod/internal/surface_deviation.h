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
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "sightline/core/conventions.h"
#include "sightline/lod/internal/deviation_kernels.h"

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
  Deviation bound(const Triangles& from, const Triangles& to) { return bound(from, to, {}); }

  /// What helps to bound the other way round after that.
  struct Known {
    double enough = 0.0;                         // distances up to it need no tighter bound
    std::span<const std::uint32_t> starts = {};  // by triangle of `from`: one of `to` that is near it, or kNone
  };
  Deviation bound(const Triangles& from, const Triangles& to, const Known& known);
  /// By triangle of `to`: one of `from` near its centre, or kNone. Only where `starts` were not known.
  std::span<const std::uint32_t> near_to() const { return near_to_; }

  /// The deviation of the points of each triangle of `from` alone.
  std::span<const double> of_from() const { return of_from_; }
  /// The deviation of those points alone that were shown to lie near this triangle of `to`.
  std::span<const double> of_to() const { return of_to_; }
  /// How often polygons were cut or handed on to the next triangle. Long searches count as several.
  std::int64_t steps() const { return steps_; }

 private:
  static constexpr std::uint32_t kNone = core::kNone;
  static constexpr int kManyCorners = 7;
  static constexpr double kAny = std::numeric_limits<double>::infinity();

  struct Face : FaceShape {
    double normal_rounding;       // largest distance from the exact one
    core::dvec3 cuts[3];          // unit normal of the plane through edge k that parts this face from its neighbour
    double error;                 // of Triangles
    std::uint32_t neighbours[3];  // across edge k, from corner k to the next; kNone: none

    bool is_sliver() const { return !(gradients[0].x == gradients[0].x); }
    /// At most the square distance, and less only where a corner is nearest: a hint where to look. `beyond`: a bit for
    /// each edge that the point lies beyond, as for all edges of slivers.
    double least_square_distance(const core::dvec3& point, unsigned& beyond) const {
      const core::dvec3 p = point - corners[0];
      const double u = glm::dot(gradients[0], p), v = glm::dot(gradients[1], p), w = 1.0 - u - v;
      const double height = glm::dot(normal, p);
      beyond = unsigned(!(v >= -kBeside)) | unsigned(!(w >= -kBeside)) << 1 | unsigned(!(u >= -kBeside)) << 2;
      if (beyond == 0) return height * height;
      if (is_sliver()) return square_distance(point);
      const auto beside = [](double coordinate, double height_square) {
        const double outside = std::min(coordinate, 0.0);
        return outside * outside * height_square;
      };
      return height * height + std::max({beside(u, heights[0]), beside(v, heights[1]), beside(w, heights[2])});
    }
    double square_distance(const core::dvec3& point) const;
    /// With the face's error.
    double distance(const core::dvec3& point) const { return std::sqrt(square_distance(point)) + error; }
  };
  /// A part of the triangle that is covered, near a face. `from`: the face that has handed it on, or kNone.
  struct Piece {
    Polygon polygon;
    std::uint32_t face, from;
  };
  struct HalfEdge {
    std::uint32_t to, next;  // the higher end; another one with the same lower end
  };
  struct Near {
    std::uint32_t face;
    double distance;  // at most that, with the face's error
    unsigned beyond;  // its edges
  };

  struct Probe {
    Near near;
    double error;     // of its own triangle
    double distance;  // with both errors
    core::dvec3 point;
  };
  /// The farthest ones of many.
  class FarthestProbes {
   public:
    void offer(const Probe& probe) {
      if (count_ == kMost && probe.distance <= probes_[count_ - 1].distance) return;
      std::size_t place = count_ < kMost ? count_++ : kMost - 1;
      for (; place > 0 && probes_[place - 1].distance < probe.distance; --place) probes_[place] = probes_[place - 1];
      probes_[place] = probe;
    }
    std::span<const Probe> farthest_first() const { return {probes_.data(), count_}; }

   private:
    static constexpr std::size_t kMost = 8;
    std::array<Probe, kMost> probes_;
    std::size_t count_ = 0;
  };
  struct Distant {
    double distance;
    unsigned beyond;  // as Farthest has it
  };

  void make_faces(const Triangles& to);
  void make_balls();
  void join_faces(const Triangles& to);
  void join(std::span<const std::uint32_t> corners, std::uint32_t a, std::uint32_t b);
  double probe(const Triangles& from);
  void start_from(const Triangles& from, std::span<const std::uint32_t> starts);
  void seed(const Triangles& from, const Triangles& to);
  Near near(std::uint32_t face, const core::dvec3& point) const {
    Near near{face, 0.0, 0};
    near.distance = std::sqrt(faces_[face].least_square_distance(point, near.beyond)) + faces_[face].error;
    return near;
  }
  Near nearest_from(Near start, const core::dvec3& point) const;
  Near nearest(Near start, const core::dvec3& point);
  Near start(const std::uint32_t* corners, const core::dvec3& centre);
  Distant farthest(const Polygon& polygon, std::uint32_t face, double most) const;
  static core::dvec3 middle_of(const Polygon& polygon);
  void accept(std::uint32_t face, double distance);
  bool is_nearer(std::uint32_t face, const Piece& piece) const;
  void cover(Piece& piece);
  void refine(const Piece& piece);
  bool bisect(const Polygon& polygon, std::uint32_t face);

  const DeviationKernels& kernels_ = deviation_kernels();
  std::vector<Face> faces_;
  std::vector<Balls> balls_, around_;      // of the faces, and of those balls
  core::dvec3 origin_{0.0};                // of the balls' centres
  std::vector<std::uint32_t> first_edge_;  // by point: of those whose lower end it is, and that are left
  std::vector<HalfEdge> edges_;            // by the corner where they start
  std::vector<std::uint32_t> seeds_;       // by point: a face near it, or kNone
  std::vector<std::uint32_t> starts_;      // by triangle: a face near it
  std::vector<std::uint32_t> near_to_;
  std::vector<double> near_squares_;  // of their distances
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
