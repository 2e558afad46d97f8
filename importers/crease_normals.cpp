#include "sightline/importers/internal/crease_normals.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include "sightline/core/internal/disjoint_sets.h"
#include "sightline/importers/internal/unit_or_zero.h"

namespace sightline::importers {
namespace {

using core::dvec3;

/// Bent edges of regular solids, such as prisms of twelve sides, are to be on one side of a round angle.
constexpr double kBendRounding = 1e-3;  // radians

/// Corners by the vertex at which they are: those of vertex v are corners[first[v]] up to corners[first[v + 1]].
struct CornersOfVertices {
  std::vector<std::uint32_t> first, corners;

  CornersOfVertices(std::span<const std::uint32_t> vertices, std::size_t count)
      : first(count + 1), corners(vertices.size()) {
    for (const std::uint32_t vertex : vertices) ++first[vertex + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t corner = 0; corner < vertices.size(); ++corner) corners[next[vertices[corner]]++] = corner;
  }
  std::span<const std::uint32_t> of(std::size_t vertex) const {
    return std::span(corners).subspan(first[vertex], first[vertex + 1] - first[vertex]);
  }
};

class CreaseNormals {
 public:
  CreaseNormals(core::Mesh& mesh, double angle)
      : mesh_(mesh),
        least_cosine_(std::cos(std::min(angle + kBendRounding, 3.14159))),
        vertices_(welded_indices(mesh)) {}

  void run() {
    measure_faces();
    const CornersOfVertices around(vertices_, mesh_.positions.size());
    std::vector<core::vec3> positions, normals;
    for (std::size_t vertex = 0; vertex < mesh_.positions.size(); ++vertex) {
      const auto corners = around.of(vertex);
      group(corners);
      sums_.assign(corners.size(), dvec3(0.0));
      for (std::uint32_t i = 0; i < corners.size(); ++i)
        sums_[sets_.find(i)] += weight(corners[i]) * faces_[corners[i] / 3];
      number_.assign(corners.size(), core::kNone);
      for (std::uint32_t i = 0; i < corners.size(); ++i) {
        std::uint32_t& number = number_[sets_.find(i)];
        if (number == core::kNone) {
          number = std::uint32_t(positions.size());
          positions.push_back(mesh_.positions[vertex]);
          normals.emplace_back(unit_or_zero(sums_[sets_.find(i)]));
        }
        mesh_.indices[corners[i]] = number;
      }
    }
    mesh_.positions = std::move(positions);
    mesh_.normals = std::move(normals);
  }

 private:
  using Edge = std::pair<std::uint32_t, std::uint32_t>;  // the vertex at its other end; corner
  static constexpr std::size_t kMostFaces = 16;          // at an edge

  static std::vector<std::uint32_t> welded_indices(const core::Mesh& mesh) {
    const std::vector<std::uint32_t> welded = core::weld(mesh.positions);
    std::vector<std::uint32_t> vertices(mesh.indices.size());
    std::transform(mesh.indices.begin(), mesh.indices.end(), vertices.begin(),
                   [&](auto index) { return welded[index]; });
    return vertices;
  }
  static std::uint32_t next(std::uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }
  static std::uint32_t previous(std::uint32_t corner) { return corner % 3 == 0 ? corner + 2 : corner - 1; }
  dvec3 place(std::uint32_t corner) const { return dvec3(mesh_.positions[vertices_[corner]]); }

  void measure_faces() {
    faces_.resize(vertices_.size() / 3);
    for (std::uint32_t face = 0; face < faces_.size(); ++face) {
      const dvec3 a = place(3 * face);
      faces_[face] = unit_or_zero(glm::cross(place(3 * face + 1) - a, place(3 * face + 2) - a));
    }
  }

  /// The angle of a face at one of its corners.
  double weight(std::uint32_t corner) const {
    const dvec3 here = place(corner);
    const dvec3 a = unit_or_zero(place(next(corner)) - here), b = unit_or_zero(place(previous(corner)) - here);
    return std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
  }

  /// Joins corners at one vertex whose faces share an edge there that is no crease. An edge of more faces than any
  /// model has is one, so that the time stays in proportion to the faces.
  void group(std::span<const std::uint32_t> corners) {
    sets_.reset(corners.size());
    edges_.clear();
    for (std::uint32_t i = 0; i < corners.size(); ++i) {
      edges_.push_back({vertices_[next(corners[i])], i});
      edges_.push_back({vertices_[previous(corners[i])], i});
    }
    std::sort(edges_.begin(), edges_.end());
    for (std::size_t i = 0, end = 0; i < edges_.size(); i = end) {
      while (end < edges_.size() && edges_[end].first == edges_[i].first) ++end;
      if (end - i <= kMostFaces) join(corners, std::span(edges_).subspan(i, end - i));
    }
  }

  /// Joins faces that share an edge.
  void join(std::span<const std::uint32_t> corners, std::span<const Edge> edges) {
    for (std::size_t i = 0; i < edges.size(); ++i)
      for (std::size_t k = i + 1; k < edges.size(); ++k) {
        const std::uint32_t a = edges[i].second, b = edges[k].second;
        if (glm::dot(faces_[corners[a] / 3], faces_[corners[b] / 3]) >= least_cosine_) sets_.merge(a, b);
      }
  }

  core::Mesh& mesh_;
  double least_cosine_;
  std::vector<std::uint32_t> vertices_;  // by corner, one for each place
  std::vector<dvec3> faces_;             // their normals; zero where they have no area
  // The edges of the corners at one vertex, numbered from 0.
  std::vector<Edge> edges_;
  core::DisjointSets sets_;
  std::vector<std::uint32_t> number_;
  std::vector<dvec3> sums_;
};

}  // namespace

void add_crease_normals(core::Mesh& mesh, double angle) {
  assert(mesh.normals.empty() && angle >= 0.0);
  CreaseNormals(mesh, angle).run();
}

}  // namespace sightline::importers
