// Internal to the writers of glTF: maps as nodes and instances have them.
#pragma once

#include <span>
#include <string>

#include "sightline/core/affine.h"
#include "sightline/importers/gltf/internal/gltf_output.h"

namespace sightline::importers {

/// z up to y up.
inline const core::Affine kGltfFromWorld{core::dmat3(1, 0, 0, 0, 0, -1, 0, 1, 0), core::dvec3(0.0)};

/// Whether a map is a rotation times a scale, which is all that glTF has.
bool is_decomposable(const core::dmat3& m);

/// Members of EXT_mesh_gpu_instancing's attributes: TRANSLATION, ROTATION and SCALE of these placements, whose linear
/// parts are decomposable. Floats, so that the placements should be relative to a place among them.
std::string instance_attributes(GltfOutput& output, std::span<const core::Affine> placements);

}  // namespace sightline::importers
