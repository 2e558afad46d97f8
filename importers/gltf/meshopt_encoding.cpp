#include "sightline/importers/gltf/internal/meshopt_encoding.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#ifdef SIGHTLINE_HAVE_MESHOPT
#include <meshoptimizer.h>
#endif

namespace sightline::importers {

#ifdef SIGHTLINE_HAVE_MESHOPT

namespace {

unsigned char* raw(std::vector<std::byte>& bytes) {
  return reinterpret_cast<unsigned char*>(bytes.data());
}

/// The exponent of the largest power of two of which all values are multiples; 0 where all are 0.
int common_exponent(std::span<const float> values) {
  constexpr std::uint32_t kMantissa = 0x7fffff, kLeading = 0x800000;
  int least = 127;
  for (const float value : values) {
    if (value == 0.0f) continue;
    const auto bits = std::bit_cast<std::uint32_t>(value);
    least = std::min(least, std::ilogb(value) - 23 + std::countr_zero((bits & kMantissa) | kLeading));
  }
  return least == 127 ? 0 : least;
}

}  // namespace

bool encodes_meshopt() {
  return true;
}

std::vector<std::byte> encode_meshopt_attributes(std::span<const std::byte> elements, std::size_t stride) {
  meshopt_encodeVertexVersion(0);  // the one that the extension has; libraries differ in what they write by default
  const std::size_t count = elements.size() / stride;
  std::vector<std::byte> bytes(meshopt_encodeVertexBufferBound(count, stride));
  bytes.resize(meshopt_encodeVertexBuffer(raw(bytes), bytes.size(), elements.data(), count, stride));
  return bytes;
}

std::vector<std::byte> encode_meshopt_triangles(std::span<const std::byte> corners, std::size_t stride) {
  meshopt_encodeIndexVersion(1);
  std::vector<std::uint32_t> numbers(corners.size() / stride);
  for (std::size_t i = 0; i < numbers.size(); ++i) std::memcpy(&numbers[i], corners.data() + i * stride, stride);
  const std::uint32_t last = *std::max_element(numbers.begin(), numbers.end());
  std::vector<std::byte> bytes(meshopt_encodeIndexBufferBound(numbers.size(), std::size_t(last) + 1));
  bytes.resize(meshopt_encodeIndexBuffer(raw(bytes), bytes.size(), numbers.data(), numbers.size()));
  return bytes;
}

std::vector<std::byte> octahedral_normals(std::span<const core::vec3> normals) {
  constexpr int kBits = 8;
  std::vector<glm::vec4> from;
  from.reserve(normals.size());
  for (const core::vec3& n : normals) from.emplace_back(n, 0.0f);
  std::vector<std::byte> bytes(4 * normals.size());
  meshopt_encodeFilterOct(bytes.data(), normals.size(), 4, kBits, &from[0].x);
  return bytes;
}

std::vector<std::byte> exponential_positions(std::span<const core::vec3> positions) {
  const std::span<const float> values(&positions[0].x, 3 * positions.size());
  const int exponent = common_exponent(values);
  if (exponent < -100) return {};
  std::vector<std::byte> bytes(4 * values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const float count = std::ldexp(values[i], -exponent);
    if (!(std::abs(count) < float(1 << 23))) return {};
    const std::uint32_t word = std::uint32_t(exponent) << 24 | (std::uint32_t(std::int32_t(count)) & 0xffffff);
    std::memcpy(bytes.data() + 4 * i, &word, 4);
  }
  return bytes;
}

void order_for_meshopt(core::Mesh& mesh) {
  if (mesh.indices.empty()) return;
  const std::size_t vertices = mesh.positions.size(), corners = mesh.indices.size();
  meshopt_optimizeVertexCache(mesh.indices.data(), mesh.indices.data(), corners, vertices);
  std::vector<unsigned> places(vertices);
  const std::size_t used = meshopt_optimizeVertexFetchRemap(places.data(), mesh.indices.data(), corners, vertices);
  meshopt_remapIndexBuffer(mesh.indices.data(), mesh.indices.data(), corners, places.data());
  for (auto* values : {&mesh.positions, &mesh.normals}) {
    if (values->empty()) continue;
    meshopt_remapVertexBuffer(values->data(), values->data(), vertices, sizeof(core::vec3), places.data());
    values->resize(used);
  }
}

#else

bool encodes_meshopt() {
  return false;
}

std::vector<std::byte> encode_meshopt_attributes(std::span<const std::byte>, std::size_t) {
  return {};
}

std::vector<std::byte> encode_meshopt_triangles(std::span<const std::byte>, std::size_t) {
  return {};
}

std::vector<std::byte> octahedral_normals(std::span<const core::vec3>) {
  return {};
}

std::vector<std::byte> exponential_positions(std::span<const core::vec3>) {
  return {};
}

void order_for_meshopt(core::Mesh&) {}

#endif

}  // namespace sightline::importers
