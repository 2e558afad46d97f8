// Reader of glTF 2.0, as text (.gltf) and binary (.glb).
//
// What becomes what. A node named after the file holds the nodes of the default scene (`scene`, else the first, else
// all nodes without a parent) with their names and transforms. A node without a name takes its mesh's. Extras that are
// strings, numbers or booleans become attributes. Each mesh primitive becomes one core::Mesh, however many nodes and
// instances (EXT_mesh_gpu_instancing) show it. A primitive with the same accessors as another is the same mesh.
// Triangles, strips and fans are read with any accessor that glTF allows (sparse, normalised, KHR_mesh_quantization).
// Points and lines are left out with a warning. Units are metres, up is y.
//
// Materials keep name, base colour and, when blended, alpha. A base colour texture counts as its mean. The texture is
// decoded (PNG, JPEG; one at a time, and only when something uses it), averaged in linear light, and multiplied with
// the factor. A texture that is missing, damaged or above 64 Mpixel is a warning. Colours of vertices (COLOR_0)
// multiply the base colour. A triangle shows the mean of its corners, and the triangles of each colour become a mesh of
// their own, shared as the whole would be. Of more than kMostFaceColours colours (a smooth shade, say) the average
// counts, with a warning. Skins, morph targets, animations, cameras and lights are ignored. A required extension that
// is not known is damage. EXT_meshopt_compression and KHR_draco_mesh_compression are known where the build has their
// libraries; elsewhere data without an uncompressed twin is damage that names the extension.
//
// Plant models in the open convention of web viewers for industry (gltf_collections.h) keep their primitives analytic.
//
// Errors say where: "file: /nodes/12/mesh: expected …, found …". Damage is anything that contradicts the glTF 2.0
// specification and matters here. A lenient import leaves out what holds the damage. Buffers and images are looked for
// beside the model and below, or in data URIs; nothing else is opened.
//
// Built on nlohmann-json and stb_image. tinygltf, which is built on the same two, was tried: it spends 2 KiB on a
// material of two bytes, cannot be cancelled, stops at the first damage and copies every buffer.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "sightline/importers/import.h"

namespace sightline::importers {

/// Peak memory of read_gltf, the scene's included, stays below this many times the bytes of the file and of the files
/// that it names and of those that decompression makes of them (at most 64 for each byte of the file and 1 MiB), plus
/// kGltfMemoryConstant and what the libraries take while they decompress. A texture adds 4 bytes per pixel while it is
/// averaged. Files that ask for more (one accessor drawn a million times) are refused, lenient or not.
inline constexpr std::size_t kGltfMemoryFactor = 256;
inline constexpr std::size_t kGltfMemoryConstant = std::size_t{32} << 20;

/// Reads a whole file image. `path` names the node and says where buffers and images lie. On error the scene is
/// untouched. Text that is not JSON, and an asset that is not of version 2, are errors, lenient or not.
core::Expected<ImportReport> read_gltf(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                       core::Scene& scene, core::NodeId parent, const ImportOptions& options = {});

}  // namespace sightline::importers
