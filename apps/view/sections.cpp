#include "sightline/apps/view/sections.h"

#include <cmath>

namespace sightline::apps {
namespace {

/// A square on the plane that is as large as the bounds or larger, about the bounds' centre.
std::vector<core::dvec3> square_on(const core::Plane& plane, const core::AabbD& bounds) {
  const core::dvec3 n = plane.normal, centre = bounds.centre();
  const core::dvec3 middle = centre - core::evaluate(plane, centre) * n;
  const core::dvec3 aside =
      glm::normalize(glm::cross(n, std::abs(n.z) < 0.7 ? core::dvec3(0, 0, 1) : core::dvec3(1, 0, 0)));
  const core::dvec3 u = glm::length(bounds.size()) * aside, v = glm::cross(n, u);
  return {middle + u + v, middle - u + v, middle - u - v, middle + u - v};
}

/// A point of the plane in the middle of what the bounds and all planes keep of it, or nearest to their centre where
/// that is nothing. Normals are of length 1.
core::dvec3 middle_of(const core::Plane& plane, std::span<const core::Plane> all, const core::AabbD& bounds) {
  if (bounds.empty()) return -plane.offset * plane.normal;
  std::vector<core::Plane> sides(all.begin(), all.end());
  for (int axis = 0; axis < 3; ++axis) {
    core::dvec3 normal(0.0);
    normal[axis] = 1.0;
    sides.push_back({normal, -bounds.min[axis]});
    sides.push_back({-normal, bounds.max[axis]});
  }
  std::vector<core::dvec3> polygon = square_on(plane, bounds);
  for (const core::Plane& side : sides)
    if (glm::length(glm::cross(side.normal, plane.normal)) > 1e-9) polygon = clipped(polygon, side);
  if (polygon.empty()) polygon = {bounds.centre()};
  core::dvec3 sum(0.0);
  for (const core::dvec3& corner : polygon) sum += corner - polygon[0];
  const core::dvec3 middle = polygon[0] + sum / double(polygon.size());
  return middle - core::evaluate(plane, middle) * plane.normal;
}

}  // namespace

std::vector<core::dvec3> clipped(const std::vector<core::dvec3>& polygon, const core::Plane& plane) {
  std::vector<core::dvec3> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const core::dvec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double from = core::evaluate(plane, a), to = core::evaluate(plane, b);
    if (from >= 0.0) kept.push_back(a);
    if ((from >= 0.0) != (to >= 0.0)) kept.push_back(a + from / (from - to) * (b - a));
  }
  return kept;
}

bool Sections::add(const core::dvec3& point, const core::dvec3& outwards) {
  if (sections_.size() == kMost) return false;
  sections_.push_back({point, glm::normalize(outwards)});
  return true;
}

void Sections::box(const core::AabbD& bounds) {
  clear();
  for (int axis = 0; axis < 3; ++axis) {
    core::dvec3 normal(0.0), high = bounds.centre(), low = high;
    normal[axis] = 1.0;
    high[axis] = bounds.max[axis];
    low[axis] = bounds.min[axis];
    add(high, normal);
    add(low, -normal);
  }
}

bool Sections::add_middle(int axis, const core::AabbD& bounds) {
  core::dvec3 normal(0.0);
  normal[axis] = 1.0;
  return add(bounds.centre(), normal);
}

std::optional<std::array<std::size_t, 6>> Sections::box() const {
  constexpr double kSame = 1e-9;
  std::array<std::size_t, 6> sides{};
  std::size_t found = 0;
  std::vector<bool> used(sections_.size(), false);
  const auto right_angle = [&](std::size_t i) {
    for (std::size_t k = 0; k < found; k += 2)
      if (std::abs(glm::dot(sections_[i].normal, sections_[sides[k]].normal)) > kSame) return false;
    return true;
  };
  for (std::size_t i = 0; i < sections_.size() && found < kBoxSides; ++i)
    for (std::size_t j = i + 1; j < sections_.size() && !used[i] && found < kBoxSides; ++j) {
      if (used[j] || glm::length(sections_[i].normal + sections_[j].normal) > kSame || !right_angle(i)) continue;
      const core::dvec3& n = sections_[i].normal;
      const bool upper = n.x + n.y + n.z > 0.0;
      sides[found++] = upper ? i : j;
      sides[found++] = upper ? j : i;
      used[i] = used[j] = true;
    }
  return found == kBoxSides ? std::optional(sides) : std::nullopt;
}

std::array<core::dvec3, 8> box_corners(const Sections& sections, const std::array<std::size_t, 6>& sides) {
  std::array<core::dvec3, 8> corners{};
  for (std::size_t corner = 0; corner < corners.size(); ++corner)
    for (std::size_t pair = 0; pair < 3; ++pair) {
      const Sections::Section &upper = sections.all()[sides[2 * pair]], &lower = sections.all()[sides[2 * pair + 1]];
      const Sections::Section& side = (corner >> pair & 1) != 0 ? upper : lower;
      corners[corner] += glm::dot(upper.normal, side.place()) * upper.normal;
    }
  return corners;
}

std::optional<int> section_axis(const Sections::Section& section) {
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(section.normal[axis]) > 1.0 - 1e-12) return axis;
  return std::nullopt;
}

std::string section_words(const Sections::Section& section, const core::dvec3& origin, const LengthFormat& lengths) {
  constexpr const char* kKeeps[3][2] = {
      {"west of X ", "east of X "}, {"south of Y ", "north of Y "}, {"below elevation ", "above elevation "}};
  if (const auto axis = section_axis(section))
    return kKeeps[*axis][section.normal[*axis] < 0.0] + lengths.text((section.place() - origin)[*axis]);
  const double slope = glm::degrees(std::asin(std::min(1.0, std::abs(section.normal.z))));
  return std::abs(section.normal.z) < 1e-9
             ? "behind an upright plane, askew"
             : "behind a plane, " + std::to_string(int(std::lround(90.0 - slope))) + "° steep";
}

void Sections::set(std::span<const core::Plane> planes, const core::AabbD& bounds) {
  clear();
  std::vector<core::Plane> good;
  for (const core::Plane& plane : planes)
    if (const double length = glm::length(plane.normal); length > 0.0)
      good.push_back({plane.normal / length, plane.offset / length});
  for (const core::Plane& plane : good) add(middle_of(plane, good, bounds), -plane.normal);
}

void Sections::clear() {
  sections_.clear();
  selected_.reset();
}

void Sections::remove(std::size_t index) {
  sections_.erase(sections_.begin() + std::ptrdiff_t(index));
  if (!selected_ || *selected_ < index) return;
  if (*selected_ == index)
    selected_.reset();
  else
    --*selected_;
}

/// The other side is kept; the plane stays.
void Sections::flip(Section& section) {
  section.point = section.place();
  section.normal = -section.normal;
  section.offset = 0.0;
}

std::vector<core::Plane> Sections::planes() const {
  std::vector<core::Plane> planes;
  for (const Section& section : sections_)
    if (section.on) planes.push_back(section.plane());
  return planes;
}

}  // namespace sightline::apps
