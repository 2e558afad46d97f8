// Builds the mesh pool of a GPU scene. Internal to gpuscene.
#pragma once

#include "sightline/gpuscene/gpu_scene.h"

namespace sightline::gpuscene {

/// True when an item's mesh brings no normals and is shaded flat.
bool flat_shaded(const core::Snapshot& snapshot, core::Slot slot);

/// Gathers and uploads the meshes of all items of the mesh batch, `slots` in rising order.
core::Expected<MeshPool> build_mesh_pool(const gl::Functions& gl, const core::Snapshot& snapshot,
                                         std::span<const core::Slot> slots);

}  // namespace sightline::gpuscene
