// Writes models in the format that a file's name asks for.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"
#include "sightline/importers/import.h"
#include "sightline/importers/tiles/tiles_writer.h"

namespace sightline::importers {

struct WriteOptions {
  double tolerance = 0.001;              ///< of triangles for primitives, metres: ObjWriteOptions::tolerance
  bool collections = false;              ///< GltfWriteOptions::collections
  bool tiles = false;                    ///< 3D Tiles in a folder, whatever its name
  bool compress = true;                  ///< TilesWriteOptions::compress
  bool levels = false;                   ///< SlcWriteOptions::levels
  const ImportReport* report = nullptr;  ///< SlcWriteOptions::report
  std::function<bool(double)> progress = {};
};

struct WriteReport {
  /// Triangles that stand for primitives.
  struct Tessellated {
    std::uint64_t triangles = 0, vertices = 0;
    double largest_chord_error = 0.0;  ///< metres
  };
  std::array<std::uint64_t, core::kKindCount> items{};  ///< written, by kind
  std::uint64_t left_out = 0, bytes = 0;
  std::uint64_t attributes_lost = 0;           ///< nodes whose attributes the format cannot hold
  std::optional<Tessellated> triangles = {};   ///< none in RVM and scene caches, which keep primitives
  std::optional<std::uint64_t> analytic = {};  ///< of glTF and 3D Tiles: items that are rows of parameters
  std::optional<TilesWriteReport> tiles = {};
};

/// Writes what lies below a node, whole or not at all; all of the scene where the format is a scene cache (.slc). Other
/// names end in .rvm, .obj, .glb, .gltf, .stl or .ply. Fails on other names, and as the format's writer does.
SIGHTLINE_API core::Expected<WriteReport> write_file(const core::Scene& scene, core::NodeId node,
                                                     const std::filesystem::path& path,
                                                     const WriteOptions& options = {});

}  // namespace sightline::importers
