#include "sightline/gpuprims/internal/view_block.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sightline/core/internal/section_rounding.h"

namespace sightline::gpuprims {

using core::dmat4;
using core::dvec4;

dmat4 reversed_clip_from_eye(const core::View& view) {
  dmat4 clip = view.clip_from_eye();
  const double near = core::near_depth(view.clip_depth()), far = core::far_depth(view.clip_depth());
  if (near < far)
    for (int c = 0; c < 4; ++c) clip[c][2] = (far * clip[c][3] - clip[c][2]) / (far - near);
  return clip;
}

double eye_depth(const dmat4& clip, double depth) {
  // depth = (c33 - c23' t) / (c43 - c4' t) with t = -z, solved for t.
  const double numerator = clip[3][2] - depth * clip[3][3], denominator = clip[2][2] - depth * clip[2][3];
  if (denominator == 0.0) return std::numeric_limits<double>::infinity();
  return numerator / denominator;
}

namespace {

/// Coordinates in which hatching lines lie at whole numbers of their distance: the sum and the difference of the
/// coordinates along the horizontal of a section plane and across it. So they rise and fall at 45 degrees as seen from
/// the removed side. They are counted from the world's origin, in double, and only their small parts become float.
/// `plane`: the section in eye space.
void add_hatching(ViewBlock& block, int index, const core::dvec3& normal, const dvec4& plane,
                  const dmat4& world_from_eye) {
  const core::dvec3 n = glm::normalize(normal), level = glm::cross(core::dvec3(0.0, 0.0, 1.0), n);
  const double length = glm::length(level);
  const core::dvec3 along = length > 0.0 ? level / length : core::dvec3(1.0, 0.0, 0.0), up = glm::cross(n, along);
  for (int i = 0; i < 2; ++i) {
    dvec4 across = glm::transpose(world_from_eye) * dvec4(i == 0 ? up + along : up - along, 0.0);
    if (block.flags.x == 0 && plane.z != 0.0) across -= across.z / plane.z * plane;  // the eye may be far from the face
    const double whole = std::floor(across.w);
    block.hatch_across[2 * index + i] = glm::vec4(core::dvec3(across), across.w - whole);
    block.hatch_whole[index][i] = float(whole - kHatchPeriod * std::floor(whole / kHatchPeriod));
  }
}

/// The twin of leading_bits() in pairs.glsl.
float leading_bits(double x) {
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(float(x)) & 0xfffff000u);
}

glm::vec4 rest_of(const dvec4& x, const glm::vec4& high) {
  return glm::vec4(x - dvec4(high));
}

void set_linear(ViewBlock& block, const dmat4& eye_from_world) {
  for (int c = 0; c < 3; ++c) {
    const dvec4& column = eye_from_world[c];
    block.eye_from_world[c] = glm::vec4(column);
    block.eye_from_world_parts[0][c] = {leading_bits(column.x), leading_bits(column.y), leading_bits(column.z), 0.0f};
    block.eye_from_world_parts[1][c] = rest_of(column, block.eye_from_world_parts[0][c]);
  }
}

/// The rays of pixels from a clip matrix; the coefficients that are not 0 in pairs.
void set_rays(ViewBlock& block, const dmat4& clip, bool perspective, int width, int height) {
  // Solves clip.x = ndc.x * clip.w for the point at eye depth t; w is clip[2][3] * -t in perspective, 1 in orthographic
  // views.
  const double scale[2] = {1.0 / clip[0][0], 1.0 / clip[1][1]}, size[2] = {double(width), double(height)};
  for (int axis = 0; axis < 2; ++axis) {
    // At ndc -1 + 2 p / size.
    const double w = perspective ? -clip[2][3] : 1.0, step = scale[axis] * w * 2.0 / size[axis];
    const dvec4 ray = perspective ? dvec4(0.0, 0.0, scale[axis] * (clip[2][axis] - w), step)
                                  : dvec4(-scale[axis] * (clip[3][axis] + w), step, 0.0, 0.0);
    block.pixel_ray[axis] = glm::vec4(ray);
    const glm::vec4 rest = rest_of(ray, block.pixel_ray[axis]);
    for (int i = 0; i < 2; ++i) block.pixel_ray_rest[2 * axis + i] = rest[perspective ? 2 + i : i];
  }
}

}  // namespace

