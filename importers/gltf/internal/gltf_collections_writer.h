// Internal to the glTF writer: plant models in the convention of web viewers for industry, the way back of
// gltf_collections.h. gltf_writer.h says what becomes what.
#pragma once

#include <span>

#include "sightline/core/scene.h"
#include "sightline/importers/gltf/gltf_writer.h"
#include "sightline/importers/gltf/internal/gltf_output.h"

namespace sightline::importers {

core::Expected<void> write_collections(const core::Scene& scene, core::NodeId top, const GltfWriteOptions& options,
                                       GltfOutput& output, GltfWriteReport& report);

/// An item, the node that it hangs on, and what it inherits.
struct CollectionItem {
  core::ItemId id;
  core::NodeId node;
  core::Scene::ItemState state;
};

struct CollectionPart {
  std::span<const CollectionItem> items;
  core::dvec3 centre;  ///< coordinates are relative to it
};

/// Writes some items, with the nodes above them below `top`. Items without anything to draw are counted as left out.
core::Expected<void> write_collections(const core::Scene& scene, core::NodeId top, const CollectionPart& part,
                                       const GltfWriteOptions& options, GltfOutput& output, GltfWriteReport& report);

}  // namespace sightline::importers
