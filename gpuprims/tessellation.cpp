#include "sightline/gpuprims/internal/tessellation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/gpuprims/internal/mesh_builder.h"

namespace sightline::gpuprims {
namespace {

using core::kFullTurn;
/// Angles come as floats. 2 pi in float is a little more than 2 pi, and must not add a segment.
constexpr double kRounding = 1e-6;

double share_of_circle(int per_circle, double arc) {
  return std::max(1.0, std::ceil(std::max(3, per_circle) * (std::min(arc, kFullTurn) / kFullTurn) - kRounding));
}

}  // namespace

int segment_count(const Tessellation& config, double radius, double arc) {
  if (config.fixed_segments > 0) return static_cast<int>(share_of_circle(config.fixed_segments, arc));
  const double least = share_of_circle(config.min_segments, arc);
  const double most = std::max(least, share_of_circle(config.max_segments, arc));
  if (!(config.chord_tolerance > 0.0)) return static_cast<int>(most);
  // acos(1 - x) = 2 asin(sqrt(x / 2)), without the cancellation at small x.
  const double half = radius > 0.0 ? std::min(1.0, 0.5 * config.chord_tolerance / radius) : 1.0;
  const double wanted = std::ceil(arc / (2.0 * std::asin(std::sqrt(half))) - kRounding);
  return static_cast<int>(std::clamp(wanted, least, most));
}

std::vector<dvec2> arc_points(int segments, double arc) {
  std::vector<dvec2> points(static_cast<std::size_t>(segments) + 1);
  const bool closed = arc >= kFullTurn;
  for (int i = 0; i <= segments; ++i) {
    const double angle = (closed ? kFullTurn : arc) * i / segments;
    points[i] = {std::cos(angle), std::sin(angle)};
  }
  if (closed) points.back() = points.front();
  return points;
}

bool all_finite(std::span<const float> values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

std::uint32_t MeshBuilder::add(const Vertex& vertex) {
  const double length = glm::length(vertex.normal);
  const dvec3 normal = length > 0.0 ? vertex.normal / length : dvec3(0.0, 0.0, 1.0);
  mesh_.positions.push_back(
      core::vec3(vertex.position + 0.0));  // + 0.0: -0 becomes 0, so equal positions are equal bits
  mesh_.normals.push_back(core::vec3(normal));
  return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
}

void MeshBuilder::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const core::vec3 &pa = mesh_.positions[a], &pb = mesh_.positions[b], &pc = mesh_.positions[c];
  if (pa == pb || pb == pc || pc == pa) return;
  mesh_.indices.insert(mesh_.indices.end(), {a, b, c});
}

void MeshBuilder::add_flat_quad(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& d) {
  const dvec3 points[] = {a, b, c, d};
  add_flat_polygon(points, glm::cross(c - a, d - b));
}

void MeshBuilder::add_flat_polygon(std::span<const dvec3> points, const dvec3& normal) {
  if (points.size() < 3) return;
  const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
  for (const dvec3& p : points) add({p, normal});
  std::uint32_t low = first, high = first + static_cast<std::uint32_t>(points.size()) - 1;
  while (low + 1 < high) {
    add_triangle(low, low + 1, high);
    ++low;
    if (low + 1 >= high) break;
    add_triangle(low, high - 1, high);
    --high;
  }
}

void MeshBuilder::add_disc(std::span<const dvec2> circle, double radius, double z, double up) {
  std::vector<dvec3> rim;
  for (std::size_t i = 0; i + 1 < circle.size(); ++i)
    rim.emplace_back(radius * circle[up > 0.0 ? i : circle.size() - 1 - i], z);
  add_flat_polygon(rim, {0.0, 0.0, up});
}

core::Mesh MeshBuilder::finish() {
  constexpr std::uint32_t kUnused = core::kNone;
  std::vector<std::uint32_t> place(mesh_.positions.size(), kUnused);
  for (const std::uint32_t v : mesh_.indices) place[v] = 0;
  std::uint32_t used = 0;
  for (std::size_t v = 0; v < place.size(); ++v) {
    if (place[v] == kUnused) continue;
    mesh_.positions[used] = mesh_.positions[v];
    mesh_.normals[used] = mesh_.normals[v];
    place[v] = used++;
  }
  mesh_.positions.resize(used);
  mesh_.normals.resize(used);
  for (std::uint32_t& v : mesh_.indices) v = place[v];
  return std::exchange(mesh_, {});
}

}  // namespace sightline::gpuprims
