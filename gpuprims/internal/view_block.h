// The uniform block that every shader reads: C++ twin of shaders/view.glsl (std140).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "sightline/core/view.h"
#include "sightline/gpuprims/internal/packing.h"
#include "sightline/gpuprims/surroundings.h"

namespace sightline::gpuprims {

static_assert(kMaxSections == int(core::kMaxSectionPlanes));

struct ViewBlock {
  glm::vec4 eye_from_world[3];  // columns, padded
  glm::vec4 eye_from_world_parts[2][3];
  glm::vec4 pixel_ray[2];
  glm::vec4 pixel_ray_rest;
  glm::mat4 clip_from_eye;
  glm::vec4 depth_range;
  glm::vec4 viewport;
  glm::vec4 up;  ///< w: for the renderer to fill; what black materials are lit as, as a grey
  glm::ivec4 flags;
  glm::vec4 sections[kMaxSections];
  glm::vec4 hatching;  ///< for the renderer to fill; 0: none
  glm::vec4 hatch_across[2 * kMaxSections];
  glm::vec4 hatch_whole[kMaxSections];
  glm::vec4 lights[kMostDistantLights];  ///< for the renderer to fill; 0: the head-light
  glm::vec4 sections_rest[kMaxSections];
};
static_assert(offsetof(ViewBlock, pixel_ray) == 144);
static_assert(offsetof(ViewBlock, clip_from_eye) == 192);
static_assert(offsetof(ViewBlock, flags) == 304);
static_assert(offsetof(ViewBlock, sections) == 320);
static_assert(offsetof(ViewBlock, hatching) == 320 + 16 * kMaxSections);
static_assert(offsetof(ViewBlock, lights) == 336 + 64 * kMaxSections);
static_assert(sizeof(ViewBlock) == 336 + 80 * kMaxSections + 16 * kMostDistantLights);

/// Clip matrix with reversed zero-to-one depth, whatever convention the view was made for.
core::dmat4 reversed_clip_from_eye(const core::View& view);

/// Hatching repeats after so many metres along a plane, so that their number stays exact in float.
constexpr double kHatchPeriod = 1048576.0;

/// Fills the block for a viewport of width x height pixels. Views may be perspective (also off-axis) or orthographic; a
/// projection with any other structure is an error.
core::Expected<ViewBlock> make_view_block(const core::View& view, int width, int height);

/// What shaders read of chunk origins: two rows each, their place relative to the eye along world axes as a float and
/// what that leaves. Replaces `rows`.
void eye_relative_origins(const core::View& view, std::span<const core::dvec3> origins, std::vector<glm::vec4>& rows);

/// Eye depth (metres along the view axis) of a reversed zero-to-one depth value; infinity for the cleared depth 0 of an
/// infinite far plane.
double eye_depth(const core::dmat4& reversed_clip_from_eye, double depth);

/// Replaces reversed depths by distances along the axis of the view that was drawn; infinity where nothing was.
void to_distances(const core::View& view, std::span<float> depths);

/// Factor and offset of the depth that give a step of one pixel, in reversed depth, on a plane that rises as far as it
/// goes. Pixels are as wide as high.
glm::vec2 pixel_depth(const core::View& view, int height);

}  // namespace sightline::gpuprims
