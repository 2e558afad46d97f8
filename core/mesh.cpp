#include "sightline/core/mesh.h"

#include <algorithm>
#include <numeric>

namespace sightline::core {
namespace {

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

Enclosure enclosure(const Mesh& mesh) {
  if (!is_closed(mesh)) return Enclosure::kNothing;
  return signed_volume(mesh) >= 0.0 ? Enclosure::kInside : Enclosure::kOutside;
}

}  // namespace sightline::core
