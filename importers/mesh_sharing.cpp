#include "sightline/importers/internal/mesh_sharing.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>

namespace sightline::importers {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec3;
using core::Mesh;

/// Most meshes of one hash that are compared with a new one. Beyond that, copies are not found and are added as new
/// meshes.
constexpr std::size_t kMostTried = 16;

/// Meshes whose sizes differ by more than this factor are not shared: factors of a placement must stay far from where a
/// scene refuses them.
constexpr double kLargestScale = 1e6;

std::uint64_t mixed(std::uint64_t hash, std::uint64_t value) {
  hash = (hash ^ value) * 0x9e3779b97f4a7c15u;
  return hash ^ (hash >> 32);
}

std::uint64_t mixed(std::uint64_t hash, std::span<const std::uint32_t> values) {
  hash = mixed(hash, values.size());
  for (const std::uint32_t value : values) hash = mixed(hash, value);
  return hash;
}

std::uint64_t topology_hash(const Mesh& mesh) {
  std::uint64_t hash = mixed(mesh.positions.size(), mesh.normals.size());
  hash = mixed(hash, mesh.indices);
  hash = mixed(hash, mesh.contour_sizes);
  return mixed(hash, mesh.polygon_contours);
}

/// Three numbers near 1 that no similarity changes: sums of the vertices about their mean, with each vertex added or
/// subtracted by a fixed pattern, in proportion to one another and to the mesh's size.
std::array<double, 3> invariants(const Mesh& mesh) {
  dvec3 sum(0.0), first(0.0), second(0.0);
  double first_signs = 0.0, second_signs = 0.0, squares = 0.0;
  std::uint64_t pattern = 0x243f6a8885a308d3u;
  const dvec3 near(mesh.positions.empty() ? core::vec3(0.0f) : mesh.positions[0]);
  for (const core::vec3& position : mesh.positions) {
    const dvec3 p = dvec3(position) - near;
    pattern = pattern * 6364136223846793005u + 1442695040888963407u;
    const double s = pattern >> 63 ? 1.0 : -1.0, t = pattern >> 62 & 1 ? 1.0 : -1.0;
    sum += p, first += s * p, second += t * p;
    first_signs += s, second_signs += t;
    squares += glm::dot(p, p);
  }
  const auto count = double(mesh.positions.size());
  const dvec3 mean = sum / std::max(count, 1.0);
  first -= first_signs * mean, second -= second_signs * mean;
  const double size = squares - count * glm::dot(mean, mean);
  if (!(size > 0.0)) return {};
  return {glm::dot(first, first) / size, glm::dot(second, second) / size, glm::dot(first, second) / size};
}

constexpr double kBinsPerUnit = 1024.0;
constexpr double kBinMargin = 0.02;  // of a bin: rounding changes the invariants far less

std::uint64_t bin_hash(std::uint64_t topology, const std::array<double, 3>& shape,
                       const std::array<double, 3>& margins = {}) {
  std::uint64_t hash = topology;
  for (std::size_t i = 0; i < 3; ++i) {
    const double bin = std::floor(shape[i] * kBinsPerUnit + margins[i]);
    hash = mixed(hash, std::uint64_t(std::int64_t(std::clamp(bin, -1e15, 1e15))));
  }
  return hash;
}

/// The bins that may hold meshes of about this shape: one, or near a bin's edge two, four or eight.
std::vector<std::uint64_t> bins_near(std::uint64_t topology, const std::array<double, 3>& shape) {
  std::vector<std::uint64_t> bins;
  for (int corner = 0; corner < 8; ++corner) {
    std::array<double, 3> margins;
    for (int i = 0; i < 3; ++i) margins[std::size_t(i)] = corner >> i & 1 ? kBinMargin : -kBinMargin;
    const std::uint64_t hash = bin_hash(topology, shape, margins);
    if (std::find(bins.begin(), bins.end(), hash) == bins.end()) bins.push_back(hash);
  }
  return bins;
}

template <class Distance>
std::uint32_t farthest(const Mesh& mesh, Distance&& distance) {
  std::uint32_t found = 0;
  double largest = -1.0;
  for (std::uint32_t i = 0; i < mesh.positions.size(); ++i)
    if (const double d = distance(dvec3(mesh.positions[i])); d > largest) largest = d, found = i;
  return found;
}

MeshAnchors anchors_of(const Mesh& mesh) {
  MeshAnchors anchors;
  if (mesh.positions.empty()) return anchors;
  const dvec3 first(mesh.positions[0]);
  anchors.a = farthest(mesh, [&](const dvec3& p) { return glm::distance(p, first); });
  const dvec3 a(mesh.positions[anchors.a]);
  anchors.b = farthest(mesh, [&](const dvec3& p) { return glm::distance(p, a); });
  const dvec3 ab = dvec3(mesh.positions[anchors.b]) - a;
  anchors.c = farthest(mesh, [&](const dvec3& p) { return glm::length(glm::cross(ab, p - a)); });
  return anchors;
}

/// Orthonormal axes along ab and towards c. Nothing when the three points lie on one line.
std::optional<dmat3> axes(const dvec3& ab, const dvec3& ac) {
  const dvec3 x = ab / glm::length(ab);
  const dvec3 across = ac - glm::dot(ac, x) * x;
  const double distance = glm::length(across);
  if (!(distance > 1e-9 * glm::length(ab))) return {};
  const dvec3 y = across / distance;
  return dmat3(x, y, glm::cross(x, y));
}

double diagonal(const Mesh& mesh) {
  core::AabbD box;
  for (const core::vec3& p : mesh.positions) box.grow(dvec3(p));
  return box.empty() ? 0.0 : glm::length(box.size());
}

/// Largest distance of a mapped vertex from where it belongs. Nothing when that is beyond the tolerance.
std::optional<double> misfit(const Mesh& mesh, const Mesh& copy, const Affine& copy_from_mesh, double tolerance) {
  double largest = 0.0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const dvec3 off = core::transform_point(copy_from_mesh, dvec3(mesh.positions[i])) - dvec3(copy.positions[i]);
    largest = std::max(largest, glm::dot(off, off));
    if (!(largest <= tolerance * tolerance)) return {};
  }
  const dmat3 turned = copy_from_mesh.linear / std::cbrt(glm::determinant(copy_from_mesh.linear));
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    const core::vec3 off = core::vec3(turned * dvec3(mesh.normals[i])) - copy.normals[i];
    if (!(glm::dot(off, off) <= kSharingNormalTolerance * kSharingNormalTolerance)) return {};
  }
  return std::sqrt(largest);
}

