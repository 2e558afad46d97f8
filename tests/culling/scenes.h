// Random and stiff scenes and views for the culling tests. Everything follows from the generator's state.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/block_order.h"
#include "sightline/core/internal/section_rounding.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/frustum/frustum_test.h"
#include "sightline/tests/core/primitive_samples.h"
#include "sightline/tests/support/instruction_sets.h"

namespace sightline::tests {

inline int whole(Random& random, int low, int high) {
  return std::uniform_int_distribution<int>(low, high)(random);
}
inline bool chance(Random& random, double probability) {
  return uniform(random, 0.0, 1.0) < probability;
}
inline core::dvec3 point(Random& random, double half) {
  const double x = uniform(random, -half, half), y = uniform(random, -half, half);
  return {x, y, uniform(random, -half, half)};
}
/// Evenly spread over orders of magnitude.
inline double magnitude(Random& random, double low, double high) {
  return std::exp(uniform(random, std::log(low), std::log(high)));
}

/// A section plane as items of these bounds are tested against it.
inline core::Plane moved_outwards(const core::Plane& section, const core::ItemBounds& bounds) {
  const core::Aabb& extent = bounds.extent();
  const core::dvec3 largest = glm::max(glm::abs(core::dvec3(extent.min)), glm::abs(core::dvec3(extent.max)));
  return core::moved_outwards(section, bounds.origin, extent.empty() ? core::dvec3(0.0) : largest);
}

inline core::Aabb box_around(const core::dvec3& centre, const core::dvec3& half) {
  return core::round_outwards({centre - half, centre + half}, core::dvec3(0.0));
}

/// Mostly small boxes in a cube of half side `half`, some long, flat, large or without volume.
inline core::Aabb random_box(Random& random, double half) {
  const core::dvec3 centre = point(random, half);
  if (chance(random, 0.05)) return {core::vec3(centre), core::vec3(centre)};
  core::dvec3 size(half * magnitude(random, 1e-4, 0.3));
  if (chance(random, 0.3)) size[whole(random, 0, 2)] *= 20.0;
  if (chance(random, 0.1)) size[whole(random, 0, 2)] = 0.0;
  return box_around(centre, size);
}

inline std::vector<core::Aabb> random_boxes(Random& random, std::size_t count, double half) {
  std::vector<core::Aabb> boxes;
  for (std::size_t i = 0; i < count; ++i) boxes.push_back(random_box(random, half));
  return boxes;
}

/// Boxes that no plant has: of denormal size, of 1e38 m, empty, in the very same place.
inline void spoil(Random& random, std::vector<core::Aabb>& boxes) {
  for (core::Aabb& box : boxes) {
    switch (whole(random, 0, 60)) {
      case 0:
        box = {};
        break;
      case 1:
        box = {core::vec3(1e-42f), core::vec3(3e-42f)};
        break;
      case 2:
        box.max = core::vec3(1e38f);
        break;
      case 3:
        box = {core::vec3(-core::Aabb::kFar), core::vec3(core::Aabb::kFar)};
        break;
      case 4:
        box = boxes.front();
        break;
      case 5:
        box.min[1] = std::nextafterf(box.max[1], core::Aabb::kFar);
        break;  // inverted by one step
      default:
        break;
    }
  }
}

/// A camera in or around a cube of half side `half` at `origin`: all projections that View knows.
inline core::View random_view(Random& random, const core::dvec3& origin, double half) {
  core::Pose pose;
  pose.eye = origin + point(random, half * magnitude(random, 0.1, 4.0));
  pose.target = origin + point(random, half);
  pose.up = point(random, 1.0);
  const double near = half * magnitude(random, 1e-7, 1e-1), far = near * magnitude(random, 2.0, 1e9);
  const double aspect = magnitude(random, 0.2, 5.0);
  const double fovy = chance(random, 0.2) ? magnitude(random, 1e-4, 1e-1) : uniform(random, 0.1, 3.1);
  const double end = chance(random, 0.3) ? core::kInfiniteFar : far;
  auto view = [&]() -> core::Expected<core::View> {
    switch (whole(random, 0, 3)) {
      case 0: {
        const double depth = half * uniform(random, 0.1, 3.0);
        return core::View::orthographic(pose, half * magnitude(random, 1e-2, 3.0), aspect, -0.2 * depth, depth);
      }
      case 1: {
        const double left = near * uniform(random, -3.0, 1.0), bottom = near * uniform(random, -3.0, 1.0);
        const double top = bottom + near * magnitude(random, 1e-2, 4.0);
        return core::View::asymmetric(pose, left, left + near * magnitude(random, 1e-2, 4.0), bottom, top, near, end);
      }
      default:
        return core::View::perspective(pose, fovy, aspect, near, end);
    }
  }();
  if (!view) view = core::View::orthographic({}, half, 1.0, -half, half);
  return *view;
}

inline void add_sections(Random& random, const core::dvec3& origin, double half, core::View& view) {
  view.section_mode = chance(random, 0.5) ? core::SectionMode::kUnion : core::SectionMode::kIntersection;
  const int count = whole(random, 1, int(core::kMaxSectionPlanes));
  for (int i = 0; i < count; ++i) {
    core::dvec3 normal = point(random, 1.0);
    if (chance(random, 0.3)) normal = core::dvec3(0.0), normal[whole(random, 0, 2)] = chance(random, 0.5) ? 1.0 : -1.0;
    if (chance(random, 0.02)) normal = core::dvec3(0.0);
    const core::dvec3 through = origin + point(random, half * 1.2);
    view.sections.push_back({normal, -glm::dot(normal, through)});
  }
}

/// Whether the float planes, moved outwards by a few bands, leave a box open.
inline bool left_open(const culling::CullPlanes& planes, const core::Aabb& box) {
  const auto near_plane = [&](int k) {
    const culling::FloatPlane& f = planes.planes()[k];
    double s = f.offset;
    for (int i = 0; i < 3; ++i) s += double(f.normal[i]) * (f.normal[i] >= 0.0f ? box.max[i] : box.min[i]);
    return s >= -3.5 * double(f.band) - 1e-30;
  };
  for (int k = 0; k < planes.union_first(); ++k)
    if (!near_plane(k)) return false;
  for (int k = planes.union_first(); k < planes.plane_count(); ++k)
    if (near_plane(k)) return true;
  return planes.union_first() == planes.plane_count();
}

/// Boxes in the order that a hierarchy gives them, with the culler over it. The last `unsorted` ones stay as they are.
struct Scene {
  core::ItemBounds bounds;
  std::unique_ptr<culling::CpuCuller> culler;

  Scene(std::span<const core::Aabb> boxes, const core::dvec3& origin, std::size_t unsorted = 0,
        const core::BlockOrderOptions& config = {}) {
    const std::size_t sorted = boxes.size() - unsorted;
    bounds.origin = origin;
    bounds.resize(boxes.size());
    const std::vector<std::uint32_t> order = core::block_order(boxes.first(sorted), config);
    for (std::size_t i = 0; i < boxes.size(); ++i) bounds.set(i, boxes[i < sorted ? order[i] : i]);
    culler = std::make_unique<culling::CpuCuller>(bounds);
  }

  /// The slots of a set that are not vacant, in rising order.
  std::vector<core::Slot> occupied(const core::VisibleSet& set) const {
    std::vector<core::Slot> slots = set.sorted_slots();
    std::erase_if(slots, [&](core::Slot slot) { return bounds.vacant(slot); });
    return slots;
  }
};

}  // namespace sightline::tests
