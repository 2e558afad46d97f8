// Ray-cast primitives in a renderer other than ours, which has OpenGL 4.5: the GLSL, the records of items, and what
// both expect. examples/own_renderer.cpp is a whole program.
//
// A primitive is a record. Its eight vertices place a proxy around it, and each fragment casts a ray at the exact
// surface and writes its depth. The items of one RayCastProgram::kind are one draw:
//
//   program         both texts, linked; uniforms at locations 0 (uint: number of records), 1 (uint: kind), 2 (int:
//                   texels_per_record)
//   block 0         ray_cast_view(), of each frame
//   texture unit 0  buffer texture RGBA32UI: records, back to back
//   texture unit 1  buffer texture RGBA32F: ray_cast_origins(), of each frame
//   texture unit 2  buffer texture RGBA32F: materials, as sRGB colour and alpha from 0 to 1; alpha below 1 is a pattern
//                   of pixels
//   texture unit 3  nothing; a buffer texture R32UI of records by number, for vertices beyond eight of each record
//   draw            GL_TRIANGLES with the indices of ray_cast_indices(), no vertex attributes, no base vertex
//   state           GL_CULL_FACE, GL_DEPTH_CLAMP, glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE), GL_DEPTH_TEST with
//                   GL_GREATER; depth is reversed, should be GL_DEPTH_COMPONENT32F, and is cleared to 0
//   writes          output 0: sRGB colour; output 1 (R32UI): id + 1; output 2 with RayCastFormat::normals: normal
//                   in eye space, towards the eye
//
// A record is whole RGBA32UI texels. Words 0 to 8 are the columns of its frame's linear map to its chunk, 9 to 11 the
// frame's origin from that of the chunk, 12 the chunk, 13 the id, 14 the material, 15 and what follows the shape. Views
// that the application draws triangles with must have the same matrices (core::View::from_matrices); the depth of those
// must be reversed alike.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"

namespace sightline::render {

/// Changes with anything that is said above. Texts and numbers of one library always belong together.
inline constexpr int kRayCastVersion = 1;

struct RayCastFormat {
  bool normals = false;
  bool sections = false;     ///< cut by View::sections, with faces of the cut where solids are cut
  int samples = 1;           ///< of the framebuffer; from 2 on each sample casts its ray
  bool plain_depth = false;  ///< for drivers that fail on conservative depth (depth_less)
};

/// What draws the items of some kinds: spheres and dishes share one.
struct RayCastProgram {
  std::string vertex, fragment;  ///< "#version 450 core"
  std::uint32_t kind = 0;
  int texels_per_record = 0;
};
/// Fails on kinds that are not ray-cast: lines, facet groups and meshes.
SIGHTLINE_API core::Expected<RayCastProgram> ray_cast_program(core::Kind kind, const RayCastFormat& format = {});

/// Appends the record of a primitive of a ray-cast kind. `material`: row of the materials, below 2^24. What has no
/// extent or no finite numbers becomes a record that shows nothing.
SIGHTLINE_API void append_ray_cast_record(const core::Primitive& primitive, const core::Placement& placement,
                                          std::uint32_t id, std::uint32_t material,
                                          std::vector<std::uint32_t>& records);
/// Six triangles of each of so many records.
SIGHTLINE_API std::vector<std::uint32_t> ray_cast_indices(std::uint32_t records);

/// The uniform block (std140) of a view, drawn in width x height pixels from pixel 0, 0 on, lit by a head-light. Fails
/// on projections that are neither perspective nor orthographic.
SIGHTLINE_API core::Expected<std::vector<std::byte>> ray_cast_view(const core::View& view, int width, int height);
/// Two texels for each chunk, from its origin in the world: where it lies as seen from the eye, to 48 bits.
SIGHTLINE_API std::vector<glm::vec4> ray_cast_origins(const core::View& view, std::span<const core::dvec3> origins);

}  // namespace sightline::render
