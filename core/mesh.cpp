#include "sightline/core/mesh.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <string>

namespace sightline::core {
namespace {

std::uint64_t sum(std::span<const std::uint32_t> sizes) {
  return std::accumulate(sizes.begin(), sizes.end(), std::uint64_t(0));
}

/// For each vertex a number that vertices at the same position share.
std::vector<std::uint32_t> welded(const std::vector<vec3>& positions) {
  std::vector<std::uint32_t> order(positions.size()), weld(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    const vec3 &p = positions[a], &q = positions[b];
    return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
  };
  std::sort(order.begin(), order.end(), before);
  for (std::size_t i = 0; i < order.size(); ++i)
    weld[order[i]] = i > 0 && !before(order[i - 1], order[i]) ? weld[order[i - 1]] : order[i];
  return weld;
}

struct Edge {
  std::uint64_t ends;  // lower vertex number first
  int direction;       // +1 from the lower to the higher, -1 back
};

bool is_closed(const Mesh& mesh) {
  const std::vector<std::uint32_t> weld = welded(mesh.positions);
  std::vector<Edge> edges;
  edges.reserve(mesh.indices.size());
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const std::uint32_t a = weld[mesh.indices[i]], b = weld[mesh.indices[i % 3 == 2 ? i - 2 : i + 1]];
    if (a != b) edges.push_back({std::uint64_t(std::min(a, b)) << 32 | std::max(a, b), a < b ? 1 : -1});
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.ends < b.ends; });
  for (std::size_t i = 0; i < edges.size();) {
    int balance = 0;
    const std::uint64_t ends = edges[i].ends;
    for (; i < edges.size() && edges[i].ends == ends; ++i) balance += edges[i].direction;
    if (balance != 0) return false;
  }
  return !edges.empty();
}

/// Six times the volume, of a closed mesh independent of where it lies; from the first vertex, for precision.
double signed_volume(const Mesh& mesh) {
  const dvec3 origin(mesh.positions[mesh.indices[0]]);
  double sum = 0.0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto corner = [&](std::size_t k) { return dvec3(mesh.positions[mesh.indices[i + k]]) - origin; };
    sum += glm::dot(corner(0), glm::cross(corner(1), corner(2)));
  }
  return sum;
}

}  // namespace

Expected<void> validate(const Mesh& mesh) {
  const std::uint64_t positions = mesh.positions.size(), contours = mesh.contour_sizes.size();
  const auto refuse = [&](const std::string& expected, std::uint64_t found) {
    return fail("mesh \"" + mesh.name + "\": expected " + expected + ", found " + std::to_string(found));
  };
  if (!mesh.normals.empty() && mesh.normals.size() != positions)
    return refuse("no normals or one for each of " + std::to_string(positions) + " positions", mesh.normals.size());
  if (mesh.indices.size() % 3 != 0) return refuse("three indices for each triangle", mesh.indices.size());
  std::uint32_t largest = 0;
  for (const std::uint32_t index : mesh.indices) largest = std::max(largest, index);
  if (!mesh.indices.empty() && largest >= positions)
    return refuse("indices below " + std::to_string(positions) + ", the number of positions", largest);
  if (sum(mesh.polygon_contours) != contours)
    return refuse("polygons that hold all of " + std::to_string(contours) + " contours", sum(mesh.polygon_contours));
  if (mesh.is_facet_group() && sum(mesh.contour_sizes) != positions)
    return refuse("contours that hold all of " + std::to_string(positions) + " positions", sum(mesh.contour_sizes));
  return {};
}

Enclosure enclosure(const Mesh& mesh) {
  if (!is_closed(mesh)) return Enclosure::kNothing;
  return signed_volume(mesh) >= 0.0 ? Enclosure::kInside : Enclosure::kOutside;
}

}  // namespace sightline::core
