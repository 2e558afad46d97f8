// What distances are computed on: a convex set by its support function, the slices of a torus, or a mesh with a
// hierarchy over its triangles. Internal to measure.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sightline/analysis/measure/features.h"
#include "sightline/core/aabb.h"
#include "sightline/core/mesh.h"

namespace sightline::measure {

using core::dmat3;
using core::dvec2;

using core::length_of;

/// A filled ellipse: centre + a u + b v with a^2 + b^2 <= 1. u and v need not be perpendicular.
struct Disc {
  dvec3 centre, u, v;
};

/// A slice swept about the local z axis: the rectangle from `inner` to `outer`, +-half_height, grown by a circle of
/// radius `tube`. A part beyond the axis does not count. All >= 0; with a tube, inner = outer and half_height = 0.
struct Sweep {
  double inner = 0.0, outer = 0.0, half_height = 0.0, tube = 0.0;
  double from = 0.0, to = core::kFullTurn;
};

/// A node of the hierarchy over a mesh's triangles. Its first child follows it; `second` is the other one, or 0 in a
/// leaf, which has one triangle.
struct TriangleNode {
  core::AabbD box;
  std::uint32_t begin = 0, count = 0;  ///< its triangles
  std::uint32_t second = 0;
};

struct Shape {
  enum class Form : std::uint8_t {
    kPoints,     ///< convex hull of `points`
    kDiscs,      ///< convex hull of `discs`
    kBall,       ///< linear * unit ball
    kHalfBall,   ///< its half above local z = 0
    kCap,        ///< linear * cap of a sphere: core::SphericalDish
    kSweep,      ///< linear * slices
    kTriangles,  ///< `points` are corners, three to a triangle; `nodes` the hierarchy, its root first
  };
  Form form = Form::kPoints;
  dvec3 origin{0.0};  ///< in the world; all else is relative to it
  dmat3 linear{1.0};
  std::vector<dvec3> points;
  std::vector<std::uint32_t> mesh_triangles;  ///< kTriangles: of each its number in the mesh
  std::array<Disc, 2> discs{};
  double base_radius = 0.0, height = 0.0;  ///< kCap
  Sweep sweep;
  std::vector<TriangleNode> nodes;
  bool solid = false;  ///< kTriangles: they enclose what is within
  double error = 0.0;  ///< how far the true surface may lie outside the shape
};

/// Part of a shape that has a support function: all of it, the slices between two directions, or a node.
struct Piece {
  const Shape* shape;
  dvec3 offset;                ///< of the shape's origin from the common one
  dvec2 from{1, 0}, to{1, 0};  ///< kSweep: unit directions, at most a quarter turn apart
  std::uint32_t node = 0;      ///< kTriangles

  bool one_slice() const { return from == to; }
  bool is_leaf() const { return shape->nodes[node].second == 0; }
  /// Convex by itself: its hull is no larger.
  bool is_convex() const {
    return shape->form == Shape::Form::kSweep ? one_slice() : shape->form == Shape::Form::kTriangles ? is_leaf() : true;
  }
};

struct Support {
  dvec3 point;
  dvec2 slice{1, 0};  ///< kSweep: where the point lies
};

/// The point of the piece's convex hull that lies farthest along `direction`. For a node of many triangles, of its box.
Support support(const Piece& piece, const dvec3& direction);

/// Arguments must be finite.
Shape make_shape(const core::Primitive& primitive, const core::Affine& world_from_item);
/// `mesh` must pass validate(). Triangles with a corner that is not finite are left out.
Shape make_shape(const core::Mesh& mesh, const core::Affine& world_from_item);
/// Not for lines, which are infinite.
Shape make_shape(const Geometry& geometry);

/// The bottom's four corners in turn, counter-clockwise seen from above, then the top's above them.
std::array<dvec3, 8> corners_of(const core::Pyramid& pyramid);
/// A box as a pyramid.
core::Pyramid as_pyramid(const core::Box& box);

/// An end of a snout: the ellipse in which its plane cuts the cone, in local coordinates.
struct SnoutEnd {
  Disc contour;
  dvec3 upwards;  ///< normal of the plane, of positive z
};
/// Both ends. Nothing where a contour is not closed or the ends cross: then the solid is not the hull of its contours.
std::optional<std::array<SnoutEnd, 2>> snout_ends(const core::Snout& snout);

}  // namespace sightline::measure
