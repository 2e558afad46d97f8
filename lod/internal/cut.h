// Which triangles of a mesh a view draws: the coarsest whose projected error is small enough. Internal: for what draws.
//
// Let a point p of one surface be visible, and q = p + d the point of the other one that lies within the proven error e
// of it. Their places in the image, in pixels, differ by J(p) d / w(q), where J is half the image's size times the rows
// x - (x(p)/w(p)) w and y - (y(p)/w(p)) w of the matrix. Its norm is convex in x/w and y/w, which lie in -1 ... 1, so
// it is largest at a corner of the image: K. And w(q) is at least w(p) - |w| e. So K e / (w(p) - |w| e) bounds the
// difference, with the least w(p) in the box of both surfaces. The numbers are those of the mesh's own coordinates, so
// scale, shear and mirroring of an instance need no rule of their own.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/thread_pool.h"
#include "sightline/core/view.h"
#include "sightline/lod/mesh_levels.h"

namespace sightline::lod {

/// An image of a view, and the largest error that it may show.
class ImageError {
 public:
  /// `pixels`: largest distance in the image between points of the drawn and the original surface; 0: none.
  ImageError(const core::View& view, int width, int height, double pixels);

 private:
  friend class MeshError;
  core::dmat4 rows_;  // of the matrix, as linear forms of world coordinates
  std::array<core::Plane, core::kFrustumPlaneCount> planes_;
  std::vector<core::Plane> sections_;
  double half_width_, half_height_, pixels_;
  double nearest_;  // least w of visible points
};

/// A view's error in the coordinates of a mesh that it shows.
class MeshError {
 public:
  MeshError(const ImageError& image, const core::Affine& world_from_mesh);

  /// The largest error, in the mesh's own metres, of surfaces in a box that the image may show. Not less for a box than
  /// for one around it. Negative where a section plane meets the box: the original surface is drawn there.
  float allowed(const core::Aabb& box) const;
  double pixels() const { return pixels_; }  ///< ImageError's
  /// Whether a box surely shows nothing: it lies outside the view volume by more than a GPU's rounding.
  bool outside(const core::Aabb& box) const;

  /// For who does the same elsewhere. Where no section plane cuts a box, allowed() is error_per_w() times the least of
  /// w(), a linear form of points, in the box, or times nearest_w() if that is more; less the rounding of double.
  /// error_per_w() is 0 where no error is allowed.
  const core::dvec4& w() const { return w_; }
  double error_per_w() const { return error_per_w_; }
  double nearest_w() const { return nearest_; }
  std::span<const core::dvec4> sections() const { return sections_; }  ///< linear forms, too: 0 on a plane

 private:
  std::array<core::dvec4, core::kFrustumPlaneCount> planes_;
  std::vector<core::dvec4> sections_;
  core::dvec4 w_, w_sizes_;  // the latter: of the terms that w_ is the sum of
  double pixels_, error_per_w_, nearest_;
};

/// Around what a GPU draws of a box in a mesh: it computes corners in float. Relative to an origin.
core::AabbD placed_box(const core::Aabb& box, const core::Affine& world_from_mesh, const core::dvec3& origin);

/// Indices of MeshLevels::indices.
struct IndexRange {
  std::uint32_t first = 0, count = 0;
};

/// Chooses cuts from coarse to fine: time follows what is drawn, not the mesh, but for a byte a group and a bit a
/// cluster. Keeps memory from mesh to mesh.
class CutChooser {
 public:
  /// Sets `ranges` to what draws a mesh within the image's error, in rising order and with gaps between them; none: it
  /// lies outside.
  void choose(const MeshLevels& levels, const MeshError& error, std::vector<IndexRange>& ranges) {
    merge(levels, choose(levels, error), ranges);
  }
  /// The clusters of that, in rising order. The list is the chooser's until the next call, and may be made shorter. It
  /// is the same for any number of threads; null: this one alone.
  std::vector<std::uint32_t>& choose(const MeshLevels& levels, const MeshError& error,
                                     core::ThreadPool* threads = nullptr);
  /// What draws clusters, which rise.
  static void merge(const MeshLevels& levels, std::span<const std::uint32_t> clusters, std::vector<IndexRange>& ranges);
  /// The proven error in the image of what was chosen last, in pixels, at most ImageError's; 0: the mesh's triangles.
  double error() const { return error_; }
  std::size_t memory_bytes() const;

 private:
  enum class State : std::uint8_t { kUnknown, kSimplified, kExpanded };
  /// A job's findings.
  struct alignas(64) Found {              // threads write neighbours at once
    std::vector<std::uint32_t> expanded;  // groups whose clusters are yet to be considered
    double error = 0.0;
  };

  void consider(const MeshLevels& levels, const MeshError& error, std::span<const std::uint32_t> clusters,
                Found& found);
  State decide(const MeshLevels& levels, const MeshError& error, std::uint32_t group, Found& found);
  void take(Found& found);
  void list_drawn(std::size_t words);

  double error_ = 0.0;
  std::vector<std::atomic<State>> state_;          // by group
  std::vector<std::atomic<std::uint64_t>> shown_;  // a bit per cluster that is drawn
  std::vector<Found> found_;                       // by job
  std::vector<std::uint32_t> open_, drawn_;
};

}  // namespace sightline::lod
