// Internal to the importers: the surface of a face, if it is one of those that analytic_solid.h knows.
#pragma once

#include <optional>

#include <BRepAdaptor_Surface.hxx>

#include "sightline/core/mesh_extras.h"
#include "sightline/importers/cad/internal/analytic_solid.h"

namespace sightline::importers {

struct FaceSurface {
  SurfacePatch as;   ///< without area, inside and borders
  double gap = 0.0;  ///< how far the face lies from it
};

/// Planes, cylinders, cones, spheres and tori as the face states them. Splines and surfaces of revolution or extrusion
/// are the same ones where 17 x 17 points of the face, spread evenly over its parameters, lie within the tolerance.
std::optional<FaceSurface> face_surface(const BRepAdaptor_Surface& face, double tolerance);

/// The whole surface of a patch, as meshes have it.
core::MeshSurface mesh_surface(const SurfacePatch& patch);

}  // namespace sightline::importers
