#include "sightline/culling/occlusion/internal/triangle_test.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace sightline::culling {
namespace {

using core::dmat3;
using core::dvec3;
using core::dvec4;

// Roundings of float on the way to a form's value, each of at most 2^-24 of the sum of the sizes of its terms: 13 in a
// shader (entries of the matrix from mesh to eye, its product with a position, the sum with the origin, and the same
// with the projection), 6 of the form here. Some are spare.
constexpr double kLost = 24.0 * 0x1p-24;
constexpr double kLostInPairs = 0x1p-44;   // the same for what is rounded before it is relative to the eye
constexpr double kLostInTurning = 0x1p-32;  // of the sizes of the terms when an origin is turned into eye space
constexpr float kTiny = 1e-36f;            // more than what underflow loses

dmat3 sizes_of(const dmat3& m) {
  return {glm::abs(m[0]), glm::abs(m[1]), glm::abs(m[2])};
}

void set(float (&form)[4], const dvec4& row) {
  for (int i = 0; i < 4; ++i) form[i] = float(row[i]);
}

}  // namespace

TriangleTest::TriangleTest(const core::View& view, const ImageSamples& samples)
    : eye_from_world_(view.eye_from_world()),
      world_from_eye_(glm::inverse(dmat3(eye_from_world_))),
      clip_rows_(glm::transpose(view.clip_from_eye())),
      width_(samples.width),
      height_(samples.height),
      snap_(samples.snap) {
  assert(samples.width > 0 && samples.height > 0);
  for (const auto& offset : samples.offsets) reach_ = std::max({reach_, std::abs(offset[0]), std::abs(offset[1])});
}

TriangleView TriangleTest::of(const core::Affine& world_from_mesh, bool fronts_alone) const {
  const dmat3 eye_from_world(eye_from_world_), linear = eye_from_world * world_from_mesh.linear;
  const dvec3 origin(eye_from_world_ * dvec4(world_from_mesh.origin, 1.0));
  const dmat3 sizes = sizes_of(eye_from_world) * sizes_of(world_from_mesh.linear);
  const dvec3 farther =
      sizes_of(eye_from_world) * glm::abs(world_from_mesh.origin) + glm::abs(dvec3(eye_from_world_[3]));
  const dvec3 turned = sizes_of(eye_from_world) * glm::abs(world_from_eye_ * origin);
  const dvec3 early = kLostInPairs * farther + kLostInTurning * turned;
  const auto form = [&](int row) {
    const dvec3 of_eye(clip_rows_[row]);
    return dvec4(of_eye * linear, glm::dot(of_eye, origin) + clip_rows_[row].w);
  };
  const auto lost = [&](int row) {
    const dvec3 of_eye = glm::abs(dvec3(clip_rows_[row]));
    const double constant = glm::dot(of_eye, glm::abs(origin)) + std::abs(clip_rows_[row].w);
    return kLost * dvec4(of_eye * sizes, constant) + dvec4(0.0, 0.0, 0.0, glm::dot(of_eye, early));
  };
  const dvec4 w = form(3), lost_w = lost(3);
  // Pixel centres at integers: 0.5 size (x / w + 1) - 0.5.
  const auto place = [&](int axis, double size) { return 0.5 * size * form(axis) + (0.5 * size - 0.5) * w; };
  TriangleView view{};
  set(view.x, place(0, width_));
  set(view.y, place(1, height_));
  set(view.w, w);
  set(view.lost_place, 0.5 * std::max(width_, height_) * (glm::max(lost(0), lost(1)) + lost_w));
  set(view.lost_w, lost_w);
  view.lost_place[3] += kTiny, view.lost_w[3] += kTiny;
  view.last_x = float(width_ - 1.0), view.last_y = float(height_ - 1.0);
  view.reach = reach_, view.snap = snap_;
  view.fronts_alone = fronts_alone;
  return view;
}

std::size_t TriangleTest::filter(const TriangleView& view, std::span<const core::vec3> positions,
                                 std::span<const std::uint32_t> indices, std::uint32_t* shown) {
  static_assert(sizeof(core::vec3) == 3 * sizeof(float));
  return occlusion_kernels().shown_triangles(view, &positions[0].x, indices.data(), indices.size() / 3, shown);
}

}  // namespace sightline::culling
