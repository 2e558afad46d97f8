#include "sightline/apps/study/camera.h"

#include <algorithm>
#include <cmath>

namespace sightline::study {
namespace {

constexpr double kUnitFloat = 0x1p-24;

void set(float (&to)[3], const core::dvec3& from) {
  for (int i = 0; i < 3; ++i) to[i] = float(from[i]);
}

/// A float test errs by at most gamma_5(2^-24) (sum |n_i| M_i + |d|), M being the largest coordinates (derivation in
/// culling/frustum/frustum_test.cpp); 8 instead of 5 covers the other orders of addition and the double steps before.
Plane float_plane(const core::dvec3& n, double d, const core::dvec3& largest) {
  Plane p;
  set(p.n, n);
  const double reach = glm::dot(glm::abs(n), largest) + std::abs(d);
  const double band = 8.0 * kUnitFloat * reach + 1e-30;
  p.out = core::round_up(d + band);
  p.in = core::round_down(d - band);
  return p;
}

Plane constant_plane(bool rejects) {
  const float value = rejects ? -1.0f : 1.0f;
  return {{0.0f, 0.0f, 0.0f}, value, value};
}

void split_by_sign(const std::array<Plane, kPlanes>& planes, SplitPlanes& s) {
  for (std::size_t k = 0; k < 8; ++k) {
    const Plane p = k < planes.size() ? planes[k] : constant_plane(false);
    for (int axis = 0; axis < 3; ++axis) {
      s.positive[axis][k] = std::max(p.n[axis], 0.0f);
      s.negative[axis][k] = std::min(p.n[axis], 0.0f);
    }
    s.out[k] = p.out;
    s.in[k] = p.in;
  }
}

/// Whether this is a projection of a perspective view about its axis.
bool symmetric(const core::dmat4& p) {
  return p[0][3] == 0.0 && p[1][3] == 0.0 && p[2][3] == -1.0 && p[2][0] == 0.0 && p[2][1] == 0.0 && p[3][0] == 0.0 &&
         p[3][1] == 0.0 && p[1][0] == 0.0 && p[0][1] == 0.0;
}

}  // namespace

Camera::Camera(const core::View& view, const core::Aabb& extent) {
  const core::dmat4 clip = view.clip_from_world();
  const auto exact = core::frustum_planes(clip, view.clip_depth());
  const core::dvec3 largest = extent.empty()
                                  ? core::dvec3(0.0)
                                  : glm::max(glm::abs(core::dvec3(extent.min)), glm::abs(core::dvec3(extent.max)));
  eye = view.eye();
  bool complete = true;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    const double length = glm::length(exact[k].normal);
    if (!(length > 0.0) || !std::isfinite(length) || !std::isfinite(exact[k].offset / length)) {
      planes[k] = constant_plane(length == 0.0 && exact[k].offset < 0.0);
      normals[k] = core::dvec3(0.0);
      eye_heights[k] = 0.0;
      complete = false;
      continue;
    }
    normals[k] = exact[k].normal / length;
    const double d = exact[k].offset / length;
    planes[k] = float_plane(normals[k], d, largest);
    eye_heights[k] = glm::dot(normals[k], eye) + d;
  }
  split_by_sign(planes, split);
  for (std::size_t pair = 0; pair < 3; ++pair) {
    const Plane &a = planes[2 * pair], &b = planes[2 * pair + 1];
    for (int i = 0; i < 3; ++i) middles[pair][i] = a.n[i] - b.n[i];
    middles[pair][3] = a.out - b.out;
  }
  set_corners(view, complete);
  set_radar(view);
}

void Camera::set_corners(const core::View& view, bool complete) {
  const core::dmat4 world = glm::inverse(view.clip_from_world());
  const double near = core::near_depth(view.clip_depth()), far = core::far_depth(view.clip_depth());
  core::AabbD box;
  core::dvec3 centre(0.0);
  for (int i = 0; i < 8 && complete; ++i) {
    const double depth = (i & 4) != 0 ? std::max(near, far) : std::min(near, far);
    const core::dvec4 h = world * core::dvec4((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0, depth, 1.0);
    const core::dvec3 corner = core::dvec3(h) / h.w;
    complete = std::isfinite(corner.x) && std::isfinite(corner.y) && std::isfinite(corner.z) && std::abs(h.w) > 0.0;
    box.grow(corner);
    centre += corner / 8.0;
  }
  has_corners = complete;
  bounds = {{-core::Aabb::kFar, -core::Aabb::kFar, -core::Aabb::kFar},
            {core::Aabb::kFar, core::Aabb::kFar, core::Aabb::kFar}};
  if (complete) {
    const double margin = 1e-7 * (glm::length(box.size()) + glm::length(eye));
    for (int i = 0; i < 3; ++i) {
      bounds.lo[i] = core::round_down(box.min[i] - margin);
      bounds.hi[i] = core::round_up(box.max[i] + margin);
    }
    octant_radius = core::Aabb::kFar;
    for (std::size_t k = 0; k < normals.size(); ++k)
      octant_radius = std::min(octant_radius, float(glm::dot(normals[k], centre - eye) + eye_heights[k]));
  }
}

void Camera::set_radar(const core::View& view) {
  const core::dmat4& eye_from_world = view.eye_from_world();
  const auto axis = [&](int row) {
    return core::dvec3(eye_from_world[0][row], eye_from_world[1][row], eye_from_world[2][row]);
  };
  set(radar.eye, eye);
  set(radar.right, axis(0));
  set(radar.up, axis(1));
  set(radar.forward, -axis(2));
  const core::dmat4& projection = view.clip_from_eye();
  const auto in_eye = core::frustum_planes(projection, view.clip_depth());
  radar.near = float(in_eye[core::kNear].offset / in_eye[core::kNear].normal.z);
  radar.far = float(in_eye[core::kFar].offset / in_eye[core::kFar].normal.z);
  radar.slope_x = float(1.0 / projection[0][0]);
  radar.slope_y = float(1.0 / projection[1][1]);
  // A view given as one matrix has its camera in there, too: no axes to be had.
  radar_usable = has_corners && symmetric(projection);
}

}  // namespace sightline::study
