// Internal to the glTF writer: a file while it is put together. Objects are JSON text from the start: a tree of values
// would take ten times the memory.
#pragma once

#include <array>
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
  // Each adds one object and returns its index.
  std::uint32_t positions(std::span<const core::vec3> values);  ///< all finite, at least one
  std::uint32_t normals(std::span<const core::vec3> values);    ///< made unit vectors
  std::uint32_t indices(std::span<const std::uint32_t> values, std::size_t vertices);
  std::uint32_t numbers(std::span<const float> values, int components);  ///< 1, 3, 4 or 16 for each instance
  std::uint32_t colours(std::span<const std::uint8_t> rgba);             ///< for instances, normalised
  std::uint32_t material(const core::Material& material);
  std::uint32_t mesh(std::string_view text) { return add(meshes_, text); }
  /// `text`: members of the object but for "children", joined by commas. `parent` comes first; kNone: of the scene.
  std::uint32_t node(std::uint32_t parent, std::string_view text);
  void use_extension(std::string_view name, bool required);

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
  struct View {
    std::vector<std::byte> bytes;
    std::string members;  // of the buffer view: stride and target
  };
  enum ViewKind : std::size_t { kPositions, kNormals, kSmallIndices, kIndices, kNumbers, kColours, kViews };

  static std::uint32_t add(Array& array, std::string_view text);
  std::uint32_t accessor(ViewKind kind, const void* data, std::size_t size, std::string_view members);
  std::string node_text() const;
  std::string text(std::uint64_t binary_bytes, std::string_view uri) const;

  Array accessors_, materials_, meshes_;
  std::array<View, kViews> views_;
  std::vector<ViewKind> order_;  // of the views in use
  std::string nodes_;            // their members, back to back
  std::vector<std::uint64_t> ends_;
  std::vector<std::uint32_t> parents_;
  std::vector<std::string> used_, required_;
};

/// "matrix" or "translation" of a node, with all digits; empty for the identity.
std::string gltf_transform(const core::Affine& map);

}  // namespace sightline::importers
