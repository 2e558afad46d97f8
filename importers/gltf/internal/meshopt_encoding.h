// Internal to the writers of glTF: streams of EXT_meshopt_compression, by the meshoptimizer library. All but normals
// are lossless.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sightline/core/mesh.h"

namespace sightline::importers {

/// Whether this build has the library. Without it the functions return nothing.
bool encodes_meshopt();

/// The mode ATTRIBUTES: elements of `stride` bytes, a multiple of 4 up to 256.
std::vector<std::byte> encode_meshopt_attributes(std::span<const std::byte> elements, std::size_t stride);

/// The mode TRIANGLES: three corners each, at least one triangle, whose corners may come back in turned order.
/// `stride`: bytes of a corner, 2 or 4, lowest first.
std::vector<std::byte> encode_meshopt_triangles(std::span<const std::byte> corners, std::size_t stride);

/// Unit vectors as the filter OCTAHEDRAL takes them: elements of four bytes. They come back as normalised bytes, within
/// kMeshoptNormalError radians.
std::vector<std::byte> octahedral_normals(std::span<const core::vec3> normals);
inline constexpr double kMeshoptNormalError = 0.025;

/// Positions as the filter EXPONENTIAL takes them: elements of twelve bytes, without loss. Nothing where no power of
/// two is so small that all coordinates are its multiples, and so large that 24 bits count them.
std::vector<std::byte> exponential_positions(std::span<const core::vec3> positions);

/// Orders vertices and triangles so that streams of them are short. Does not change what the mesh shows. Nothing
/// without the library.
void order_for_meshopt(core::Mesh& mesh);

}  // namespace sightline::importers
