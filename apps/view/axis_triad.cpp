#include "sightline/apps/view/axis_triad.h"

#include <algorithm>

namespace sightline::apps {
namespace {

constexpr double kLength = 36.0, kEndRadius = 9.0, kRim = 5.0;  // pixels
constexpr double kFacing = 0.9999;                              // depth of an end that is looked from

}  // namespace

AxisTriad::AxisTriad(const core::Pose& pose, const core::dvec2& centre, double scale) : centre_(centre), scale_(scale) {
  const core::dvec3 ahead = glm::normalize(pose.target - pose.eye);
  core::dvec3 right = glm::cross(ahead, pose.up);
  if (glm::length(right) == 0.0) right = core::dvec3(1.0, 0.0, 0.0);
  right = glm::normalize(right);
  const core::dvec3 up = glm::cross(right, ahead);
  for (int i = 0; i < 6; ++i) {
    const int axis = i / 2;
    const double sign = i % 2 == 0 ? 1.0 : -1.0;
    ends_[std::size_t(i)] = {axis, sign > 0.0, centre + sign * kLength * scale * core::dvec2(right[axis], -up[axis]),
                             -sign * ahead[axis]};
  }
  std::stable_sort(ends_.begin(), ends_.end(), [](const End& a, const End& b) { return a.depth < b.depth; });
}

double AxisTriad::reach(double scale) {
  return (kLength + kEndRadius + kRim) * scale;
}

double AxisTriad::end_radius() const {
  return kEndRadius * scale_;
}

std::optional<AxisTriad::End> AxisTriad::end_at(const core::dvec2& point) const {
  for (auto end = ends_.rbegin(); end != ends_.rend(); ++end)
    if (glm::length(point - end->at) <= end_radius()) return *end;
  return std::nullopt;
}

const char* AxisTriad::view_from(const End& end) {
  constexpr const char* kViews[3][2] = {{"left", "right"}, {"front", "back"}, {"bottom", "top"}};
  return kViews[end.axis][end.positive != (end.depth > kFacing)];
}

}  // namespace sightline::apps
