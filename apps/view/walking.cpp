#include "sightline/apps/view/walking.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace sightline::apps {
namespace {

using core::dvec2;
using core::dvec3;

constexpr double kKnee = 0.45, kHeadroom = 0.1;                // metres above the feet, above the eye
constexpr double kHeights[] = {kKnee, 0.75, 1.05, 1.35, 1.7};  // of rays, above the feet: from knee to head
static_assert(kKnee > Walker::kHighestStep);
constexpr int kFeelers = 16;          // directions in which walls are felt for
constexpr double kLongestStep = 0.1;  // metres, less than the radius, so that feelers reach what is ahead
constexpr double kSkin = 0.02;        // metres that the axis stays off what it moves towards
constexpr double kFoot = 0.7;         // share of the radius that stands on the floor
constexpr double kGravity = 9.81, kFastestFall = 30.0, kDeepest = 1e5;
constexpr double kTouching = 1e-6;  // metres over the floor
const dvec3 kUpward(0.0, 0.0, 1.0);

dvec3 moved(const dvec3& eye, const dvec2& by) {
  return eye + dvec3(by, 0.0);
}

}  // namespace

dvec3 Walker::move(dvec3 eye, const dvec2& velocity, double seconds) {
  const double length = glm::length(velocity) * seconds;
  const int steps = std::max(1, int(std::ceil(length / kLongestStep)));
  for (int i = 0; i < steps; ++i) {
    if (length > 0.0) eye = walk(eye, velocity * (seconds / steps));
    eye.z = fall(eye, seconds / steps);
  }
  return eye;
}

dvec3 Walker::walk(const dvec3& eye, const dvec2& by) const {
  const dvec2 along = kept_off(eye, by);
  if (along == dvec2(0.0) || !passes(eye, along)) return eye;
  dvec3 there = moved(eye, along);
  if (const auto floor = floor_below(there)) there.z = std::max(there.z, *floor + kEyeHeight);
  return fits(there) || !fits(eye) ? there : eye;
}

/// The motion, turned aside so that the axis stays a radius off whatever is felt around.
dvec2 Walker::kept_off(const dvec3& eye, dvec2 by) const {
  std::vector<dvec2> touched;  // from the axis
  const double reach = kRadius + glm::length(by), ahead = std::atan2(by.y, by.x);
  for (int i = 0; i < kFeelers; ++i) {
    const double angle = ahead + 2.0 * std::numbers::pi * i / kFeelers;  // one of them points ahead
    const dvec2 direction(std::cos(angle), std::sin(angle));
    double nearest = reach;
    for (const double height : kHeights)
      if (const auto hit = trace_(eye + (height - kEyeHeight) * kUpward, dvec3(direction, 0.0), nearest))
        nearest = *hit;
    if (nearest < reach) touched.push_back(nearest * direction);
  }
  constexpr int kRounds = 4;  // one obstacle may turn the motion towards another
  for (int round = 0; round < kRounds; ++round)
    for (const dvec2& point : touched) {
      const dvec2 off = by - point;
      const double distance = glm::length(off);
      if (distance < kRadius && distance > 0.0) by += off * ((kRadius - distance) / distance);
    }
  const double length = glm::length(by);
  return length > kLongestStep ? by * (kLongestStep / length) : by;
}

/// Whether nothing between knee and head is in the way of the axis.
bool Walker::passes(const dvec3& eye, const dvec2& by) const {
  const double length = glm::length(by);
  const dvec3 direction(by / length, 0.0);
  return std::all_of(std::begin(kHeights), std::end(kHeights), [&](double height) {
    return free(eye + (height - kEyeHeight) * kUpward, direction, length + kSkin);
  });
}

/// Whether nothing is between knee and head where it stands, such as a beam that runs between the other rays.
bool Walker::fits(const dvec3& eye) const {
  return free(eye - (kEyeHeight - kKnee) * kUpward, kUpward, kEyeHeight - kKnee + kHeadroom);
}

/// Height of the highest floor under the feet.
std::optional<double> Walker::floor_below(const dvec3& eye) const {
  std::optional<double> highest;
  const double off = kFoot * kRadius;
  for (const dvec2& at : {dvec2(0.0), dvec2(off, 0.0), dvec2(-off, 0.0), dvec2(0.0, off), dvec2(0.0, -off)}) {
    const dvec3 knee = moved(eye, at) - (kEyeHeight - kKnee) * kUpward;
    if (const auto hit = trace_(knee, -kUpward, kDeepest))
      highest = std::max(highest.value_or(-kDeepest * kDeepest), knee.z - *hit);
  }
  return highest;
}

/// Height of the eye after falling, or after being lifted onto the floor that the feet are in.
double Walker::fall(const dvec3& eye, double seconds) {
  const auto floor = floor_below(eye);
  const double stands = floor ? *floor + kEyeHeight : eye.z;
  falling_ = eye.z > stands + kTouching;
  if (!falling_) {
    speed_ = 0.0;
    return std::max(eye.z, stands);
  }
  speed_ = std::min(speed_ + kGravity * seconds, kFastestFall);
  const double z = std::max(stands, eye.z - speed_ * seconds);
  falling_ = z > stands + kTouching;
  if (!falling_) speed_ = 0.0;
  return z;
}

}  // namespace sightline::apps
