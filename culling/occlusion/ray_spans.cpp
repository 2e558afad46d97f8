#include "sightline/culling/occlusion/detail/ray_spans.h"

#include <algorithm>
#include <cmath>

namespace sightline::culling {
namespace {

using core::dvec3;
using core::dvec4;

constexpr double kRounding = 0x1p-19;     // of a function's value in float, of the sizes of its terms
constexpr double kSumRounding = 0x1p-48;  // of sums of products in double
constexpr double kAlike = 0x1p-30;        // distances and the projection's w differ by no more than this share
/// Shares of the viewing direction below which a parallel ray stays in one slab, as far as it matters. The rectangle
/// bounds the box along such an axis.
constexpr double kAlong = 1e-3;
constexpr float kLargestKey = 1e30f;

double sizes_of(const dvec4& form, const dvec3& at) {
  return std::abs(form.x * at.x) + std::abs(form.y * at.y) + std::abs(form.z * at.z) + std::abs(form.w);
}

/// The form relative to an origin.
dvec4 moved(const dvec4& form, const dvec3& origin) {
  return {form.x, form.y, form.z, form.w + glm::dot(dvec3(form), origin)};
}

}  // namespace

/// The projection relative to the bounds' origin: a point is at x / w, y / w in the image.
struct RaySpans::Projection {
  dvec4 x, y, w, distance;
  dvec3 lost;  // by the constant terms of x, y and w
  double lost_distance;
  int width, height;
};

RaySpans::RaySpans(const core::View& view, const dvec3& origin, int width, int height)
    : parallel_(view.orthographic()) {
  const core::dmat4 clip = glm::transpose(view.clip_from_world()), eye = glm::transpose(view.eye_from_world());
  const auto place = [&](int axis, int size) { return 0.5 * size * clip[axis] + (0.5 * size - 0.5) * clip[3]; };
  const dvec4 x = place(0, width), y = place(1, height), w = clip[3], t = -eye[2];
  const dvec3 lost = kSumRounding * dvec3(sizes_of(x, origin), sizes_of(y, origin), sizes_of(w, origin));
  const Projection projection{moved(x, origin),
                              moved(y, origin),
                              moved(w, origin),
                              moved(t, origin),
                              lost,
                              kSumRounding * sizes_of(t, origin),
                              width,
                              height};
  usable_ = parallel_ ? trace_parallel(projection) : trace_from_eye(projection);
}

RayField RaySpans::field(float x, float y) const {
  RayField field{};
  field.parallel = parallel_;
  for (int i = 0; i < 3; ++i) {
    const Axis& a = axes_[i];
    const double constant = a.constant + (double(x) * a.x + double(y) * a.y);
    field.constant[i] = float(constant), field.per_x[i] = float(a.x), field.per_y[i] = float(a.y);
    field.from[i] = float(a.from), field.along[i] = float(a.along);
    field.constant_rest[i] = float(constant - double(field.constant[i]));
    field.from_rest[i] = float(a.from - double(field.from[i]));
    field.error[i] = float(a.error);
    field.grown[i] = float(a.grown + 0x1p-46 * (std::abs(a.from) + std::abs(constant)));
  }
  return field;
}

/// All rays have the direction in which neither x nor y change.
bool RaySpans::trace_parallel(const Projection& p) {
  const dvec3 x(p.x), y(p.y), t(p.distance), across = glm::cross(x, y);
  const double square = glm::dot(across, across), rate = glm::dot(t, across);
  if (!(square > 0.0) || !(std::abs(rate) > kAlike * glm::length(t) * glm::length(across))) return false;
  const dvec3 along = across / rate, per_x = glm::cross(y, across) / square, per_y = glm::cross(across, x) / square;
  // Moves a point along its ray to distance 0; `constant`: the part of its distance that t does not give.
  const auto at_start = [&](const dvec3& point, double constant) {
    return point - along * (glm::dot(t, point) + constant);
  };
  const dvec3 constant = at_start(-p.x.w * per_x - p.y.w * per_y, p.distance.w);
  const dvec3 slope_x = at_start(p.w.w * per_x, 0.0), slope_y = at_start(p.w.w * per_y, 0.0);
  const double off = 16.0 * (kSumRounding * glm::length(constant) + glm::length(per_x) * p.lost.x +
                             glm::length(per_y) * p.lost.y + p.lost_distance);
  for (int i = 0; i < 3; ++i) {
    const double moves = 2.0 * (std::abs(slope_x[i]) * p.width + std::abs(slope_y[i]) * p.height);
    axes_[i] = {constant[i], slope_x[i], slope_y[i], kRounding * moves, 0.0, along[i], off};
  }
  return true;
}

/// A ray is where x = (pixel's x) w and y = (pixel's y) w. Its direction is the cross product of the gradients of both
/// differences, which is linear in the pixel's place. It is scaled such that the distance grows by 1.
bool RaySpans::trace_from_eye(const Projection& p) {
  const dvec3 x(p.x), y(p.y), w(p.w), t(p.distance);
  const dvec3 direction = glm::cross(x, y), per_x = glm::cross(y, w), per_y = glm::cross(w, x);
  const double ratio = glm::dot(t, w) / glm::dot(w, w);  // of distances to w
  const double apart = std::abs(p.distance.w - ratio * p.w.w);
  if (!(glm::length(t - ratio * w) <= kAlike * glm::length(t)) || !(ratio > 0.0)) return false;
  if (!(apart <= kAlike * (std::abs(p.distance.w) + glm::length(t)) + 4.0 * ratio * p.lost.z)) return false;
  if (!solve_eye(p)) return false;
  const double rate = ratio * glm::dot(w, direction);
  double greatest = 0.0;
  for (int i = 0; i < 3; ++i) {
    Axis& axis = axes_[i];
    axis.constant = direction[i] / rate, axis.x = per_x[i] / rate, axis.y = per_y[i] / rate;
    axis.error = std::abs(axis.constant) + 2.0 * (std::abs(axis.x) * p.width + std::abs(axis.y) * p.height);
    greatest = std::max(greatest, axis.error);
  }
  for (Axis& axis : axes_) axis.error = kRounding * axis.error + kAlike * greatest;
  return std::isfinite(greatest);
}

/// The point where all three forms vanish, and what its coordinates are off by.
bool RaySpans::solve_eye(const Projection& p) {
  const dvec4 forms[3] = {p.x, p.y, p.w};
  const core::dmat3 columns{dvec3(forms[0]), dvec3(forms[1]), dvec3(forms[2])};
  const core::dmat3 inverse = glm::inverse(glm::transpose(columns));
  const dvec3 eye = inverse * -dvec3(forms[0].w, forms[1].w, forms[2].w);
  dvec3 residual;
  for (int i = 0; i < 3; ++i)
    residual[i] =
        std::abs(glm::dot(dvec3(forms[i]), eye) + forms[i].w) + p.lost[i] + kSumRounding * sizes_of(forms[i], eye);
  for (int i = 0; i < 3; ++i) {
    double off = 0.0;
    for (int k = 0; k < 3; ++k) off += std::abs(inverse[k][i]) * residual[k];
    axes_[i].from = eye[i];
    axes_[i].grown = 2.0 * off;
    if (!std::isfinite(eye[i] + off)) return false;
  }
  return true;
}

/// The function per_value * (the axis's function) + constant, moved by `widen` of the axis's error.
void RaySpans::add(double per_value, double constant, int axis, double widen, ImageFunction& out) const {
  const Axis& a = axes_[axis];
  const double lost = widen * (std::abs(per_value) * a.error + 0x1p-22 * std::abs(constant + per_value * a.constant));
  out = {float(constant + per_value * a.constant + lost), float(per_value * a.x), float(per_value * a.y)};
}

void RaySpans::span_of_axis(int axis, double low, double high, BoxSpan& out) const {
  const Axis& a = axes_[axis];
  const double drawn_off = 0x1p-19 + 0x1p-23 * std::max(std::abs(low), std::abs(high)) + 0x1p-21 * (high - low);
  const double grown = drawn_off + a.grown + 0x1p-50 * std::abs(a.from);
  low -= grown, high += grown;
  ImageFunction* near = &out.near[out.near_count];
  ImageFunction* far = &out.far[out.far_count];
  if (parallel_) {
    if (std::abs(a.along) < kAlong) return;
    const double per_value = 1.0 / a.along, first = a.along > 0.0 ? low : high, last = a.along > 0.0 ? high : low;
    add(per_value, -first * per_value, axis, 1.0, *near);
    add(per_value, -last * per_value, axis, -1.0, *far);
    ++out.near_count, ++out.far_count;
    return;
  }
  low -= a.from, high -= a.from;
  const double tiny = 1e-9 * (high - low);  // a face so near to the eye bounds nothing
  if (low > tiny || -high > tiny) {
    const double first = low > 0.0 ? low : high, last = low > 0.0 ? high : low;
    add(1.0 / first, 0.0, axis, 1.0, *near);
    add(1.0 / last, 0.0, axis, -1.0, *far);
    ++out.near_count, ++out.far_count;
    return;
  }
  for (const double face : {low, high}) {
    if (!(std::abs(face) > tiny)) continue;
    add(1.0 / face, 0.0, axis, -1.0, out.far[out.far_count++]);
  }
}

bool RaySpans::span(const BoxCoordinates& box, BoxSpan& out) const {
  out.near_count = out.far_count = 0;
  if (!usable_) return false;
  for (int axis = 0; axis < 3; ++axis) span_of_axis(axis, double(box[axis]), double(box[axis + 3]), out);
  if (out.near_count == 0 || out.far_count == 0) return false;
  for (int i = 0; i < out.near_count; ++i)
    if (!(std::abs(out.near[i].constant) < kLargestKey)) return false;
  for (int i = 0; i < out.far_count; ++i)
    if (!(std::abs(out.far[i].constant) < kLargestKey)) return false;
  return true;
}

}  // namespace sightline::culling
