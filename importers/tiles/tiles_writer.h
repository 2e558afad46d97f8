// Writer of 3D Tiles 1.1 (OGC 22-025r4): a folder with tileset.json and glTF 2.0 files, which web viewers stream.
//
// The tree of tiles. Items are in spatial order, as a snapshot has them, and a tile's are a run of that order: so they
// lie together. A leaf holds its items in full: meshes as they are, primitives as triangles within `tolerance`. An
// inner tile stands for all that lies below it, within its geometricError E: items whose boxes' diagonals are at most E
// are left out, primitives are cut within E, and meshes are drawn by the level of detail whose proven error is at most
// E (lod/mesh_levels.h). E is the least power of two times the tolerance by which the tile is as small as a leaf must
// be. Tiles replace each other (refine REPLACE): those of any cut through the tree show each item once, or leave it out
// with a size that the tile's geometricError covers. geometricError never grows towards the leaves, where it is 0.
//
// The promise of E. Each point of what a tile draws lies within E of the surface that it stands for, and the other way
// round, or belongs to an item that has no two points farther apart than E and is left out. A viewer that draws tiles
// whose error is at most n pixels shows an image in which nothing is off by more, and misses nothing that is larger.
// For meshes this is proved, for primitives it is what gpuprims promises of their triangles. Rounding is part of E. The
// tolerance of primitives in leaves, which is in no geometricError, is asset.extras.tolerance of tileset.json; RVM's
// circles are within it, other surfaces to second order.
//
// Coordinates. The tileset is in metres with z up; content has y up, as glTF wants. Each tile has a centre of its own
// in doubles, in `transform`, and its floats are relative to it. Boxes hold the tile's items and all tiles below it,
// also after all rounding. Centres and boxes lie on a grid fine enough not to matter, so that boxes nest exactly.
//
// Content. Items that share their triangles are instances (EXT_mesh_gpu_instancing) where that saves vertices; all
// others of one material are one mesh. Features (EXT_mesh_features, EXT_instance_features) are the nodes that items
// hang on. A property table (EXT_structural_metadata) has a row for each of them, and then for the nodes above them:
// its `name`, its attributes as strings, `node`, the same number for the same node in all tiles, and `parent`, the row
// of the node above, its own where there is none. Materials have base colour, alpha and both sides. Where the build has
// meshoptimizer, and unless `compress` is false, numbers are compressed (EXT_meshopt_compression): all without loss but
// normals, which become bytes (KHR_mesh_quantization) within 0.025 radians, which geometricError says nothing of.
//
// With `collections` content follows the convention of web viewers for industry instead (gltf_writer.h): primitives are
// rows of parameters, exact in all tiles, and meshes are whole. Such content has z up, and the root's transform takes
// back what viewers of 3D Tiles turn. Lines are left out.
//
// As in the glTF writer, hidden items and those on no layer but those hidden by default are left out, and so are meshes
// without triangles or with vertices that are not finite.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"

namespace sightline::importers {

struct TilesWriteOptions {
  /// Largest distance in metres between an analytic primitive and the triangles of leaves; finite and > 0.
  double tolerance = 0.001;
  /// Primitives as rows of parameters, for web viewers that know them.
  bool collections = false;
  /// False: content that viewers without a decoder for meshopt can read.
  bool compress = true;
  /// Most triangles of a tile, > 0. An item counts as 32 triangles at least. Larger meshes are divided,
  /// larger primitives have tiles of their own.
  std::uint32_t tile_triangles = 131'072;
  /// Called like ImportOptions::progress: returning false cancels with kCancelled as the message.
  std::function<bool(double)> progress = {};
};

struct TilesWriteReport {
  std::array<std::uint64_t, core::kKindCount> items{};  ///< written, by kind, each counted once
  std::uint64_t left_out = 0;                           ///< items hidden or without triangles
  std::uint64_t analytic = 0;                           ///< of the items: written as rows of parameters
  std::uint64_t divided = 0;                            ///< of the items: of meshes too large for a tile
  std::uint64_t tiles = 0, leaves = 0, levels = 0;      ///< levels: tiles on the longest way from the root to a leaf
  std::uint64_t triangles = 0, leaf_triangles = 0;      ///< drawn by all tiles, and by leaves; instances count
  std::uint64_t instances = 0;                          ///< items in leaves that share the triangles of others
  std::uint64_t bytes = 0, leaf_bytes = 0, largest_file = 0;  ///< of all files, of leaves, of the largest file
  double root_error = 0.0;                                    ///< geometricError of the root, metres
  double whole_error = 0.0;  ///< that of the tileset: what is missing where nothing is drawn
  /// Largest distance in metres between an edge in a leaf and the primitive that it stands for.
  double largest_chord_error = 0.0;
};

/// Writes tileset.json and tiles/N.glb into `folder`, which appears whole or not at all: it is written under another
/// name beside it. An empty folder and a tileset of this writer are replaced. Fails where `folder` is anything else, or
/// cannot be written, where a number of the options is out of range, and where nothing is to be shown. Memory: the
/// scene, some 300 bytes an item, levels of detail of its meshes (about as many indices again), copies of meshes that
/// are too large for a tile, and one tile.
SIGHTLINE_API core::Expected<TilesWriteReport> write_tiles(const core::Scene& scene, core::NodeId node,
                                                           const std::filesystem::path& folder,
                                                           const TilesWriteOptions& options = {});

}  // namespace sightline::importers