bool same_bits(std::span<const core::vec3> a, std::span<const core::vec3> b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

struct Fit {
  Affine copy_from_mesh;
  double error = 0.0;
};

/// Tries a pure shift first, then the similarity that three anchors give.
std::optional<Fit> fit(const Mesh& mesh, const Mesh& copy, const MeshAnchors& anchors, bool exact) {
  if (mesh.indices != copy.indices || mesh.contour_sizes != copy.contour_sizes ||
      mesh.polygon_contours != copy.polygon_contours || mesh.positions.size() != copy.positions.size() ||
      mesh.normals.size() != copy.normals.size())
    return {};
  if (same_bits(mesh.positions, copy.positions) && same_bits(mesh.normals, copy.normals)) return Fit{};
  if (exact) return {};
  const double tolerance = kSharingTolerance * diagonal(copy);
  const dvec3 mesh_a(mesh.positions[anchors.a]), copy_a(copy.positions[anchors.a]);
  const Affine shift = core::translation(copy_a - mesh_a);
  if (const auto error = misfit(mesh, copy, shift, tolerance)) return Fit{shift, *error};

  const auto mesh_at = [&](std::uint32_t i) { return dvec3(mesh.positions[i]) - mesh_a; };
  const auto copy_at = [&](std::uint32_t i) { return dvec3(copy.positions[i]) - copy_a; };
  const dvec3 mesh_ab = mesh_at(anchors.b), copy_ab = copy_at(anchors.b);
  const double scale = glm::length(copy_ab) / glm::length(mesh_ab);
  if (!(scale >= 1.0 / kLargestScale && scale <= kLargestScale)) return {};  // false when there is no length
  const auto mesh_axes = axes(mesh_ab, mesh_at(anchors.c));
  const auto copy_axes = axes(copy_ab, copy_at(anchors.c));
  if (!mesh_axes || !copy_axes) return {};
  Affine map;
  map.linear = scale * (*copy_axes * glm::transpose(*mesh_axes));
  map.origin = copy_a - map.linear * mesh_a;
  if (const auto error = misfit(mesh, copy, map, tolerance)) return Fit{map, *error};
  return {};
}

}  // namespace

core::Expected<MeshSharing::Use> MeshSharing::add(core::Mesh mesh) {
  if (copies_ == MeshCopies::kApart)
    return scene_.add_mesh(std::move(mesh)).map([](core::MeshId id) { return Use{id, {}, 0.0, false}; });
  const std::uint64_t topology = topology_hash(mesh);
  const std::array<double, 3> shape = invariants(mesh);
  for (const std::uint64_t hash : bins_near(topology, shape)) {
    const auto bin = known_.find(hash);
    if (bin == known_.end()) continue;
    for (std::size_t i = 0; i < std::min(bin->second.size(), kMostTried); ++i) {
      const Known& known = bin->second[i];
      if (const auto found = fit(scene_.mesh(known.mesh), mesh, known.anchors, copies_ == MeshCopies::kExact))
        return Use{known.mesh, found->copy_from_mesh, found->error, true};
    }
  }
  const MeshAnchors anchors = anchors_of(mesh);
  const auto added = scene_.add_mesh(std::move(mesh));
  if (!added) return tl::unexpected(added.error());
  known_[bin_hash(topology, shape)].push_back({*added, anchors});
  return Use{*added, {}, 0.0, false};
}

}  // namespace sightline::importers
