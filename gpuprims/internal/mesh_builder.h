// Collects the triangles of one primitive and keeps the promises of tessellation.h. Internal to gpuprims.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/mesh.h"
#include "sightline/gpuprims/internal/ray.h"

namespace sightline::gpuprims {

using core::dvec2;

/// (cos, sin) at the segments + 1 ends of equal segments of an arc that starts at angle 0. From 2 pi on, the last
/// equals the first exactly.
std::vector<dvec2> arc_points(int segments, double arc);

/// True when all values are finite. Primitives with other parameters are drawn as nothing.
bool all_finite(std::span<const float> values);

struct Vertex {
  dvec3 position{0.0};
  dvec3 normal{0.0};  ///< of any length
};

class MeshBuilder {
 public:
  std::uint32_t add(const Vertex& vertex);

  /// Drops the triangle when two of its corners share a position. Its remaining edges cancel, so the surface stays
  /// closed.
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);

  /// A planar quad with its own flat normal, corners counter-clockwise.
  void add_flat_quad(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& d);

  /// A planar convex polygon, corners counter-clockwise, cut as a strip: that gives fewer slivers than a fan and no
  /// inner vertex.
  void add_flat_polygon(std::span<const dvec3> points, const dvec3& normal);

  /// A level disc at `z` whose rim is arc_points() of a full circle. `up`: 1 or -1, the z of its normal.
  void add_disc(std::span<const dvec2> circle, double radius, double z, double up);

  /// (rows + 1) x (columns + 1) vertices at(row, column); column direction x row direction points outwards.
  template <class At>
  void add_grid(int rows, int columns, const At& at) {
    const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
    const auto stride = static_cast<std::uint32_t>(columns) + 1;
    for (int i = 0; i <= rows; ++i)
      for (int j = 0; j <= columns; ++j) add(at(i, j));
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(rows); ++i)
      for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(columns); ++j) {
        const std::uint32_t v = first + i * stride + j;
        add_triangle(v, v + 1, v + stride + 1);
        add_triangle(v, v + stride + 1, v + stride);
      }
  }

  /// Returns the mesh without unused vertices. The builder is empty afterwards.
  core::Mesh finish();

 private:
  core::Mesh mesh_;
};

}  // namespace sightline::gpuprims
