// Internal to the recognition of primitives: takes a triangle mesh apart into its solids.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sightline/core/mesh.h"

namespace sightline::importers::recognition {

using core::dvec3;
using core::kNone;

/// How far a vertex may be from where its maker put it: the rounding of floats, and the step of a grid that all
/// coordinates lie on, as those of files with a fixed number of decimals do.
struct CoordinateNoise {
  double rounding = 0.0;  ///< of floats of the mesh's size
  double grid = 0.0;      ///< half the diagonal of the grid's cell; 0 where there is no grid
};
CoordinateNoise coordinate_noise(const core::Mesh& mesh);

/// Triangles that hang together by edges, with vertices of their own. Half-edge 3 t + k runs from corner k of triangle
/// t to its next corner.
struct Solid {
  std::vector<dvec3> points;
  std::vector<std::uint32_t> corners;  ///< three per triangle, into points
  std::vector<std::uint32_t> twins;    ///< of each half-edge, the one of the neighbour; kNone where there is none
  std::vector<std::uint32_t> origin;   ///< of each triangle, its number in the mesh
  bool open = false;                   ///< some half-edge has no twin

  std::uint32_t triangle_count() const { return std::uint32_t(origin.size()); }
  static std::uint32_t next(std::uint32_t half_edge) { return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1; }
  static std::uint32_t previous(std::uint32_t half_edge) { return half_edge % 3 == 0 ? half_edge + 2 : half_edge - 1; }
  std::uint32_t from(std::uint32_t half_edge) const { return corners[half_edge]; }
  std::uint32_t to(std::uint32_t half_edge) const { return corners[next(half_edge)]; }
  /// Twice the triangle's area, along its normal.
  dvec3 area_vector(std::uint32_t triangle) const {
    const dvec3& a = points[corners[3 * triangle]];
    return glm::cross(points[corners[3 * triangle + 1]] - a, points[corners[3 * triangle + 2]] - a);
  }
};

/// The solids of a mesh, one after the other.
///
/// Vertices closer than the rounding of the mesh's floats are one. Two triangles are neighbours when they alone share
/// an edge, in opposite directions. Where more share it, solids touch: sorted by their angle about the edge, each
/// triangle that opens a wedge of material is joined with the one that closes it, the first opened with the first
/// closed. Triangles with a corner that is not finite, or with two equal ones, belong to no solid.
///
/// Time is linear but for the sorting of edges that many triangles share; memory is at most 250 bytes per triangle,
/// most of which soup needs for its vertices.
class Solids {
 public:
  Solids(const core::Mesh& mesh, const CoordinateNoise& noise);

  std::size_t count() const { return first_.size() - 1; }
  std::uint64_t set_aside() const { return set_aside_; }  ///< triangles that belong to no solid
  /// Fills `solid`, reusing its memory.
  void get(std::size_t index, Solid& solid);

 private:
  void weld(const core::Mesh& mesh, double distance);
  void find_twins();
  void pair_around_edge(std::uint32_t low, std::uint32_t high, std::uint64_t* begin, std::uint64_t* end);
  void find_components();

  double noise_;  // how far vertices may be off
  std::vector<dvec3> points_;
  std::vector<std::uint32_t> corners_, twins_;
  std::vector<std::uint32_t> order_, first_;  // triangles by solid
  std::vector<std::uint32_t> place_;          // of a triangle in its solid; of a vertex in the solid at hand
  std::vector<std::uint32_t> local_;
  std::uint64_t set_aside_ = 0;
};

}  // namespace sightline::importers::recognition
