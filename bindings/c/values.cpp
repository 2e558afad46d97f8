#include "sightline/bindings/c/internal/values.h"

#include <cmath>

#include <glm/gtc/type_ptr.hpp>

namespace sightline::capi {

void check_text(const sl_text* text) {
  require(text != nullptr, "a text to write to, found null");
  check_buffer(text->data, text->capacity);
}

void write_text(sl_text* text, std::string_view from) {
  if (text->capacity > 0) {
    const std::size_t fits = std::min(text->capacity - 1, from.size());
    if (fits > 0) std::memcpy(text->data, from.data(), fits);
    text->data[fits] = '\0';
  }
  text->length = from.size();
}

std::string_view required_text(const char* text) {
  require(text != nullptr, "a text, found null");
  return text;
}

std::filesystem::path path_of(const char* path) {
  const std::string_view text = required_text(path);
  return std::filesystem::path(std::u8string(text.begin(), text.end()));
}

core::Affine affine_of(const double* matrix) {
  if (!matrix) return {};
  const core::dmat4 m = glm::make_mat4(matrix);
  require(m[0][3] == 0.0 && m[1][3] == 0.0 && m[2][3] == 0.0 && m[3][3] == 1.0, "a matrix whose last row is 0 0 0 1");
  return {core::dmat3(m), core::dvec3(m[3])};
}

void write_affine(const core::Affine& from, double matrix[16]) {
  core::dmat4 m(from.linear);
  m[3] = core::dvec4(from.origin, 1.0);
  std::memcpy(matrix, glm::value_ptr(m), 16 * sizeof(double));
}

core::dvec3 vector_of(const double vector[3]) {
  require(vector != nullptr, "three numbers, found null");
  return glm::make_vec3(vector);
}

core::dvec3 short_vector_of(const double vector[3]) {
  const core::dvec3 given = vector_of(vector);
  for (int i = 0; i < 3; ++i) require(std::abs(given[i]) < 1e150, "components of points and rays below 1e150");
  return given;
}

core::AabbD box_of(const sl_box& box) {
  return {vector_of(box.min), vector_of(box.max)};
}
sl_box box_of(const core::AabbD& box) {
  return {{box.min.x, box.min.y, box.min.z}, {box.max.x, box.max.y, box.max.z}};
}

core::Plane plane_of(const sl_plane& plane) {
  const core::Plane made{vector_of(plane.normal), plane.offset};
  require(core::is_finite(made.normal) && std::isfinite(made.offset), "planes of finite numbers");
  return made;
}

core::View view_of(const sl_view* from) {
  const sl_view c = read(from, sl_view SL_VIEW_INIT);
  core::View view =
      value_of(core::View::from_matrices(glm::make_mat4(c.eye_from_world), glm::make_mat4(c.clip_from_eye),
                                         enum_of<core::ClipDepth>(c.clip_depth, 3, "clip_depth")));
  view.layers = c.layers;
  view.section_mode = enum_of<core::SectionMode>(c.section_mode, 2, "section_mode");
  require(c.section_count <= SL_MAX_SECTIONS, "at most SL_MAX_SECTIONS sections");
  for (std::size_t i = 0; i < c.section_count; ++i) view.sections.push_back(plane_of(c.sections[i]));
  return view;
}

std::function<bool(double)> progress_of(std::int32_t (*progress)(double share, void* user), void* user) {
  if (!progress) return {};
  return [progress, user](double share) {
    try {
      return progress(share, user) != 0;
    } catch (...) {
      return false;
    }
  };
}

}  // namespace sightline::capi
