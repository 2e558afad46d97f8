#include "sightline/core/view.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "sightline/core/fitting.h"
#include "sightline/core/internal/visible_box.h"

namespace sightline::core {
namespace {

bool finite(const dmat4& m) {
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r)
      if (!std::isfinite(m[c][r])) return false;
  return true;
}

dvec4 row(const dmat4& m, int r) {
  return {m[0][r], m[1][r], m[2][r], m[3][r]};
}

/// An axis that is surely not parallel to `direction`.
dvec3 other_axis(const dvec3& direction) {
  const dvec3 a = glm::abs(direction);
  return a.z <= a.x && a.z <= a.y ? dvec3(0, 0, 1) : a.y <= a.x ? dvec3(0, 1, 0) : dvec3(1, 0, 0);
}

dvec4 scaled(const dvec4& v) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z), std::abs(v.w)});
  return largest > 0.0 ? v / largest : v;
}

/// Returns 1 where depth grows with the distance from the eye, -1 where it falls, and 0 where the matrix does not tell.
/// A parallel projection that is combined with the eye's matrix never tells: a mirrored one may look the other way.
int depth_trend(const dmat4& clip_from_eye, bool combined) {
  constexpr double kDoubt = 1e-6;  // relative error of matrices that were multiplied in float
  const dvec4 z = scaled(row(clip_from_eye, 2)), w = scaled(row(clip_from_eye, 3));
  const bool parallel = dvec3(w) == dvec3(0.0);
  if (parallel && (combined || !(w.w > 0.0))) return 0;
  const dvec3 ahead = parallel ? dvec3(0.0, 0.0, -1.0) : dvec3(w);
  if (!(glm::length(glm::cross(dvec3(z), ahead)) <= kDoubt * glm::length(dvec3(z)) * glm::length(ahead))) return 0;
  const double slope = glm::dot(dvec3(z), ahead) / glm::dot(ahead, ahead);
  if (parallel) return slope > 0.0 ? 1 : slope < 0.0 ? -1 : 0;
  const double rest = z.w - slope * w.w;  // z = slope * w + rest, so depth = slope + rest / w
  if (!(std::abs(rest) > kDoubt * (std::abs(z.w) + std::abs(slope * w.w)))) return 0;
  return rest < 0.0 ? 1 : -1;
}

Expected<void> check_depth(const dmat4& clip_from_eye, bool combined, ClipDepth depth) {
  const bool grows = far_depth(depth) > near_depth(depth);
  if (depth_trend(clip_from_eye, combined) != (grows ? -1 : 1)) return {};
  if (grows)
    return fail(
        "view: depth falls with distance from the eye, but its ClipDepth says that it grows to 1 at the far plane");
  return fail("view: depth grows with distance from the eye, but its ClipDepth says that it falls from 1 to 0");
}

Expected<void> check_lens(double fovy, double aspect) {
  if (!(fovy > 0.0 && fovy < std::numbers::pi)) return fail("perspective view: fovy must lie between 0 and pi");
  if (!(aspect > 0.0) || !std::isfinite(aspect)) return fail("perspective view: aspect must be positive");
  return {};
}

}  // namespace

Expected<dmat4> look_at(const Pose& pose) {
  if (!is_finite(pose.eye) || !is_finite(pose.target) || !is_finite(pose.up))
    return fail("camera pose: eye, target and up must be finite");
  const dvec3 line = pose.target - pose.eye;
  const double distance = glm::length(line);
  if (!(distance > 0.0) || !std::isfinite(distance)) return fail("camera pose: eye and target must differ");
  const dvec3 forward = line / distance;
  const double largest = glm::max(glm::max(std::abs(pose.up.x), std::abs(pose.up.y)), std::abs(pose.up.z));
  dvec3 right = largest > 0.0 ? glm::cross(forward, pose.up / largest) : dvec3(0.0);  // no square over- or underflows
  // Below this the direction of `right` would be mostly rounding error.
  if (!(glm::length(right) > 1e-12)) right = glm::cross(forward, other_axis(forward));
  right = glm::normalize(right);
  // Where `up` nearly follows the line of sight, `right` has cancelled: a second step makes it perpendicular again.
  right = glm::normalize(right - glm::dot(right, forward) * forward);
  const dvec3 up = glm::cross(right, forward);
  dmat4 m(1.0);
  for (int i = 0; i < 3; ++i) {
    m[i][0] = right[i];
    m[i][1] = up[i];
    m[i][2] = -forward[i];
  }
  m[3] = dvec4(-glm::dot(right, pose.eye), -glm::dot(up, pose.eye), glm::dot(forward, pose.eye), 1.0);
  return m;
}

Pose fitting_pose(const AabbD& bounds, const dvec3& direction, double fovy, double aspect, double filled) {
  assert(check_lens(fovy, aspect));
  const AabbD box = visible_box(bounds);
  Fitting fitting(direction, fovy, aspect, filled, box.centre());
  fitting.add(box);
  return fitting.pose();
}

Expected<View> View::perspective(const Pose& pose, double fovy, double aspect, double near, double far) {
  if (auto lens = check_lens(fovy, aspect); !lens) return tl::unexpected(lens.error());
  const double top = near * std::tan(0.5 * fovy);
  return asymmetric(pose, -top * aspect, top * aspect, -top, top, near, far);
}

