// Levels of a mesh as bytes, which scene caches keep (docs/reference/scene-cache-format.md) and which come with a mesh
// (core::MeshExtras::stored).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/lod/mesh_levels.h"

namespace sightline::lod {

/// Raised when build_levels() makes something else of a mesh, and when encode() writes it otherwise.
inline constexpr std::uint32_t kLevelsVersion = 4;

/// How much of a mesh's levels.
enum class LevelRange : std::uint8_t {
  kClusters,  ///< build_clusters(): the mesh itself in clusters
  kAll,       ///< build_levels()
};

/// Some 5 bytes a triangle of all levels. `levels`: of build_levels().
SIGHTLINE_API std::vector<std::byte> encode(const MeshLevels& levels);

/// What encode() was given, or the clusters of the mesh alone. Fails on bytes that are not safe to use with the mesh,
/// whoever wrote them: afterwards indices are in range, groups and clusters agree, each cut ends, and errors only grow
/// towards coarser levels. That errors are true, and that the levels are this mesh's, only checksums say. Memory
/// follows the number of bytes. About 10 ns a triangle.
SIGHTLINE_API core::Expected<MeshLevels> decode(std::span<const std::byte> bytes, const core::Mesh& mesh,
                                                LevelRange range = LevelRange::kAll);

/// The levels that came with the mesh; empty where none did, or where they cannot be used.
SIGHTLINE_API MeshLevels stored_levels_of(const core::Mesh& mesh, LevelRange range = LevelRange::kAll);

/// The levels that came with the mesh; where there are none, they are built by so many threads until `stop`.
SIGHTLINE_API MeshLevels levels_of(const core::Mesh& mesh, LevelRange range, int threads = 0,
                                   const std::stop_token& stop = {});

/// Whether build_levels() makes coarser levels: the library was built with meshoptimizer.
SIGHTLINE_API bool builds_levels();

}  // namespace sightline::lod
