#include "sightline/importers/gltf/internal/gltf_compression.h"

#include <cstring>
#include <memory>

#include <fmt/format.h>

#ifdef SIGHTLINE_HAVE_MESHOPT
#include <meshoptimizer.h>
#endif
#ifdef SIGHTLINE_HAVE_DRACO
#include <draco/compression/decode.h>
#endif

namespace sightline::importers {
namespace {

using Bytes = std::span<const std::byte>;

/// Reads a number of seven bits a byte, lowest first, and moves on. False at the end of the bytes.
bool read_varint(Bytes& bytes, std::uint64_t& value) {
  value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    if (bytes.empty()) return false;
    const auto byte = std::to_integer<std::uint64_t>(bytes[0]);
    bytes = bytes.subspan(1);
    value |= (byte & 0x7f) << shift;
    if ((byte & 0x80) == 0) return true;
  }
  return false;
}

}  // namespace

bool is_gltf_compression(std::string_view extension) {
  return extension == kMeshopt || extension == kDraco;
}

core::Expected<void> can_decompress([[maybe_unused]] std::string_view extension) {
#ifndef SIGHTLINE_HAVE_MESHOPT
  if (extension == kMeshopt)
    return core::fail(fmt::format("{} cannot be read: this build is without meshoptimizer", kMeshopt));
#endif
#ifndef SIGHTLINE_HAVE_DRACO
  if (extension == kDraco) return core::fail(fmt::format("{} cannot be read: this build is without Draco", kDraco));
#endif
  return {};
}

// --- meshopt -------------------------------------------------------------------------------------------------------

#ifdef SIGHTLINE_HAVE_MESHOPT

core::Expected<std::vector<std::byte>> decompress_meshopt(Bytes bytes, const MeshoptView& view) {
  const auto bad = [&](std::string_view expected, std::string_view found) {
    return core::fail(fmt::format("{}: expected {}, found {}", kMeshopt, expected, found));
  };
  // The library asserts what is checked here.
  const bool attributes = view.mode == "ATTRIBUTES", triangles = view.mode == "TRIANGLES";
  if (!attributes && !triangles && view.mode != "INDICES")
    return bad("the mode ATTRIBUTES, TRIANGLES or INDICES", view.mode);
  if (attributes && (view.stride == 0 || view.stride > 256 || view.stride % 4 != 0))
    return bad("a byteStride of 4, 8, … 256", std::to_string(view.stride));
  if (!attributes && view.stride != 2 && view.stride != 4)
    return bad("a byteStride of 2 or 4", std::to_string(view.stride));
  if (triangles && view.count % 3 != 0) return bad("three corners for each triangle", std::to_string(view.count));
  const bool plain = view.filter.empty() || view.filter == "NONE";
  const bool octahedral = view.filter == "OCTAHEDRAL", turns = view.filter == "QUATERNION";
  if (!plain && !octahedral && !turns && view.filter != "EXPONENTIAL")
    return bad("the filter NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL", view.filter);
  if ((octahedral && view.stride != 4 && view.stride != 8) || (turns && view.stride != 8) || (!plain && !attributes))
    return bad("attributes of the filter's size", fmt::format("a byteStride of {}", view.stride));

  std::vector<std::byte> out(view.count * view.stride);
  const auto* from = reinterpret_cast<const unsigned char*>(bytes.data());
  const int failed = attributes  ? meshopt_decodeVertexBuffer(out.data(), view.count, view.stride, from, bytes.size())
                     : triangles ? meshopt_decodeIndexBuffer(out.data(), view.count, view.stride, from, bytes.size())
                                 : meshopt_decodeIndexSequence(out.data(), view.count, view.stride, from, bytes.size());
  if (failed != 0)
    return bad(fmt::format("a stream of {} {} elements of {} bytes", view.mode, view.count, view.stride),
               fmt::format("{} bytes that are none", bytes.size()));
  if (octahedral) meshopt_decodeFilterOct(out.data(), view.count, view.stride);
  if (turns) meshopt_decodeFilterQuat(out.data(), view.count, view.stride);
  if (!plain && !octahedral && !turns) meshopt_decodeFilterExp(out.data(), view.count, view.stride);
  return out;
}

