#include "sightline/culling/occlusion/detail/screen_view.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

namespace sightline::culling {
namespace {

LinearForm form_of(const core::dvec4& row, const core::dvec3& origin) {
  const core::dvec3 products = core::dvec3(row) * origin;
  const double d = products.x + products.y + products.z + row.w;
  const core::dvec3 sizes = glm::abs(products);
  const double lost = 0x1p-50 * (sizes.x + sizes.y + sizes.z + std::abs(row.w));
  return {float(row.x), float(row.y), float(row.z), float(d), float(lost)};
}

/// -1, which no coordinate's size is below, where the forms are not finite.
float largest_coordinate(std::initializer_list<LinearForm> forms) {
  constexpr float kMost = 1e36f;
  float greatest = 1.0f;
  for (const LinearForm& f : forms) {
    for (const float c : {f.x, f.y, f.z}) greatest = std::max(greatest, std::abs(c));
    if (!(std::abs(f.x) + std::abs(f.y) + std::abs(f.z) + std::abs(f.d) + f.error < kMost)) return -1.0f;
  }
  return kMost / greatest;
}

}  // namespace

ScreenView make_screen_view(const core::View& view, const core::dvec3& origin, int width, int height, float snap) {
  const core::dmat4 clip = glm::transpose(view.clip_from_world()), eye = glm::transpose(view.eye_from_world());
  // Pixel centres at integers: 0.5 size (ndc + 1) - 0.5.
  const auto place = [&](int axis, int size) { return 0.5 * size * clip[axis] + (0.5 * size - 0.5) * clip[3]; };
  ScreenView screen{};
  screen.x = form_of(place(0, width), origin);
  screen.y = form_of(place(1, height), origin);
  screen.w = form_of(clip[3], origin);
  screen.t = form_of(-eye[2], origin);
  screen.snap = snap;
  screen.last_x = float(width - 1);
  screen.last_y = float(height - 1);
  screen.largest = largest_coordinate({screen.x, screen.y, screen.w, screen.t});
  // The cross product of the gradients of x / w and y / w: it points along the ray, and its length is the factor.
  const core::dvec3 x(place(0, width)), y(place(1, height)), w(clip[3]);
  const core::dvec3 products[3] = {glm::cross(x, y), glm::cross(y, w), glm::cross(w, x)};
  for (int i = 0; i < 3; ++i)
    for (int axis = 0; axis < 3; ++axis) screen.facing[i][axis] = float(products[i][axis]);
  return screen;
}

}  // namespace sightline::culling
