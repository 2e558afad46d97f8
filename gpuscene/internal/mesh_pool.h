// Builds the mesh pool of a GPU scene. Internal to gpuscene.
#pragma once

#include "sightline/gpuscene/internal/gpu_scene.h"

namespace sightline::gpuscene {

/// Packs a direction with the octahedral mapping into two snorm16 (Z. Cigolle et al., "A Survey of Efficient
/// Representations for Independent Unit Vectors", 2014), within 7e-5 rad. A vector of no length gives kNoNormal.
/// mesh.vert unpacks it.
std::uint32_t pack_normal(const core::vec3& normal);
inline constexpr std::uint32_t kNoNormal = 0x80008000u;

/// True when an item's mesh has no normals and is shaded flat.
bool flat_shaded(const core::Snapshot& snapshot, core::Slot slot);

/// Gathers and uploads the meshes of all items of the mesh batch. `slots` must rise.
core::Expected<MeshPool> build_mesh_pool(const gl::Functions& gl, const core::Snapshot& snapshot,
                                         std::span<const core::Slot> slots);

}  // namespace sightline::gpuscene
