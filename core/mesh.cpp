#include "sightline/core/mesh.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <span>
#include <string>

#include "sightline/core/internal/hash.h"

namespace sightline::core {
namespace {

std::uint64_t sum(std::span<const std::uint32_t> sizes) {
  return std::accumulate(sizes.begin(), sizes.end(), std::uint64_t(0));
}

std::uint64_t hash(const vec3& p) {
  const vec3 q = p + 0.0f;  // -0 becomes +0
  return mixed(mixed(std::uint64_t(std::bit_cast<std::uint32_t>(q.x)) << 32 | std::bit_cast<std::uint32_t>(q.y)) ^
               std::bit_cast<std::uint32_t>(q.z));
}

struct Edge {
  std::uint64_t ends;  // lower vertex number first
  int direction;       // +1 from the lower to the higher, -1 back
};

bool is_closed(const Mesh& mesh) {
  const std::vector<std::uint32_t> welded = weld(mesh.positions);
  std::vector<Edge> edges;
  edges.reserve(mesh.indices.size());
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const std::uint32_t a = welded[mesh.indices[i]], b = welded[mesh.indices[i % 3 == 2 ? i - 2 : i + 1]];
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

/// Six times the volume, which does not depend on where a closed mesh lies. Measured from the first vertex, for
/// precision.
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

std::vector<std::uint32_t> weld(std::span<const vec3> positions) {
  const std::size_t mask = std::bit_ceil(2 * positions.size() + 1) - 1;
  std::vector<std::uint32_t> table(mask + 1, kNone), welded(positions.size());
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    std::size_t place = hash(positions[i]) & mask;
    while (table[place] != kNone && positions[table[place]] != positions[i]) place = (place + 1) & mask;
    if (table[place] == kNone) table[place] = i;
    welded[i] = table[place];
  }
  return welded;
}

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
