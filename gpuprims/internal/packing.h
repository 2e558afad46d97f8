// How items lie in GPU memory: C++ twin of shaders/payload.glsl. All records are whole RGBA32UI texels, read through a
// buffer texture.
//
//   head (every kind)   4 texels   placement 12 floats, chunk, item id, material | flags, first shape parameter
//   box, mesh, line     head alone: 64 bytes
//   cylinder            head alone: 64 bytes, in units of its radius; first parameter: height
//   sphere, dishes      head alone: 64 bytes, in units of their ball's radii, flat dishes of their base's; first
//                       parameter: height of the cap
//   circular torus      head + 1:   80 bytes, in units of its larger radius; first parameter: tube radius
//   rectangular torus   head + 1:   80 bytes, in units of its outer radius; first parameter: height
//   pyramid             head + 2:   96 bytes, in units of its largest side or height; first parameter: height
//   snout               head + 3:  112 bytes, in units of its larger radius; first parameter: height
//
// Each kind's shader describes the further texels. Scaling by the largest radius keeps the shader's numbers near 1
// whatever the file's unit. Slices of tori are rotated so that their sweep is symmetric about x. An affine placement
// makes every kind exact under any node transform, including mirrored, sheared and non-uniform ones. A primitive with a
// parameter that is not finite is drawn as nothing.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/primitive.h"
#include "sightline/core/snapshot.h"

namespace sightline::gpuprims {

class Joints;

using Texel = std::array<std::uint32_t, 4>;

using uint = std::uint32_t;  // GLSL's name for it
#include "sightline/gpuprims/shaders/limits.glsl"

/// Everything in a record besides the shape.
struct PackedItem {
  core::Placement placement;
  std::uint32_t id = 0;
  std::uint32_t material = 0;  ///< row of the material table | flags such as kBottomOpen
};

/// Which 32-bit word of a record is PackedItem::material.
inline constexpr std::uint32_t kMaterialWord = 14;

/// Texels per record of a ray-cast or instanced kind.
constexpr int texels_per_item(core::Kind kind) {
  switch (kind) {
    case core::Kind::kCircularTorus:
    case core::Kind::kRectangularTorus:
      return 5;
    case core::Kind::kPyramid:
      return 6;
    case core::Kind::kSnout:
      return 7;
    default:
      return 4;
  }
}

/// Writes the record of one item to `out`, which holds texels_per_item(kind) texels. `parameters` are those of the
/// kind, empty for tessellated kinds (their shape is in the mesh). A primitive without any extent, and a solid
/// under a singular placement, get a zero scale, which shaders skip.
void pack(core::Kind kind, std::span<const float> parameters, const PackedItem& item, std::span<Texel> out);

/// The row of the material table that a slot's item is drawn with. Row 0 is for items that name no material; the
/// materials follow in scene order.
std::uint32_t material_row(const core::Snapshot& snapshot, core::Slot slot);
/// PackedItem::material of a slot: its row, its ends that neighbours cover, and whether it is vacant.
std::uint32_t material_word(const core::Snapshot& snapshot, const Joints& joints, core::Slot slot);
/// Writes the record of a slot's item, with this PackedItem::material.
void pack(const core::Snapshot& snapshot, core::Slot slot, std::uint32_t material, std::span<Texel> out);

}  // namespace sightline::gpuprims
