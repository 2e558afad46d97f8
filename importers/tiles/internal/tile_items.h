// Internal to the writer of 3D Tiles: what tiles are made of.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "sightline/core/scene.h"

namespace sightline::importers {

/// An item that shows, or a part of one whose mesh is too large for a tile.
struct TileItem {
  core::ItemId id;
  core::NodeId node;
  core::Scene::ItemState state;
  const core::Mesh* mesh = nullptr;  ///< its triangles; null: it is a primitive
  core::AabbD box = {};              ///< in the world
  double size = 0.0;                 ///< no two points of it are farther apart, metres
};

struct TileItems {
  std::vector<TileItem> items;
  std::deque<core::Mesh> pieces;  ///< of large meshes
  std::array<std::uint64_t, core::kKindCount> of_kind{};
  std::uint64_t left_out = 0, divided = 0;
};

/// All items of the subtree that show, meshes divided where they have more than `most_triangles`; 0: they stay whole.
/// Stops where `proceed`, which takes the share that is done, returns false.
TileItems collect_tile_items(const core::Scene& scene, core::NodeId top, std::uint32_t most_triangles,
                             const std::function<bool(double)>& proceed);

}  // namespace sightline::importers
