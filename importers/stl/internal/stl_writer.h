// Writer of binary STL: what the reader of STL reads. Triangles alone, in metres, z up, with their normals; no names,
// no colours, and positions as single floats, which are off by up to 6e-8 of their distance from the origin.
#pragma once

#include <filesystem>

#include "sightline/importers/internal/world_meshes.h"

namespace sightline::importers {

/// Writes a temporary file beside `path`, and renames it at the end. Fails where the path cannot be written, on more
/// than 2^32 - 1 triangles, and as for_each_world_mesh() does. Two passes over the model: the first one counts.
core::Expected<WorldMeshReport> write_stl(const WorldMeshes& meshes, const std::filesystem::path& path);

}  // namespace sightline::importers
