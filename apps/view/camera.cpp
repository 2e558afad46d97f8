#include "sightline/apps/view/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "sightline/core/fitting.h"

namespace sightline::apps {
namespace {

constexpr double kSteepest = 0.995 * std::numbers::pi / 2;  // looking straight up or down, right and left are undefined
constexpr double kZoomPerNotch = 0.8;
constexpr double kNearest = 1e-6, kFarthest = 1e3;  // distance of what is zoomed to, in sizes
constexpr double kNearShare = 1e-4;         // of the size; reverse-Z float depth stays precise with a small share
constexpr double kOrthographicReach = 4.0;  // sizes before and behind the target
constexpr double kKeyInterval = 0.25;       // seconds between recorded keys
constexpr std::size_t kMostPlaces = 200;

double size_of(const core::AabbD& bounds) {
  const double diagonal = bounds.empty() ? 0.0 : glm::length(bounds.size());
  return diagonal > 0.0 ? diagonal : 1.0;
}

const core::dvec3 kUp(0.0, 0.0, 1.0);
constexpr double kFocusFilled = 0.8;

}  // namespace

Camera::Camera(const core::AabbD& bounds, double fovy, double aspect)
    : size_(size_of(bounds)),
      fovy_(fovy),
      near_(kNearShare * std::max(1.0, size_)),
      pose_(core::fitting_pose(bounds, core::kOverviewDirection, fovy, aspect, core::kOverviewFilled)) {}

core::Expected<core::View> Camera::view(double aspect, const core::dvec2& shift) const {
  const double half_height = std::tan(0.5 * fovy_);
  if (!orthographic_) {
    if (shift == core::dvec2(0.0)) return core::View::perspective(pose_, fovy_, aspect, near_, far_);
    const double up = near_ * half_height, right = up * aspect, x = 2.0 * right * shift.x, y = 2.0 * up * shift.y;
    return core::View::asymmetric(pose_, -right - x, right - x, -up - y, up - y, near_, far_);
  }
  const double distance = glm::length(pose_.target - pose_.eye), reach = kOrthographicReach * size_ + distance;
  Camera moved = *this;
  moved.pan(shift * core::dvec2(aspect, 1.0), pose_.target);
  return core::View::orthographic(moved.pose_, 2.0 * distance * half_height, aspect, distance - reach,
                                  distance + reach);
}

void Camera::set_planes(double near, double far) {
  near_ = near;
  far_ = far;
}

core::dvec3 Camera::forward() const {
  return glm::normalize(pose_.target - pose_.eye);
}

void Camera::fit(const core::AabbD& bounds, double aspect) {
  pose_ = core::fitting_pose(bounds, forward(), fovy_, aspect, kFocusFilled);
}

void Camera::show_all(const core::ItemBounds& items, const core::dvec3& direction, double aspect,
                      std::span<const core::Plane> sections) {
  const core::Fitting fitting =
      core::fitting_of(items, items.fitted_bounds().bounds, direction, fovy_, aspect, sections);
  pose_ = orthographic_ ? fitting.parallel_pose() : fitting.pose();
}

void Camera::fly(const core::dvec3& held, double seconds) {
  if (held == core::dvec3(0.0)) return;
  const core::dvec3 ahead = forward(), aside = glm::cross(ahead, kUp);
  const double sideways = glm::length(aside);
  const core::dvec3 right = sideways > 0.0 ? aside / sideways : core::dvec3(1.0, 0.0, 0.0);
  const core::dvec3 step = speed() * seconds * (held.x * right + held.y * ahead + held.z * kUp);
  pose_.eye += step;
  pose_.target += step;
}

void Camera::look(const core::dvec2& by) {
  turn(by, pose_.eye);
}

void Camera::orbit(const core::dvec2& by, const core::dvec3& about) {
  turn(by, about);
}

/// Turns eye and target about a point.
void Camera::turn(const core::dvec2& by, const core::dvec3& about) {
  if (by == core::dvec2(0.0)) return;
  const core::dvec3 sight = pose_.target - pose_.eye;
  const double distance = glm::length(sight);
  const auto axes = [](double heading, double pitch) {
    const core::dvec3 ahead(std::cos(pitch) * std::cos(heading), std::cos(pitch) * std::sin(heading), std::sin(pitch));
    const core::dvec3 right(std::sin(heading), -std::cos(heading), 0.0);
    return core::dmat3(right, ahead, glm::cross(right, ahead));
  };
  const double heading = std::atan2(sight.y, sight.x), pitch = std::asin(std::clamp(sight.z / distance, -1.0, 1.0));
  const core::dmat3 before = axes(heading, pitch),
                    after = axes(heading - by.x, std::clamp(pitch + by.y, -kSteepest, kSteepest));
  pose_.eye = about + after * (glm::transpose(before) * (pose_.eye - about));
  pose_.target = pose_.eye + distance * after[1];
  pose_.up = kUp;
}

void Camera::pan(const core::dvec2& by, const core::dvec3& at) {
  const core::dvec3 ahead = forward();
  core::dvec3 right = glm::cross(ahead, pose_.up);
  if (glm::length(right) == 0.0) right = core::dvec3(1.0, 0.0, 0.0);
  right = glm::normalize(right);
  const double depth = orthographic_ ? glm::length(pose_.target - pose_.eye)
                                     : std::clamp(glm::dot(at - pose_.eye, ahead), kNearest * size_, kFarthest * size_);
  const double height = 2.0 * depth * std::tan(0.5 * fovy_);
  const core::dvec3 step = -height * (by.x * right + by.y * glm::cross(right, ahead));
  pose_.eye += step;
  pose_.target += step;
}

/// Scales eye and target about the point.
void Camera::zoom(double notches, const core::dvec3& at) {
  if (notches == 0.0) return;
  const double distance = glm::length(pose_.target - pose_.eye);
  const double wanted = std::clamp(distance * std::pow(kZoomPerNotch, notches), kNearest * size_, kFarthest * size_);
  const double scale = wanted / distance;
  pose_.eye = at + scale * (pose_.eye - at);
  pose_.target = at + scale * (pose_.target - at);
}

void Camera::remember() {
  if (!places_.empty() && places_.back().first.eye == pose_.eye && places_.back().first.target == pose_.target) return;
  places_.emplace_back(pose_, orthographic_);
  if (places_.size() > kMostPlaces) places_.erase(places_.begin());
}

void Camera::back() {
  const core::dvec3 eye = pose_.eye;
  while (!places_.empty() && places_.back().first.eye == eye && places_.size() > 1) places_.pop_back();
  if (places_.empty()) return;
  std::tie(pose_, orthographic_) = places_.back();
  places_.pop_back();
}

void PathRecorder::add(double time, const core::CameraSample& camera) {
  const std::size_t count = keys_.size();
  const bool last_stays = count < 2 || keys_[count - 1].time - keys_[count - 2].time >= kKeyInterval;
  if (!last_stays) keys_.pop_back();
  keys_.push_back({time, camera.pose, camera.fovy});
}

core::Expected<core::CameraPath> PathRecorder::path(double near, double far) const {
  std::vector<core::CameraKey> keys = keys_;
  for (core::CameraKey& key : keys) key.time -= keys_.front().time;
  auto path = core::CameraPath::create(std::move(keys));
  if (!path) return path;
  path->near = near;
  path->far = far;
  return path;
}

}  // namespace sightline::apps