void eye_relative_origins(const core::View& view, std::span<const core::dvec3> origins, std::vector<glm::vec4>& rows) {
  // The matrix alone says where the eye is, and it alone must not be rounded: an origin is placed by it, and then
  // turned back.
  const dmat4& eye_from_world = view.eye_from_world();
  const glm::dmat3 world_from_eye = glm::inverse(glm::dmat3(eye_from_world));
  rows.clear();
  for (const core::dvec3& origin : origins) {
    const dvec4 from_eye(world_from_eye * core::dvec3(eye_from_world * dvec4(origin, 1.0)), 0.0);
    rows.push_back(glm::vec4(from_eye));
    rows.push_back(rest_of(from_eye, rows.back()));
  }
}

core::Expected<ViewBlock> make_view_block(const core::View& view, int width, int height) {
  const dmat4 clip = reversed_clip_from_eye(view);
  const bool separable = clip[0][1] == 0.0 && clip[0][2] == 0.0 && clip[1][0] == 0.0 && clip[1][2] == 0.0 &&
                         clip[0][0] != 0.0 && clip[1][1] != 0.0;
  const bool perspective = !view.orthographic();
  const bool ahead = perspective ? clip[2][3] < 0.0 && clip[3][3] == 0.0 : clip[3][3] > 0.0 && clip[2][2] > 0.0;
  if (!separable || clip[0][3] != 0.0 || clip[1][3] != 0.0 || !ahead)
    return core::fail("view: clip_from_eye must be a perspective or orthographic projection along -z");

  ViewBlock block{};
  const dmat4& eye = view.eye_from_world();
  set_linear(block, eye);
  block.clip_from_eye = glm::mat4(clip);
  set_rays(block, clip, perspective, width, height);
  block.viewport = glm::vec4(width, height, 0.0, 0.0);
  block.depth_range = glm::vec4(eye_depth(clip, 1.0), std::min(eye_depth(clip, 0.0), 3.0e38), 0.0, 0.0);
  block.up = glm::vec4(glm::normalize(glm::dmat3(eye) * glm::dvec3(0.0, 0.0, 1.0)), 0.0);

  // A world half-space n.p + d in eye coordinates, in double: only the small eye-relative numbers become float.
  const dmat4 world_from_eye = glm::inverse(eye);
  block.flags.x = perspective ? 1 : 0;
  int count = 0;
  double largest = glm::dot(glm::abs(core::dvec3(world_from_eye[3])), core::dvec3(1.0));
  for (const core::Plane& given : view.sections) {
    if (given.normal == core::dvec3(0.0) || count == kMaxSections) continue;
    const core::Plane plane = core::normalised(given);
    largest = std::max(largest, std::abs(plane.offset));
    const dvec4 in_eye_space = glm::transpose(world_from_eye) * dvec4(plane.normal, plane.offset);
    block.sections[count] = glm::vec4(in_eye_space);
    block.sections_rest[count] = rest_of(in_eye_space, block.sections[count]);
    add_hatching(block, count++, plane.normal, in_eye_space, world_from_eye);
  }
  block.depth_range.z = float(core::kWorldRounding * largest);
  block.flags = {perspective ? 1 : 0, count, view.section_mode == core::SectionMode::kUnion ? 1 : 0, 0};
  return block;
}

void to_distances(const core::View& view, std::span<float> depths) {
  const core::dmat4 clip = reversed_clip_from_eye(view);
  for (float& depth : depths)
    depth = depth == 0.0f ? std::numeric_limits<float>::infinity() : float(eye_depth(clip, depth));
}

glm::vec2 pixel_depth(const core::View& view, int height) {
  const core::dmat4 clip = reversed_clip_from_eye(view);
  const double pixel = 2.0 / (clip[1][1] * height);  // in parallel views metres, else at the distance of 1
  return view.orthographic() ? glm::vec2(0.0, clip[2][2] * pixel) : glm::vec2(pixel, clip[2][2] * pixel);
}

}  // namespace sightline::gpuprims
