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
constexpr double kTouching = 1e-6;                   // metres over the floor
constexpr double kLowestRung = 0.1, kReach = 0.605;  // metres over and below the feet
constexpr double kTowards = 0.7;                     // cosine of an angle to a ladder
const dvec3 kUpward(0.0, 0.0, 1.0);

dvec3 moved(const dvec3& eye, const dvec2& by) {
  return eye + dvec3(by, 0.0);
}

}  // namespace

dvec3 Walker::move(dvec3 eye, const dvec2& velocity, double seconds) {
  const double length = glm::length(velocity) * seconds;
  const int steps = std::max(1, int(std::ceil(length / kLongestStep)));
  for (int i = 0; i < steps; ++i) {
    const dvec2 by = velocity * (seconds / steps);
    if (climbs(eye, by, seconds / steps)) continue;
    if (length > 0.0) eye = walk(eye, by);
    if (!hangs_) eye.z = fall(eye, seconds / steps);
  }
  return eye;
}

/// Moves up a ladder with a motion towards it, and down with one away from it; others leave it.
bool Walker::climbs(dvec3& eye, const dvec2& by, double seconds) {
  const double length = glm::length(by), rise = kClimb * std::max(1.0, length / (kSpeed * seconds)) * seconds;
  const bool ahead = length > 0.0 && is_ladder(eye, by / length, -kReach);
  if (ahead && is_ladder(eye, by / length, kLowestRung)) {
    ladder_ = by / length;
    if (free(eye, kUpward, rise + kHeadroom)) eye.z += rise;
    falling_ = false, speed_ = 0.0;
    return true;
  }
  const auto floor = floor_below(eye);
  const bool stands = floor && eye.z <= *floor + kEyeHeight + kTouching;
  if (stands && ahead)
    ladder_ = by / length;  // one that leads down
  else if (stands && ladder_ && !is_ladder(eye, *ladder_, -kReach))
    ladder_.reset();
  hangs_ = !stands && finds_ladder(eye);
  if (!hangs_ || (length > 0.0 && glm::dot(by, *ladder_) > -kTowards * length)) return false;
  if (length > 0.0) eye.z = floor ? std::max(eye.z - rise, *floor + kEyeHeight) : eye.z - rise;
  falling_ = false, speed_ = 0.0;
  return true;
}

/// Whether arms reach rungs in a direction: things with gaps between them, one above the other. Walls have no gaps, and
/// rails lie farther apart.
bool Walker::is_ladder(const dvec3& eye, const dvec2& direction, double lowest) const {
  constexpr double kArm = 0.5, kHighest = 1.5, kSpacing = 0.015;  // metres; above the feet
  std::optional<double> last;                                     // height of the rung below
  bool before = true;                                             // there was something
  for (double height = lowest; height <= kHighest; height += kSpacing) {
    const bool is = !free(eye + (height - kEyeHeight) * kUpward, dvec3(direction, 0.0), kArm);
    if (is && !before) {
      if (last && height - *last <= kHighestStep) return true;
      last = height;
    }
    before = is;
  }
  return false;
}

bool Walker::finds_ladder(const dvec3& eye) {
  if (falling_ && !ladder_) return false;  // nobody gets hold of one in a fall
  if (ladder_ && is_ladder(eye, *ladder_, -kReach)) return true;
  constexpr int kDirections = 8;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kDirections;
    ladder_ = dvec2(std::cos(angle), std::sin(angle));
    if (is_ladder(eye, *ladder_, -kReach)) return true;
  }
  ladder_.reset();
  return false;
}

std::optional<dvec3> Walker::stand_at(const dvec3& eye) const {
  if (!trace_(eye, -kUpward, kDeepest)) return std::nullopt;  // one ray for most places, where nothing is
  const auto floor = floor_below(eye);
  if (!floor) return std::nullopt;
  const dvec3 there(eye.x, eye.y, *floor + kEyeHeight);
  return fits(there) ? std::optional(there) : std::nullopt;
}

std::optional<dvec3> Walker::nearest_floor(const dvec3& eye, const core::AabbD& model) const {
  if (const auto below = stand_at(eye)) return below;
  std::optional<dvec3> nearest;
  const auto distance = [&](const dvec3& there) { return glm::length(there - eye); };
  const auto try_at = [&](const dvec3& from) {
    if (nearest && !(glm::length(dvec2(from - eye)) < distance(*nearest))) return;
    const auto there = stand_at(from);
    if (there && (!nearest || distance(*there) < distance(*nearest))) nearest = there;
  };
  constexpr double kFirst = 0.5, kLast = 12.0, kWider = 1.2;  // metres, and by how much each ring is
  constexpr int kRays = 24, kCells = 96;
  for (const double height : {eye.z, std::max(eye.z, model.max.z + kEyeHeight)}) {
    for (double radius = kFirst; radius < kLast; radius *= kWider)
      for (int i = 0; i < kRays; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / kRays;
        try_at({eye.x + radius * std::cos(angle), eye.y + radius * std::sin(angle), height});
      }
    const dvec3 cell = model.size() / double(kCells);
    for (int i = 0; i < kCells * kCells; ++i)
      try_at({model.min.x + (i % kCells + 0.5) * cell.x, model.min.y + (i / kCells + 0.5) * cell.y, height});
    if (nearest) break;
  }
  return nearest;
}

dvec3 Walker::walk(const dvec3& eye, const dvec2& by) const {
  const dvec2 along = ladder_ ? by : kept_off(eye, by);  // stiles may leave little room
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
