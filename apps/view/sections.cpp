#include "sightline/apps/view/sections.h"

namespace sightline::apps {

bool Sections::add(const core::dvec3& point, const core::dvec3& outwards) {
  if (sections_.size() == kMost) return false;
  sections_.push_back({point, glm::normalize(outwards)});
  return true;
}

void Sections::box(const core::AabbD& bounds) {
  sections_.clear();
  for (int axis = 0; axis < 3; ++axis) {
    core::dvec3 normal(0.0);
    normal[axis] = 1.0;
    add(bounds.max, normal);
    add(bounds.min, -normal);
  }
}

void Sections::set(std::span<const core::Plane> planes) {
  sections_.clear();
  for (const core::Plane& plane : planes) {
    const double length = glm::length(plane.normal);
    if (length > 0.0) add(-plane.offset / (length * length) * plane.normal, -plane.normal);
  }
}

/// The other side is kept; the plane stays.
void Sections::flip(Section& section) {
  section.point += section.offset * section.normal;
  section.normal = -section.normal;
  section.offset = 0.0;
}

std::vector<core::Plane> Sections::planes() const {
  std::vector<core::Plane> planes;
  for (const Section& section : sections_)
    if (section.on) planes.push_back({-section.normal, glm::dot(section.normal, section.point) + section.offset});
  return planes;
}

}  // namespace sightline::apps
