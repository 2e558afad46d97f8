// The normal and the material by which renderers light what a ray hits. Internal to raytrace.
#pragma once

#include "sightline/raytrace/tracer.h"

namespace sightline::raytrace {

/// The mean of a triangle's normals where its mesh has any, otherwise the surface's own normal: in the world, of unit
/// length, and towards where a ray of this direction comes from.
core::dvec3 shading_normal(const core::Snapshot& snapshot, const Hit& hit, const core::dvec3& direction);

/// Colour and alpha of a slot's item.
glm::vec4 material_of(const core::Snapshot& snapshot, core::Slot slot);
/// Whether no material lets anything through.
bool all_opaque(const core::MaterialTable& materials);

}  // namespace sightline::raytrace
