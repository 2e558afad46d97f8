// Internal to the recognition of primitives: which primitive a solid, or a part of a chain of rings, is.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sightline/core/affine.h"
#include "sightline/core/primitive.h"
#include "sightline/importers/recognise/internal/ring_chain.h"
#include "sightline/importers/recognise/internal/solids.h"

namespace sightline::importers::recognition {

/// What may lie how far from a surface (docs/guide/recognition.md).
struct Allowance {
  CoordinateNoise noise;
  double chosen = 0.0;  ///< > 0: for vertices, instead of what the mesh itself tells

  /// The allowance of a vertex from a surface of this radius whose facets lie within `sagitta` of it.
  double vertex(double radius, double sagitta) const;
  /// Two measures that differ by less are taken to be equal. `residual`: of the fits that they come from.
  double same(double radius, double sagitta, double residual) const;
};

/// A primitive and the triangles of the solid that it stands for.
struct Found {
  core::Primitive primitive;
  core::Affine mesh_from_primitive;
  std::vector<std::uint32_t> triangles;
  double deviation = 0.0;  ///< largest distance between triangles and surface, both ways
  double along = 0.0;      ///< the most that it goes along the primitive's z axis
  double residual = 0.0;   ///< largest distance of a vertex from the surface
};

/// The fewest segments of a circle that count as one. Hexagons are heads of bolts.
inline constexpr std::size_t kLeastSegments = 8;

/// Checks a candidate against its triangles and sets its deviation and residual. Vertices must lie within `vertex` of
/// the surface, centres and edges' middles within `explained` more, and the area must agree. `covered`: area of the
/// primitive where it needs no triangles. `rim`: how far the chords at its ends lie within its circles. There it may
/// be beyond its triangles although all of these are close to it: in the plane of a flat end.
bool verify(const Solid& solid, double vertex, double explained, double covered, double rim, Found& found);

/// A sphere, a closed torus, a box or a pyramid that is the whole of a closed solid.
std::optional<Found> fit_whole(const Solid& solid, const Faces& faces, const Allowance& allowance);

/// The primitives that a chain of rings goes through.
std::vector<Found> fit_chain(const Solid& solid, const RingChain& chain, const Allowance& allowance);

// --- shared by both -------------------------------------------------------------------------------------------------

/// Right-handed axes with z along `axis` (unit) and x as near to `towards` as it can be.
core::dmat3 axes_along(const dvec3& axis, const dvec3& towards);

/// The circle through points (x, y) with the least algebraic error (I. Kasa, 1976): exact where they lie on one.
struct Circle {
  core::dvec2 centre{0.0};
  double radius = 0.0;
};
std::optional<Circle> fit_circle(const std::vector<core::dvec2>& points);

/// Solves a x = b by elimination with pivots; nothing when a is nearly singular.
std::optional<dvec3> solve(core::dmat3 a, dvec3 b);

}  // namespace sightline::importers::recognition
