#include "sightline/importers/internal/polygon_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "sightline/core/affine.h"
#include "sightline/importers/internal/triangulate.h"
#include "sightline/importers/internal/unit_or_zero.h"

namespace sightline::importers {
namespace {

bool usable(const core::dvec3& p) {
  return std::abs(p.x) <= kLargestCoordinate && std::abs(p.y) <= kLargestCoordinate &&
         std::abs(p.z) <= kLargestCoordinate;  // false for NaN
}

class Centring {
 public:
  explicit Centring(const PolygonMesh& polygons) : from_(polygons) {}

  CentredMesh run() {
    number_vertices();
    copy_vertices();
    for_each_face(from_, [&](std::size_t first, std::uint32_t size) {
      if (good(first, size)) add_face(first, size);
    });
    if (to_.flat > 0) drop_unused_vertices();
    mend_normals();
    return std::move(to_);
  }

 private:
  bool good(std::size_t first, std::uint32_t size) const {
    if (size < 3) return false;
    for (std::size_t i = first; i < first + size; ++i)
      if (!usable(from_.positions[from_.corners[i]])) return false;
    return true;
  }

  /// Marks the vertices that good faces use, then numbers them in the file's order, so that near vertices stay near.
  void number_vertices() {
    place_.assign(from_.positions.size(), core::kNone);
    std::size_t indices = 0;
    for_each_face(from_, [&](std::size_t first, std::uint32_t size) {
      if (!good(first, size)) {
        ++to_.dropped;
        return;
      }
      indices += 3 * (std::size_t{size} - 2);
      for (std::size_t i = first; i < first + size; ++i) place_[from_.corners[i]] = 0;
    });
    to_.mesh.indices.reserve(indices);
    for (std::uint32_t& place : place_)
      if (place != core::kNone) place = used_++;
  }

  void copy_vertices() {
    core::AabbD box;
    const bool with_normals = !from_.normals.empty();
    for (std::size_t i = 0; i < place_.size(); ++i)
      if (place_[i] != core::kNone) box.grow(from_.positions[i]);
    if (!box.empty()) to_.centre = box.centre();
    to_.mesh.positions.reserve(used_);
    if (with_normals) to_.mesh.normals.reserve(used_);
    for (std::size_t i = 0; i < place_.size(); ++i) {
      if (place_[i] == core::kNone) continue;
      to_.mesh.positions.emplace_back(from_.positions[i] - to_.centre);
      if (with_normals) to_.mesh.normals.push_back(from_.normals[i]);
    }
  }

  void add_face(std::size_t first, std::uint32_t size) {
    if (size == 3) {
      for (std::size_t i = first; i < first + 3; ++i) to_.mesh.indices.push_back(place_[from_.corners[i]]);
      return;
    }
    vertices_.clear(), outline_.clear(), triangles_.clear();
    for (std::size_t i = first; i < first + size; ++i) {
      vertices_.push_back(place_[from_.corners[i]]);
      outline_.push_back(to_.mesh.positions[vertices_.back()]);
    }
    triangulate_polygon(outline_, std::span(&size, 1), 0, triangles_);
    if (triangles_.empty()) ++to_.flat;
    for (const std::uint32_t t : triangles_) to_.mesh.indices.push_back(vertices_[t]);
  }

  /// Bounds follow from the vertices, and count what is drawn.
  void drop_unused_vertices() {
    core::Mesh& mesh = to_.mesh;
    std::vector<std::uint32_t> place(mesh.positions.size(), core::kNone);
    for (const std::uint32_t i : mesh.indices) place[i] = 0;
    std::uint32_t used = 0;
    for (std::uint32_t i = 0; i < place.size(); ++i) {
      if (place[i] == core::kNone) continue;
      mesh.positions[used] = mesh.positions[i];
      if (!mesh.normals.empty()) mesh.normals[used] = mesh.normals[i];
      place[i] = used++;
    }
    mesh.positions.resize(used);
    if (!mesh.normals.empty()) mesh.normals.resize(used);
    for (std::uint32_t& i : mesh.indices) i = place[i];
  }

  /// A normal that is not finite becomes that of the triangles about its vertex, so that the others can stay.
  void mend_normals() {
    core::Mesh& mesh = to_.mesh;
    const auto is_bad = [](const core::vec3& normal) { return !core::is_finite(core::dvec3(normal)); };
    if (std::none_of(mesh.normals.begin(), mesh.normals.end(), is_bad)) return;
    std::vector<bool> bad(mesh.normals.size());
    for (std::size_t i = 0; i < bad.size(); ++i) {
      bad[i] = is_bad(mesh.normals[i]);
      if (!bad[i]) continue;
      mesh.normals[i] = core::vec3(0.0f);
      ++to_.mended_normals;
    }
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      const std::array corners{mesh.positions[mesh.indices[i]], mesh.positions[mesh.indices[i + 1]],
                               mesh.positions[mesh.indices[i + 2]]};
      const core::vec3 across(unit_or_zero(newell_normal(corners)));
      for (std::size_t corner = i; corner < i + 3; ++corner)
        if (bad[mesh.indices[corner]]) mesh.normals[mesh.indices[corner]] += across;
    }
    for (std::size_t i = 0; i < bad.size(); ++i)
      if (bad[i]) mesh.normals[i] = core::vec3(unit_or_zero(core::dvec3(mesh.normals[i])));
  }

  const PolygonMesh& from_;
  CentredMesh to_;
  std::vector<std::uint32_t> place_;  // from a vertex of the file to its index in the mesh
  std::uint32_t used_ = 0;
  std::vector<std::uint32_t> vertices_, triangles_;  // of one face
  std::vector<core::vec3> outline_;
};

}  // namespace

CentredMesh centred(const PolygonMesh& polygons) {
  return Centring(polygons).run();
}

}  // namespace sightline::importers
