// Views as calls of the JavaScript package take them: sixteen numbers in columns each.
#pragma once

#include <algorithm>
#include <array>

#include <glm/gtc/type_ptr.hpp>

#include "records.h"
#include "sightline/core/aabb.h"
#include "sightline/core/view.h"

namespace sightline::tests {

inline std::span<const double> numbers_of(const core::dmat4& matrix) {
  return {glm::value_ptr(matrix), 16};
}
inline std::span<const double> numbers_of(std::span<const core::AabbD> boxes) {
  return {reinterpret_cast<const double*>(boxes.data()), 6 * boxes.size()};
}
inline std::span<const core::AabbD> boxes_of(const std::vector<double>& numbers) {
  return {reinterpret_cast<const core::AabbD*>(numbers.data()), numbers.size() / 6};
}

/// Depths of 0 to 1 from reversed ones, and back.
inline core::dmat4 turned_depth(core::dmat4 clip) {
  for (int column = 0; column < 4; ++column) clip[column][2] = clip[column][3] - clip[column][2];
  return clip;
}

inline void write_view(RecordWriter& out, const core::View& view, int width = 1, int height = 1) {
  out.array(numbers_of(view.eye_from_world()));
  out.array(numbers_of(view.clip_from_eye()));
  std::vector<double> planes;
  for (const core::Plane& plane : view.sections)
    planes.insert(planes.end(), {plane.normal.x, plane.normal.y, plane.normal.z, plane.offset});
  out.numbers({double(view.clip_depth()), double(width), double(height),
               view.section_mode == core::SectionMode::kUnion ? 1.0 : 0.0});
  out.array(planes);
}
/// Reads what write_view() wrote. None where the file ends.
inline std::optional<core::View> read_view(RecordReader& in) {
  const auto eye = in.array<double>(), clip = in.array<double>(), rest = in.array<double>(),
             planes = in.array<double>();
  if (eye.size() != 16 || clip.size() != 16 || rest.size() != 4) return std::nullopt;
  auto view =
      core::View::from_matrices(glm::make_mat4(eye.data()), glm::make_mat4(clip.data()), core::ClipDepth(int(rest[0])));
  if (!view) return std::nullopt;
  for (std::size_t i = 0; i + 4 <= planes.size(); i += 4)
    view->sections.push_back({{planes[i], planes[i + 1], planes[i + 2]}, planes[i + 3]});
  view->section_mode = rest[3] != 0.0 ? core::SectionMode::kUnion : core::SectionMode::kIntersection;
  return *view;
}

}  // namespace sightline::tests