Expected<View> View::asymmetric(const Pose& pose, double left, double right, double bottom, double top, double near,
                                double far) {
  if (!(near > 0.0) || !std::isfinite(near) || !(far > near))
    return fail("perspective view: 0 < near < far must hold, near finite");
  if (!(left < right) || !(bottom < top) || !std::isfinite(right - left) || !std::isfinite(top - bottom))
    return fail("perspective view: left < right and bottom < top must hold");
  auto eye = look_at(pose);
  if (!eye) return tl::unexpected(eye.error());
  dmat4 clip(0.0);
  clip[0][0] = 2.0 * near / (right - left);
  clip[1][1] = 2.0 * near / (top - bottom);
  clip[2][0] = (right + left) / (right - left);
  clip[2][1] = (top + bottom) / (top - bottom);
  clip[2][3] = -1.0;
  // Reverse-Z: depth = near (far + z) / (-z (far - near)), which tends to near / -z as far grows.
  clip[2][2] = std::isfinite(far) ? near / (far - near) : 0.0;
  clip[3][2] = std::isfinite(far) ? near * (far / (far - near)) : near;
  return from_matrices(*eye, clip, ClipDepth::kReversedZeroToOne);
}

Expected<View> View::orthographic(const Pose& pose, double height, double aspect, double near, double far) {
  if (!(height > 0.0) || !(aspect > 0.0) || !std::isfinite(height) || !std::isfinite(aspect))
    return fail("orthographic view: height and aspect must be positive");
  if (!(near < far) || !std::isfinite(near) || !std::isfinite(far))
    return fail("orthographic view: near < far must hold, both finite");
  auto eye = look_at(pose);
  if (!eye) return tl::unexpected(eye.error());
  dmat4 clip(1.0);
  clip[0][0] = 2.0 / (height * aspect);
  clip[1][1] = 2.0 / height;
  clip[2][2] = 1.0 / (far - near);
  clip[3][2] = far / (far - near);
  return from_matrices(*eye, clip, ClipDepth::kReversedZeroToOne);
}

Expected<View> View::fit(const AabbD& bounds, const dvec3& direction, double fovy, double aspect, double filled) {
  constexpr double kNear = 1e-3;  // of the diagonal
  if (auto lens = check_lens(fovy, aspect); !lens) return tl::unexpected(lens.error());
  if (!bounds.empty() && !(is_finite(bounds.min) && is_finite(bounds.max)))
    return fail("fitted view: the bounds must be finite");
  if (!look_at({dvec3(0.0), direction, {0.0, 0.0, 1.0}}))
    return fail("fitted view: the direction must be finite and not zero");
  if (!(filled > 0.0 && filled <= 1.0)) return fail("fitted view: the box must fill more than 0 and at most all");
  const double near = kNear * glm::length(visible_box(bounds).size());
  return perspective(fitting_pose(bounds, direction, fovy, aspect, filled), fovy, aspect, near);
}

Expected<View> View::from_matrices(const dmat4& eye_from_world, const dmat4& clip_from_eye, ClipDepth depth) {
  if (!finite(eye_from_world) || !finite(clip_from_eye) || !finite(clip_from_eye * eye_from_world))
    return fail("view: matrix entries must be finite");
  if (row(eye_from_world, 3) != dvec4(0.0, 0.0, 0.0, 1.0))
    return fail(
        "view: eye_from_world must be affine, with the last row 0 0 0 1; give projection * view as clip_from_eye");
  const bool combined = eye_from_world == dmat4(1.0);
  if (auto fits = check_depth(clip_from_eye, combined, depth); !fits) return tl::unexpected(fits.error());
  return View(eye_from_world, clip_from_eye, depth);
}

dmat4 View::clip_from_world() const {
  return clip_from_eye_ * eye_from_world_;
}

dvec3 View::eye() const {
  return dvec3(glm::inverse(eye_from_world_)[3]);
}

bool same_image(const View& a, const View& b) {
  const auto same_plane = [](const Plane& p, const Plane& q) { return p.normal == q.normal && p.offset == q.offset; };
  return a.eye_from_world() == b.eye_from_world() && a.clip_from_eye() == b.clip_from_eye() &&
         a.clip_depth() == b.clip_depth() && a.section_mode == b.section_mode && a.layers == b.layers &&
         std::equal(a.sections.begin(), a.sections.end(), b.sections.begin(), b.sections.end(), same_plane);
}

std::array<Plane, kFrustumPlaneCount> frustum_planes(const dmat4& clip_from_world, ClipDepth depth) {
  const dvec4 x = row(clip_from_world, 0), y = row(clip_from_world, 1), z = row(clip_from_world, 2),
              w = row(clip_from_world, 3);
  const double near = near_depth(depth), far = far_depth(depth), sign = far > near ? 1.0 : -1.0;
  const std::array<dvec4, kFrustumPlaneCount> rows = {
      w + x, w - x, w + y, w - y, sign * (z - near * w), sign * (far * w - z)};
  std::array<Plane, kFrustumPlaneCount> planes;
  for (int i = 0; i < kFrustumPlaneCount; ++i) planes[i] = {dvec3(rows[i]), rows[i].w};
  return planes;
}

}  // namespace sightline::core
