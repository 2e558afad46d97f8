// Internal to the writers of glTF: which primitives share their triangles.
//
// Cylinders, spheres and boxes are of size 1, and placements scale them. Scales of what is bent lie in steps of an
// eighth of an octave: primitives of the same parameters whose scales lie in the same step have as many segments.
#pragma once

#include <array>
#include <cstdint>

#include "sightline/core/conventions.h"
#include "sightline/core/mesh.h"
#include "sightline/core/primitive.h"

namespace sightline::importers {

struct SharedPrimitive {
  /// Kind, bits of the parameters, step of the scale. Equal for those that share their triangles.
  using Key = std::array<std::uint32_t, 11>;

  core::Primitive primitive;  ///< that is cut into triangles
  core::dvec3 scale{1.0};     ///< along its own axes: makes the item of it
  double bend = 0.0;          ///< largest scale of what is bent, in the world; 0 of a curved one: it shows nothing
  double largest_bend = 1.0;  ///< of those that share the triangles
  bool curved = false;        ///< no: its triangles are exact, at any scale
  Key key{};

  bool empty() const { return curved && !(bend > 0.0); }
  /// Triangles within `tolerance` metres of each item that shares them. A full turn has at least `segments`.
  core::Mesh triangles(double tolerance, int segments = 8) const;
};

SharedPrimitive shared_primitive(const core::Primitive& primitive, const core::dmat3& world_from_item);

}  // namespace sightline::importers
