// Internal to the glTF reader: what packaged libraries decompress. A build without one of them refuses what needs it by
// the extension's name.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/importers/internal/byte_order.h"

namespace sightline::importers {

inline constexpr std::string_view kMeshopt = "EXT_meshopt_compression", kDraco = "KHR_draco_mesh_compression";

/// Whether the extension is one of these two.
bool is_gltf_compression(std::string_view extension);
/// Fails, with the library that is missing, when this build cannot decompress the extension's data.
core::Expected<void> can_decompress(std::string_view extension);

/// A buffer view of EXT_meshopt_compression.
struct MeshoptView {
  std::uint64_t count = 0, stride = 0;
  std::string mode, filter;
};
/// The view's count * stride bytes. Any bytes may come in. Fails on sizes, modes and filters that the extension does
/// not have, and on bytes that are not a stream of the mode.
core::Expected<std::vector<std::byte>> decompress_meshopt(std::span<const std::byte> bytes, const MeshoptView& view);

/// Vertices and faces that a Draco stream claims to hold. Fails on what is no mesh of version 2.2, the one that glTF
/// has, and on metadata, which would stand before the counts.
struct DracoCounts {
  std::uint64_t faces = 0, vertices = 0;
};
core::Expected<DracoCounts> draco_counts(std::span<const std::byte> bytes);

/// An attribute to take out of a Draco mesh: its unique id, and what its accessor says.
struct DracoAttribute {
  std::uint32_t id = 0;
  NumberType type = NumberType::kFloat;
  int components = 3;
};
struct DracoMesh {
  std::uint64_t vertices = 0;
  std::vector<std::uint32_t> corners;
  std::vector<std::vector<std::byte>> attributes;  // in the order asked for, packed
};
core::Expected<DracoMesh> decompress_draco(std::span<const std::byte> bytes, std::span<const DracoAttribute> wanted);

}  // namespace sightline::importers
