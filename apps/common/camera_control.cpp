#include "sightline/apps/common/camera_control.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sightline::apps {
namespace {

constexpr double kSteepest = 0.995 * std::numbers::pi / 2;  // looking straight up or down, right and left are undefined
constexpr double kSizesPerSecond = 0.125;                   // initial speed, in sizes of the model
constexpr double kSlowest = 1e-6, kFastest = 10.0;          // in sizes per second
constexpr double kSpeedPerNotch = 1.25, kZoomPerNotch = 0.8;
constexpr double kNearest = 1e-6, kFarthest = 1e3;  // distance of the centre, in sizes
constexpr double kKeyInterval = 0.25;               // seconds between recorded keys

double size_of(const core::AabbD& bounds) {
  const double diagonal = bounds.empty() ? 0.0 : glm::length(bounds.size());
  return diagonal > 0.0 ? diagonal : 1.0;
}

const core::dvec3 kUp(0.0, 0.0, 1.0);

}  // namespace

bool CameraInput::idle() const {
  return move == core::dvec3(0.0) && look == core::dvec2(0.0) && orbit == core::dvec2(0.0) && wheel == 0.0;
}

CameraControl::CameraControl(const core::AabbD& bounds, double fovy, double aspect)
    : bounds_(bounds), size_(size_of(bounds)), speed_(kSizesPerSecond * size_) {
  fit(fovy, aspect);
}

void CameraControl::fit(double fovy, double aspect) {
  pose_ = core::fitting_pose(bounds_, core::kOverviewDirection, fovy, aspect);
}

void CameraControl::apply(const CameraInput& input) {
  turn(input.look, orbiting_);
  turn(input.orbit, true);
  if (orbiting_)
    zoom(input.wheel);
  else
    speed_ = std::clamp(speed_ * std::pow(kSpeedPerNotch, input.wheel), kSlowest * size_, kFastest * size_);
  move(input.move, input.seconds);
}

void CameraControl::set_centre(double metres) {
  const double distance = std::clamp(metres, kNearest * size_, kFarthest * size_);
  pose_.target = pose_.eye + distance * glm::normalize(pose_.target - pose_.eye);
}

void CameraControl::move(const core::dvec3& held, double seconds) {
  if (held == core::dvec3(0.0)) return;
  const core::dvec3 forward = glm::normalize(pose_.target - pose_.eye);
  const core::dvec3 aside = glm::cross(forward, kUp);
  const double sideways = glm::length(aside);
  const core::dvec3 right = sideways > 0.0 ? aside / sideways : core::dvec3(1.0, 0.0, 0.0);
  const core::dvec3 step = speed_ * seconds * (held.x * right + held.y * forward + held.z * kUp);
  pose_.eye += step;
  pose_.target += step;
}

void CameraControl::turn(const core::dvec2& by, bool about_centre) {
  if (by == core::dvec2(0.0)) return;
  const core::dvec3 sight = pose_.target - pose_.eye;
  const double distance = glm::length(sight);
  const double heading = std::atan2(sight.y, sight.x) - by.x;
  const double pitch = std::clamp(std::asin(std::clamp(sight.z / distance, -1.0, 1.0)) + by.y, -kSteepest, kSteepest);
  const core::dvec3 forward(std::cos(pitch) * std::cos(heading), std::cos(pitch) * std::sin(heading), std::sin(pitch));
  if (about_centre)
    pose_.eye = pose_.target - distance * forward;
  else
    pose_.target = pose_.eye + distance * forward;
  pose_.up = kUp;
}

void CameraControl::zoom(double notches) {
  if (notches == 0.0) return;
  const core::dvec3 sight = pose_.target - pose_.eye;
  const double distance = glm::length(sight);
  const double wanted = std::clamp(distance * std::pow(kZoomPerNotch, notches), kNearest * size_, kFarthest * size_);
  pose_.eye = pose_.target - sight * (wanted / distance);
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
