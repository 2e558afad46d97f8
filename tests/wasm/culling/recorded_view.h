// Views as calls of the JavaScript package take them: sixteen numbers in columns each.
#pragma once

#include <algorithm>
#include <array>

#include <glm/gtc/type_ptr.hpp>

#include "records.h"
#include "sightline/core/aabb.h"
#include "sightline/core/view.h"

namespace sightline::tests {

/// How a test hands over its depth range. The library itself has no kZeroToOne: the package makes it reversed.
enum class RecordedDepth { kReversed, kMinusOneToOne, kZeroToOne };

inline std::span<const double> numbers_of(const core::dmat4& matrix) {
  return {glm::value_ptr(matrix), 16};
}
inline std::span<const double> numbers_of(std::span<const core::AabbD> boxes) {
  return {reinterpret_cast<const double*>(boxes.data()), 6 * boxes.size()};
}
inline std::span<const core::AabbD> boxes_of(const std::vector<double>& numbers) {
  return {reinterpret_cast<const core::AabbD*>(numbers.data()), numbers.size() / 6};
}

inline RecordedDepth depth_of(const core::View& view) {
  return view.clip_depth() == core::ClipDepth::kReversedZeroToOne ? RecordedDepth::kReversed
                                                                  : RecordedDepth::kMinusOneToOne;
}
/// Depths of 0 to 1 from reversed ones, and back.
inline core::dmat4 turned_depth(core::dmat4 clip) {
  for (int column = 0; column < 4; ++column) clip[column][2] = clip[column][3] - clip[column][2];
  return clip;
}

inline void write_view(RecordWriter& out, const core::dmat4& eye, const core::dmat4& clip, RecordedDepth depth,
                       int width, int height, const core::View& sections) {
  out.array(numbers_of(eye));
  out.array(numbers_of(clip));
  std::vector<double> planes;
  for (const core::Plane& plane : sections.sections)
    planes.insert(planes.end(), {plane.normal.x, plane.normal.y, plane.normal.z, plane.offset});
  out.numbers(
      {double(depth), double(width), double(height), sections.section_mode == core::SectionMode::kUnion ? 1.0 : 0.0});
  out.array(planes);
}
inline void write_view(RecordWriter& out, const core::View& view) {
  write_view(out, view.eye_from_world(), view.clip_from_eye(), depth_of(view), 1, 1, view);
}
/// Of write_view(). None where the file ends.
inline std::optional<core::View> read_view(RecordReader& in) {
  const auto eye = in.array<double>(), clip = in.array<double>(), rest = in.array<double>(),
             planes = in.array<double>();
  if (eye.size() != 16 || clip.size() != 16 || rest.size() != 4) return std::nullopt;
  const auto depth = RecordedDepth(int(rest[0]));
  core::dmat4 matrix = glm::make_mat4(clip.data());
  if (depth == RecordedDepth::kZeroToOne) matrix = turned_depth(matrix);
  auto view = core::View::from_matrices(
      glm::make_mat4(eye.data()), matrix,
      depth == RecordedDepth::kMinusOneToOne ? core::ClipDepth::kMinusOneToOne : core::ClipDepth::kReversedZeroToOne);
  if (!view) return std::nullopt;
  for (std::size_t i = 0; i + 4 <= planes.size(); i += 4)
    view->sections.push_back({{planes[i], planes[i + 1], planes[i + 2]}, planes[i + 3]});
  view->section_mode = rest[3] != 0.0 ? core::SectionMode::kUnion : core::SectionMode::kIntersection;
  return *view;
}

}  // namespace sightline::tests