#else

core::Expected<std::vector<std::byte>> decompress_meshopt(Bytes, const MeshoptView&) {
  return tl::unexpected(can_decompress(kMeshopt).error());
}

#endif

// --- Draco ---------------------------------------------------------------------------------------------------------

core::Expected<DracoCounts> draco_counts(Bytes bytes) {
  constexpr std::size_t kHeader = 11, kMajor = 5, kMinor = 6, kEncoder = 7, kMethod = 8, kFlags = 10;
  constexpr std::byte kMesh{1}, kEdgebreaker{1}, kMetadata{0x80};
  const auto bad = [](std::string_view message) { return core::fail(fmt::format("{}: {}", kDraco, message)); };
  if (bytes.size() < kHeader || std::memcmp(bytes.data(), "DRACO", 5) != 0)
    return bad("expected a Draco stream, found something else");
  if (bytes[kMajor] != std::byte{2} || bytes[kMinor] != std::byte{2} || bytes[kEncoder] != kMesh)
    return bad(fmt::format("expected a mesh of version 2.2, found version {}.{}, kind {}", int(bytes[kMajor]),
                           int(bytes[kMinor]), int(bytes[kEncoder])));
  if ((bytes[kFlags] & kMetadata) != std::byte{0}) return bad("expected a mesh without metadata");
  const bool edgebreaker = bytes[kMethod] == kEdgebreaker;
  DracoCounts counts;
  Bytes rest = bytes.subspan(kHeader);
  if (edgebreaker && !rest.empty()) rest = rest.subspan(1);  // kind of traversal
  const bool read = edgebreaker ? read_varint(rest, counts.vertices) && read_varint(rest, counts.faces)
                                : read_varint(rest, counts.faces) && read_varint(rest, counts.vertices);
  if (!read) return bad("expected counts of vertices and faces, found the end of the stream");
  return counts;
}

#ifdef SIGHTLINE_HAVE_DRACO

namespace {

template <class T>
bool take_values(const draco::Mesh& mesh, const draco::PointAttribute& attribute, int components,
                 std::vector<std::byte>& to) {
  T values[16] = {};
  const std::size_t size = sizeof(T) * std::size_t(components);
  to.resize(mesh.num_points() * size);
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex at = attribute.mapped_index(draco::PointIndex(i));
    if (at.value() >= attribute.size() || !attribute.ConvertValue<T>(at, std::int8_t(components), values)) return false;
    std::memcpy(to.data() + i * size, values, size);
  }
  return true;
}

}  // namespace

core::Expected<DracoMesh> decompress_draco(Bytes bytes, std::span<const DracoAttribute> wanted) {
  const auto bad = [](std::string_view message) { return core::fail(fmt::format("{}: {}", kDraco, message)); };
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return bad(decoded.status().error_msg_string());
  const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
  DracoMesh out;
  out.vertices = mesh->num_points();
  out.corners.reserve(3 * std::size_t(mesh->num_faces()));
  for (std::uint32_t f = 0; f < mesh->num_faces(); ++f)
    for (const draco::PointIndex& corner : mesh->face(draco::FaceIndex(f))) out.corners.push_back(corner.value());
  for (const DracoAttribute& as : wanted) {
    const draco::PointAttribute* attribute = mesh->GetAttributeByUniqueId(as.id);
    if (!attribute) return bad(fmt::format("expected an attribute with the id {}", as.id));
    if (int(attribute->num_components()) != as.components)
      return bad(fmt::format("attribute {}: expected {} components, found {}", as.id, as.components,
                             int(attribute->num_components())));
    out.attributes.emplace_back();
    const auto take = [&]<class T>(T) {
      return take_values<T>(*mesh, *attribute, as.components, out.attributes.back());
    };
    if (!with_type(as.type, take))
      return bad(
          fmt::format("attribute {}: expected a value for each vertex that its accessor's type can hold", as.id));
  }
  return out;
}

#else

core::Expected<DracoMesh> decompress_draco(Bytes, std::span<const DracoAttribute>) {
  return tl::unexpected(can_decompress(kDraco).error());
}

#endif

}  // namespace sightline::importers
