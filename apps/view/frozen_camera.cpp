#include "sightline/apps/view/frozen_camera.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/apps/view/sections.h"

namespace sightline::apps {
namespace {

using core::dvec3;
using core::dvec4;

std::uint64_t latest_version = 0;

constexpr double kBeyond = 1.02;     // of the distance to what lies farthest
constexpr double kLeastDepth = 0.1;  // of the model's diagonal, where it lies behind the camera

/// Distance along the axis at which a plane of the view is met; none where it is met nowhere ahead.
std::optional<double> distance_of(const core::View& view, core::FrustumPlane which) {
  const core::Plane plane = core::frustum_planes(view.clip_from_eye(), view.clip_depth())[std::size_t(which)];
  if (plane.normal.z == 0.0) return std::nullopt;
  return plane.offset / plane.normal.z;
}

/// Near corners first, each four in a ring.
std::array<dvec3, 8> corners_of(const core::View& view, const core::AabbD& bounds) {
  const double near = distance_of(view, core::kNear).value_or(0.0);
  double farthest = near;
  for (int i = 0; i < 8 && !bounds.empty(); ++i) {
    const dvec3 corner(i & 1 ? bounds.max.x : bounds.min.x, i & 2 ? bounds.max.y : bounds.min.y,
                       i & 4 ? bounds.max.z : bounds.min.z);
    farthest = std::max(farthest, -(view.eye_from_world() * dvec4(corner, 1.0)).z);
  }
  const double least = kLeastDepth * (bounds.empty() ? 1.0 : glm::length(bounds.size()));
  double far = std::max(near + kBeyond * (farthest - near), near + least);
  if (const auto plane = distance_of(view, core::kFar); plane && *plane > near) far = std::min(far, *plane);
  const core::dmat4 eye_from_clip = glm::inverse(view.clip_from_eye()), world = glm::inverse(view.eye_from_world());
  const double clip_near = core::near_depth(view.clip_depth());
  constexpr double kRing[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  std::array<dvec3, 8> corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const dvec4 h = eye_from_clip * dvec4(kRing[i][0], kRing[i][1], clip_near, 1.0);
    const dvec3 at_near = dvec3(h) / h.w;
    const dvec3 at_far = view.orthographic() ? dvec3(at_near.x, at_near.y, -far) : at_near * (far / near);
    corners[i] = dvec3(world * dvec4(at_near, 1.0));
    corners[i + 4] = dvec3(world * dvec4(at_far, 1.0));
  }
  return corners;
}

constexpr std::size_t kEdges[12][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                       {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};

void add(std::vector<WorldLine>& lines, const dvec3& from, const dvec3& to, WorldLine::Part part) {
  if (from != to) lines.push_back({from, to, part});
}

/// An edge in up to three parts: the middle one is what all sections keep.
void add_edge(const dvec3& a, const dvec3& b, const std::vector<core::Plane>& sections, std::vector<WorldLine>& lines) {
  double low = 0.0, high = 1.0;
  for (const core::Plane& plane : sections) {
    const double at_a = core::evaluate(plane, a), at_b = core::evaluate(plane, b);
    if (at_a < 0.0 && at_b < 0.0) high = low = 0.0;
    if ((at_a < 0.0) == (at_b < 0.0)) continue;
    const double t = at_a / (at_a - at_b);
    (at_a < 0.0 ? low : high) = at_a < 0.0 ? std::max(low, t) : std::min(high, t);
  }
  if (low >= high) return add(lines, a, b, WorldLine::Part::kCut);
  const dvec3 in = a + low * (b - a), out = high < 1.0 ? a + high * (b - a) : b;
  add(lines, a, in, WorldLine::Part::kCut);
  add(lines, in, out, WorldLine::Part::kKept);
  add(lines, out, b, WorldLine::Part::kCut);
}

/// Where a plane cuts the volume between the corners; a ring of points.
std::vector<dvec3> cut(const std::array<dvec3, 8>& corners, const core::Plane& plane) {
  std::vector<dvec3> points;
  dvec3 middle(0.0);
  for (const auto& [i, j] : kEdges) {
    const double a = core::evaluate(plane, corners[i]), b = core::evaluate(plane, corners[j]);
    if ((a < 0.0) == (b < 0.0)) continue;
    points.push_back(corners[i] + (a / (a - b)) * (corners[j] - corners[i]));
    middle += points.back();
  }
  if (points.size() < 3) return {};
  middle /= double(points.size());
  const dvec3 normal = glm::normalize(plane.normal), x = glm::normalize(points[0] - middle), y = glm::cross(normal, x);
  const auto angle = [&](const dvec3& p) { return std::atan2(glm::dot(p - middle, y), glm::dot(p - middle, x)); };
  std::sort(points.begin(), points.end(), [&](const dvec3& p, const dvec3& q) { return angle(p) < angle(q); });
  return points;
}

}  // namespace

core::Expected<void> FrozenCamera::follow(engine::Engine& engine, const std::vector<core::Plane>& sections,
                                          std::uint64_t shown) {
  core::View now = view_;
  now.sections = sections;
  if (states_ && shown_ == shown && core::same_image(now, view_)) return {};
  auto states = engine.cull_states(now);
  if (!states) return tl::unexpected(states.error());
  view_ = now;
  states_ = std::move(*states);
  shown_ = shown;
  version_ = ++latest_version;
  return {};
}

std::vector<WorldLine> outline(const core::View& view, const core::AabbD& bounds) {
  const std::array<dvec3, 8> corners = corners_of(view, bounds);
  std::vector<core::Plane> sections;
  for (const core::Plane& plane : view.sections)
    if (plane.normal != dvec3(0.0)) sections.push_back(plane);
  std::vector<WorldLine> lines;
  for (const auto& [i, j] : kEdges) add_edge(corners[i], corners[j], sections, lines);
  for (std::size_t s = 0; s < sections.size(); ++s) {
    std::vector<dvec3> ring = cut(corners, sections[s]);
    for (std::size_t other = 0; other < sections.size(); ++other)
      if (other != s) ring = clipped(ring, sections[other]);
    for (std::size_t i = 0; i < ring.size(); ++i)
      add(lines, ring[i], ring[(i + 1) % ring.size()], WorldLine::Part::kSection);
  }
  return lines;
}

}  // namespace sightline::apps
