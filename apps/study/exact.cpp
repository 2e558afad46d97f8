#include "sightline/apps/study/exact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace sightline::study {
namespace {

using core::dvec3;

/// A bounded frustum: corners, and the axes along which it may be separated from a box.
class Frustum {
 public:
  Frustum(const core::View& view, const std::array<core::Plane, core::kFrustumPlaneCount>& planes) {
    const core::dmat4 world = glm::inverse(view.clip_from_world());
    const double near = core::near_depth(view.clip_depth()), far = core::far_depth(view.clip_depth());
    bounded_ = true;
    for (const core::Plane& p : planes) bounded_ &= glm::length(p.normal) > 0.0;
    for (int i = 0; i < 8; ++i) {
      const double depth = (i & 4) != 0 ? std::max(near, far) : std::min(near, far);
      const core::dvec4 h = world * core::dvec4((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0, depth, 1.0);
      corners_[std::size_t(i)] = dvec3(h) / h.w;
      for (int axis = 0; axis < 3; ++axis) bounded_ &= std::isfinite(corners_[std::size_t(i)][axis]);
    }
    if (!bounded_) return;
    std::size_t n = 0;
    for (const core::Plane& p : planes) axes_[n++] = glm::normalize(p.normal);
    for (int i = 0; i < 3; ++i) axes_[n++][i] = 1.0;
    const std::array<dvec3, 6> edges{corners_[4] - corners_[0], corners_[5] - corners_[1], corners_[6] - corners_[2],
                                     corners_[7] - corners_[3], corners_[1] - corners_[0], corners_[2] - corners_[0]};
    for (const dvec3& edge : edges) {
      for (int i = 0; i < 3; ++i) {
        dvec3 unit(0.0);
        unit[i] = 1.0;
        const dvec3 axis = glm::cross(glm::normalize(edge), unit);
        if (glm::length(axis) > 1e-6) axes_[n++] = glm::normalize(axis);
      }
    }
    count_ = n;
    for (std::size_t i = 0; i < count_; ++i) {
      low_[i] = std::numeric_limits<double>::infinity();
      high_[i] = -low_[i];
      for (const dvec3& c : corners_) {
        low_[i] = std::min(low_[i], glm::dot(axes_[i], c));
        high_[i] = std::max(high_[i], glm::dot(axes_[i], c));
      }
    }
  }

  bool meets(const core::Aabb& box, double tolerance) const {
    if (!bounded_) return true;
    const dvec3 centre = 0.5 * (dvec3(box.min) + dvec3(box.max)), half = dvec3(box.max) - centre;
    for (std::size_t i = 0; i < count_; ++i) {
      const double middle = glm::dot(axes_[i], centre), reach = glm::dot(glm::abs(axes_[i]), half) + tolerance;
      if (middle + reach < low_[i] || middle - reach > high_[i]) return false;
    }
    return true;
  }

 private:
  bool bounded_ = false;
  std::array<dvec3, 8> corners_;
  std::array<dvec3, 27> axes_{};
  std::array<double, 27> low_{}, high_{};
  std::size_t count_ = 0;
};

std::uint64_t not_in(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
  std::uint64_t n = 0;
  std::size_t k = 0;
  for (const std::uint32_t id : a) {
    while (k < b.size() && b[k] < id) ++k;
    if (k == b.size() || b[k] != id) ++n;
  }
  return n;
}

}  // namespace

ExactSets::ExactSets(std::span<const core::Aabb> boxes, const core::View& view) {
  const auto planes = core::frustum_planes(view.clip_from_world(), view.clip_depth());
  const Frustum frustum(view, planes);
  core::Aabb all;
  for (const core::Aabb& b : boxes) all.grow(b);
  const double tolerance = all.empty() ? 0.0 : 1e-9 * glm::length(dvec3(all.max) - dvec3(all.min));
  for (std::uint32_t id = 0; id < boxes.size(); ++id) {
    const dvec3 lo(boxes[id].min), hi(boxes[id].max);
    bool visible = true, inside = true;
    for (const core::Plane& p : planes) {
      const dvec3 a = p.normal * lo, b = p.normal * hi;
      const dvec3 high = glm::max(a, b), low = glm::min(a, b);
      visible &= high.x + high.y + high.z + p.offset >= 0.0;
      inside &= low.x + low.y + low.z + p.offset >= 0.0;
    }
    if (!visible) continue;
    p_vertex_.push_back(id);
    if (inside || frustum.meets(boxes[id], tolerance)) meeting_.push_back(id);
  }
}

Errors compare(const std::vector<std::uint32_t>& answer, const ExactSets& exact) {
  return {answer.size(), not_in(answer, exact.p_vertex()), not_in(exact.p_vertex(), answer),
          not_in(answer, exact.meeting()), not_in(exact.meeting(), answer)};
}

}  // namespace sightline::study
