// Internal to the writer of 3D Tiles: names and attributes of what a tile shows, as a property table of
// EXT_structural_metadata.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "sightline/core/scene.h"
#include "sightline/importers/gltf/internal/gltf_output.h"

namespace sightline::importers {

/// The nodes that a tile's items hang on: its features.
class TileParts {
 public:
  /// `top`: whose parents are not told.
  TileParts(const core::Scene& scene, core::NodeId top) : scene_(scene), top_(top) {}

  /// The feature id of a node.
  std::uint32_t row(core::NodeId node);
  /// Members of an extension that refers to features: the object of "featureIds", whose ids are attribute 0.
  static std::string feature_ids(std::span<const float> ids);
  /// Adds the table. Nothing where there are no features.
  void write(GltfOutput& output);

 private:
  core::NodeId parent_of(core::NodeId node) const;
  void add_parents();

  const core::Scene& scene_;
  core::NodeId top_;
  std::vector<core::NodeId> nodes_;  // by row
  std::unordered_map<std::uint32_t, std::uint32_t> rows_;
};

}  // namespace sightline::importers
