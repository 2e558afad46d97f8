// Internal to the writer of 3D Tiles: the glTF file of one tile.
#pragma once

#include <cstdint>
#include <span>

#include "sightline/core/scene.h"
#include "sightline/importers/gltf/internal/gltf_output.h"
#include "sightline/importers/tiles/internal/tile_shapes.h"

namespace sightline::importers {

struct TileCounts {
  std::uint64_t triangles = 0, instances = 0;
  double largest_chord_error = 0.0;
};

/// Floats of content, and what viewers compute of them in floats, are off by at most this share of the largest
/// coordinate.
inline constexpr double kContentRounding = 4e-6;

/// One file shows items, relative to `centre` and turned to y up, by what stands for them within `error`.
struct TileContent {
  std::span<const TileItem* const> items;
  double error;
  core::dvec3 centre;
};
TileCounts write_tile_content(const core::Scene& scene, core::NodeId top, const TileContent& content,
                              TileShapes& shapes, GltfOutput& output);

}  // namespace sightline::importers
