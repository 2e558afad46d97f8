// Internal to the glTF writer: a file while it is put together. Objects are JSON text from the start: a tree of values
// would take ten times the memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/core/affine.h"
#include "sightline/core/error.h"
#include "sightline/core/mesh.h"
#include "sightline/core/scene.h"

namespace sightline::importers {

/// A string as JSON, quotes included. Bytes that are not UTF-8 are replaced.
std::string json_string(std::string_view text);

class GltfOutput {
 public:
  /// `compress`: numbers as streams of EXT_meshopt_compression, which readers must know then, where that is smaller and
  /// the build has the library. Triangles may be turned, and normals become bytes (KHR_mesh_quantization).
  explicit GltfOutput(bool compress = false);

  // Each adds one object and returns its index.
  std::uint32_t positions(std::span<const core::vec3> values);                         ///< all finite, at least one
  std::uint32_t normals(std::span<const core::vec3> values);                           ///< made unit vectors
  std::uint32_t indices(std::span<const std::uint32_t> values, std::size_t vertices);  ///< of triangles
  std::uint32_t features(std::span<const float> values);                 ///< a whole number for each vertex, below 2^24
  std::uint32_t numbers(std::span<const float> values, int components);  ///< 1, 3, 4 or 16 for each instance
  std::uint32_t colours(std::span<const std::uint8_t> rgba);             ///< for instances, normalised
  std::uint32_t material(const core::Material& material);
  std::uint32_t mesh(std::string_view text) { return add(meshes_, text); }
  /// `text`: members of the object but for "children", joined by commas. `parent` comes first; kNone: of the scene.
  std::uint32_t node(std::uint32_t parent, std::string_view text);
  void use_extension(std::string_view name, bool required);
  /// Extension of the file itself. `text`: its object.
  void add_extension(std::string_view name, std::string_view text);
  /// Buffer view of its own that no accessor refers to, for an extension. `stride`: bytes of a number in it.
  std::uint32_t table(std::span<const std::byte> bytes, std::size_t stride);

  /// Leaves out nodes: keep[i] of node i. A kept node's parent must be kept.
  void prune(const std::vector<bool>& keep);
  std::uint32_t node_count() const { return std::uint32_t(parents_.size()); }
  std::uint32_t parent(std::uint32_t node) const { return parents_[node]; }

  /// Writes a .glb, or a .gltf and its .bin, and returns the bytes of both.
  core::Expected<std::uint64_t> write(const std::filesystem::path& path);

 private:
  struct Array {
    std::string text;
    std::uint32_t count = 0;
  };
  enum class Kind : std::uint8_t {
    kPositions,
    kCountedPositions,
    kNormals,
    kByteNormals,
    kFeatures,
    kIndices,
    kNumbers,
    kColours,
    kTable
  };
  struct View {
    Kind kind;
    std::size_t stride;            // bytes of an element
    std::vector<std::byte> bytes;  // as they are written
    std::size_t raw_bytes = 0;     // that readers make of a compressed one; 0: it is not compressed
    bool is_corners() const { return kind == Kind::kIndices; }
    /// Only readers of the stream know what its bytes mean.
    bool is_filtered() const { return kind == Kind::kCountedPositions || kind == Kind::kByteNormals; }
  };
  /// Where a view lies in its buffer.
  struct Place {
    std::uint64_t offset = 0, raw_offset = 0;
  };

  static std::uint32_t add(Array& array, std::string_view text);
  std::uint32_t accessor(Kind kind, std::span<const std::byte> data, std::size_t stride, std::string_view members);
  std::uint32_t floats(Kind kind, std::span<const float> values, int components, std::string_view bounds = {});
  View& view_for(Kind kind, std::size_t stride);
  void compress();
  std::vector<Place> places() const;
  std::string view_text(const View& view, const Place& place) const;
  std::string node_text() const;
  std::string text(std::string_view uri) const;

  Array accessors_, materials_, meshes_;
  std::vector<View> views_;
  bool compress_, compressed_ = false;  // it may be, and some view is
  std::string extensions_;              // members
  std::string nodes_;                   // their members, back to back
  std::vector<std::uint64_t> ends_;
  std::vector<std::uint32_t> parents_;
  std::vector<std::string> used_, required_;
};

/// "matrix" or "translation" of a node, with all digits; empty for the identity.
std::string gltf_transform(const core::Affine& map);

}  // namespace sightline::importers
