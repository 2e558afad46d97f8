// Some triangles of a mesh as a mesh of their own. Internal: for what makes levels, and writers.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/core/mesh.h"

namespace sightline::lod {

/// Keeps the vertices that triangles use, in the order of their first use.
class PartOfMesh {
 public:
  explicit PartOfMesh(const core::Mesh& mesh) : from_(mesh), number_of_(mesh.positions.size(), core::kNone) {}

  /// Appends a corner. All corners go to the same mesh until clear().
  void add(std::uint32_t corner, core::Mesh& to) {
    std::uint32_t& number = number_of_[corner];
    if (number == core::kNone) {
      number = std::uint32_t(to.positions.size());
      used_.push_back(corner);
      to.positions.push_back(from_.positions[corner]);
      if (!from_.normals.empty()) to.normals.push_back(from_.normals[corner]);
    }
    to.indices.push_back(number);
  }
  /// Begins the next part, in time of the last one.
  void clear() {
    for (const std::uint32_t corner : used_) number_of_[corner] = core::kNone;
    used_.clear();
  }

 private:
  const core::Mesh& from_;
  std::vector<std::uint32_t> number_of_;  // by vertex: its number in the part
  std::vector<std::uint32_t> used_;
};

}  // namespace sightline::lod
