// Internal to the glTF reader: triangles of mesh primitives, and per-instance attributes as a table.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sightline/importers/gltf/internal/gltf_document.h"
#include "sightline/importers/internal/face_colours.h"

namespace sightline::importers {

/// What a mesh primitive draws. Two primitives with equal sources are the same geometry.
struct GltfSources {
  std::uint64_t positions = 0, normals = core::kNone, colours = core::kNone, indices = core::kNone, mode = 4;
  bool draws_triangles() const { return mode >= 4 && positions != core::kNone; }
  friend auto operator<=>(const GltfSources&, const GltfSources&) = default;
};

/// `primitive` stands at `where`. Positions are kNone where it names none, as glTF allows.
GltfSources gltf_sources(const Json& primitive, const std::string& where);

/// Corners of the primitive's triangles, three each, all within its positions.
std::vector<std::uint32_t> gltf_triangles(ImportJob& job, GltfDocument& document, const GltfSources& sources,
                                          const std::string& where);

/// The colour of each triangle, the mean of its corners' COLOR_0, as sRGB; none when the primitive has no such
/// attribute. COLOR_0 is in linear light; integers without `normalized` count as normalised, since older writers leave
/// it out. `corners` as gltf_triangles() gave them.
std::vector<PackedColour> gltf_face_colours(GltfDocument& document, const GltfSources& sources,
                                            const std::vector<std::uint32_t>& corners, const std::string& where);

/// What one number of a colour counts as: 1 for all that is not finite.
double gltf_colour_channel(double value, const GltfAccessor& of);

/// A mesh of the vertices that `corners` refer to, in order of their indices. Normals that cannot be read become a
/// warning.
PolygonMesh gltf_mesh(ImportJob& job, GltfDocument& document, const GltfSources& sources,
                      std::vector<std::uint32_t> corners, const std::string& where);

/// Numbers for each instance, read a block of rows at a time.
class GltfTable {
 public:
  struct Column {
    std::string_view name;
    int components;
    bool required = false;
  };
  /// Finds the columns among `attributes` (name -> accessor). All columns present must have the same length.
  void open(GltfDocument& document, const Json& attributes, std::span<const Column> columns, const std::string& where);
  std::uint64_t count() const { return count_; }
  bool has(std::size_t column) const { return accessors_[column] != nullptr; }
  const GltfAccessor& accessor(std::size_t column) const { return *accessors_[column]; }

  static constexpr std::uint64_t kBlock = 1024;
  /// Reads rows first … first + kBlock - 1, as far as there are any, and returns how many.
  std::uint64_t load(std::uint64_t first);
  /// Row of the loaded block; null when the column is missing.
  const double* row(std::size_t column, std::uint64_t i) const {
    return has(column) ? &blocks_[column][i * std::uint64_t(accessors_[column]->components)] : nullptr;
  }

 private:
  std::vector<const GltfAccessor*> accessors_;
  std::vector<std::vector<double>> blocks_;
  std::uint64_t count_ = 0;
};

/// The affine map of 16 numbers by columns; the last row is assumed to be 0 0 0 1.
core::Affine gltf_affine(const double* matrix);
/// The map of a translation, a rotation (quaternion x y z w of any length but 0) and a scale; null means none.
core::Affine gltf_affine(const double* translation, const double* rotation, const double* scale);

}  // namespace sightline::importers
