// Writer of binary PLY, little-endian: what the reader of PLY reads. Positions in the world as doubles, metres, z up;
// normals where all meshes have them; the materials' colours as red, green, blue and alpha of the vertices. No names.
#pragma once

#include <filesystem>

#include "sightline/importers/internal/world_meshes.h"

namespace sightline::importers {

/// As write_stl(); fails on more than 2^31 - 1 vertices.
core::Expected<WorldMeshReport> write_ply(const WorldMeshes& meshes, const std::filesystem::path& path);

}  // namespace sightline::importers
