#include "sightline/core/fitting.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>

#include "sightline/core/internal/visible_box.h"

namespace sightline::core {
namespace {

constexpr double kVertical = 0.999;      // of a direction's length; above it, z cannot be up
constexpr double kLeastDiagonal = 1e-3;  // metres
constexpr double kNearShare = 1e-3;      // near plane, of the diagonal
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The eye position along `axis` at which the largest slope to a corner is minus the smallest one. For one pair of
/// corners that is a linear equation. The sum of the largest and the smallest slope is a maximum over one corner of a
/// minimum over the other. All these functions fall as the eye moves along the axis. So the root of the sum is the same
/// maximum of minimum of the pairs' roots.
double centred(std::span<const dvec3> corners, int axis, double depth) {
  double place = -kInfinity;
  for (const dvec3& a : corners) {
    double least = kInfinity;
    for (const dvec3& b : corners) {
      const double to_a = a.z - depth, to_b = b.z - depth;
      least = std::min(least, (a[axis] * to_b + b[axis] * to_a) / (to_a + to_b));
    }
    place = std::max(place, least);
  }
  return place;
}

/// Returns the part of a box that planes along the axes keep. Others cut nothing off.
AabbD cut(AabbD box, std::span<const Plane> sections) {
  for (const Plane& plane : sections)
    for (int axis = 0; axis < 3; ++axis) {
      if (plane.normal[axis] == 0.0 || plane.normal[(axis + 1) % 3] != 0.0 || plane.normal[(axis + 2) % 3] != 0.0)
        continue;
      const double at = -plane.offset / plane.normal[axis];
      if (plane.normal[axis] > 0.0) box.min[axis] = std::max(box.min[axis], at);
      if (plane.normal[axis] < 0.0) box.max[axis] = std::min(box.max[axis], at);
    }
  return box;
}

}  // namespace

/// Slopes go from that of the image's borders to 0, since boxes that do not touch a border are centred by the slopes
/// that they have.
Fitting::Fitting(const dvec3& direction, double fovy, double aspect, double filled, const dvec3& middle)
    : fovy_(fovy),
      aspect_(aspect),
      filled_(filled),
      tangent_(filled * std::tan(0.5 * fovy)),
      middle_(middle),
      nearest_(kInfinity),
      farthest_(-kInfinity) {
  assert(filled > 0.0 && filled <= 1.0);
  const Expected<dmat4> axes = look_at({dvec3(0.0), direction, {0.0, 0.0, 1.0}});
  assert(axes && "a direction");
  const auto axis = [&](int row, double sign) {
    return sign * dvec3((*axes)[0][row], (*axes)[1][row], (*axes)[2][row]);
  };
  right_ = axis(0, 1.0), up_ = axis(1, 1.0), forward_ = axis(2, -1.0);
  for (std::size_t i = 0; i < supports_.size(); ++i) {
    const bool vertical = i >= 2 * kSlopes, negative = i / kSlopes % 2 == 1;
    const double slope = (vertical ? tangent_ : tangent_ * aspect) * (1.0 - double(i % kSlopes) / double(kSlopes - 1));
    const dvec3 normal = (negative ? -1.0 : 1.0) * (vertical ? up_ : right_) - slope * forward_;
    supports_[i] = {normal, glm::abs(normal), -kInfinity, dvec3(0.0)};
  }
}

void Fitting::add(const AabbD& box) {
  if (box.empty()) return;
  bounds_.grow(box);
  const dvec3 centre = box.centre() - middle_, half = 0.5 * box.size();
  if (count_++ == 0)
    for (int i = 0; i < 8; ++i)
      corners_[std::size_t(i)] = in_eye(centre + half * dvec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  const double depth = glm::dot(centre, forward_), deep = glm::dot(half, glm::abs(forward_));
  nearest_ = std::min(nearest_, depth - deep);
  farthest_ = std::max(farthest_, depth + deep);
  for (Support& support : supports_) {
    const double distance = glm::dot(centre, support.normal) + glm::dot(half, support.sides);
    if (distance < support.distance) continue;
    dvec3 corner = centre;
    for (int i = 0; i < 3; ++i) corner[i] += support.normal[i] < 0.0 ? -half[i] : half[i];
    corner = in_eye(corner);
    // A total order among equally far points, so that the result does not depend on their order.
    const auto rank = [](const dvec3& p) { return std::tie(p.z, p.x, p.y); };
    if (distance == support.distance && rank(corner) <= rank(support.corner)) continue;
    support.distance = distance;
    support.corner = corner;
  }
}

double Fitting::centre(int axis, double depth) const {
  if (count_ == 1) return centred(corners_, axis, depth);
  std::array<dvec3, 2 * kSlopes> corners;
  const auto first = supports_.begin() + std::ptrdiff_t(2 * kSlopes) * axis;
  std::transform(first, first + corners.size(), corners.begin(), [](const Support& s) { return s.corner; });
  return centred(corners, axis, depth);
}

/// Depth is the coordinate along the line of sight. A corner c lies between the slopes -t and t of an eye where
/// c[axis] - t c.z is at most place - t depth, and -c[axis] - t c.z at most -place - t depth. So the eye may be as far
/// forward as minus the sum of the largest left sides over 2 t.
Pose Fitting::pose() const {
  constexpr double kNearest = 0.01;  // least distance between eye and boxes, in diagonals
  assert(!empty());
  const auto limit = [&](std::size_t axis, double tangent) {
    const std::size_t first = 2 * kSlopes * axis;
    return -(supports_[first].distance + supports_[first + kSlopes].distance) / (2.0 * tangent);
  };
  const double depth =
      std::min({limit(0, tangent_ * aspect_), limit(1, tangent_), nearest_ - kNearest * glm::length(bounds_.size())});
  const double target_depth = glm::dot(bounds_.centre() - middle_, forward_);
  const dvec3 across = middle_ + centre(0, depth) * right_ + centre(1, depth) * up_;
  return looking_at(across + target_depth * forward_, target_depth - depth);
}

Expected<View> Fitting::perspective() const {
  if (empty()) return fail("fitting: expected a box to show");
  const double diagonal = glm::length(bounds_.size());
  if (diagonal < kLeastDiagonal) return View::fit(bounds_, forward_, fovy_, aspect_, filled_);
  return View::perspective(pose(), fovy_, aspect_, kNearShare * diagonal);
}

Fitting::ParallelImage Fitting::parallel_image() const {
  // The extent at slope 0.
  const auto reach = [&](std::size_t axis, std::size_t side) {
    return supports_[(2 * axis + side) * kSlopes + kSlopes - 1].distance;
  };
  const double diagonal = std::max(glm::length(bounds_.size()), kLeastDiagonal);
  const dvec2 low(-reach(0, 1), -reach(1, 1)), high(reach(0, 0), reach(1, 0)), centre = 0.5 * (low + high);
  const dvec2 size = high - low;
  const double height = std::max({size.y, size.x / aspect_, 2e-4 * diagonal}) / filled_;
  const double depth = 0.5 * (nearest_ + farthest_);
  return {middle_ + centre.x * right_ + centre.y * up_ + depth * forward_, height, diagonal};
}

Pose Fitting::looking_at(const dvec3& target, double distance) const {
  return {target - distance * forward_, target, std::abs(forward_.z) > kVertical ? up_ : dvec3(0.0, 0.0, 1.0)};
}

Pose Fitting::parallel_pose() const {
  assert(!empty());
  const ParallelImage image = parallel_image();
  return looking_at(image.target, 0.5 * image.height / std::tan(0.5 * fovy_));
}

Expected<View> Fitting::parallel() const {
  if (empty()) return fail("fitting: expected a box to show");
  const ParallelImage image = parallel_image();
  return View::orthographic(looking_at(image.target, image.diagonal), image.height, aspect_, 0.0, 2.0 * image.diagonal);
}

void add_items(Fitting& fitting, const ItemBounds& items, const AabbD& within, std::span<const Plane> sections,
               std::uint32_t layers) {
  for (std::size_t slot = 0; slot < items.size(); ++slot) {
    if (items.vacant(slot) || (items.layers(slot) & layers) == 0) continue;
    const AabbD box = items.in_world(items.box(slot));
    const bool inside =
        glm::all(glm::lessThanEqual(within.min, box.min)) && glm::all(glm::lessThanEqual(box.max, within.max));
    if (inside) fitting.add(cut(box, sections));
  }
}

Fitting fitting_of(const ItemBounds& items, const AabbD& within, const dvec3& direction, double fovy, double aspect,
                   std::span<const Plane> sections, double filled) {
  const AabbD box = visible_box(within);
  Fitting fitting(direction, fovy, aspect, filled, box.centre());
  add_items(fitting, items, within, sections);
  if (fitting.empty()) add_items(fitting, items, within);
  if (fitting.empty() || box.min != within.min) fitting.add(box);  // nothing, or a point
  return fitting;
}

Expected<View> fit_items(const ItemBounds& items, const AabbD& within, const dvec3& direction, double fovy,
                         double aspect, double filled) {
  const auto of_box = View::fit(within, direction, fovy, aspect, filled);
  return of_box ? fitting_of(items, within, direction, fovy, aspect, {}, filled).perspective() : of_box;
}

}  // namespace sightline::core
