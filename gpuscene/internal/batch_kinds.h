// The kinds of batches; each has one program. kBatchKinds has one row per kind with all that differs between them. The
// renderer, the GPU culler, the plan and the shaders read it.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/core/primitive.h"
#include "sightline/gpuprims/internal/packing.h"

namespace sightline::gpuscene {

/// In the order of kBatchKinds.
enum class BatchKind : std::uint8_t {
  kCylinder,
  kSnout,
  kCircularTorus,
  kSphereCap,
  kRectangularTorus,
  kPyramid,
  kBox,
  kLine,
  kMesh,
};
inline constexpr int kBatchKindCount = 9;

/// How the items of a batch become fragments.
enum class Drawn : std::uint8_t {
  kRayCast,    ///< a proxy each, whose fragments cast rays
  kLines,      ///< two vertices each
  kTriangles,  ///< an indexed draw each, from the mesh pool
};

struct BatchKindInfo {
  std::string_view name;  ///< in capitals, a define of the kind's shaders
  Drawn drawn;
  std::uint32_t item_kinds;  ///< one bit 1 << core::Kind for each kind of items
};

constexpr std::uint32_t item_kind_bits(auto... kinds) {
  return ((1u << unsigned(kinds)) | ...);
}

inline constexpr std::array<BatchKindInfo, kBatchKindCount> kBatchKinds = {{
    {"cylinder", Drawn::kRayCast, item_kind_bits(core::Kind::kCylinder)},
    {"snout", Drawn::kRayCast, item_kind_bits(core::Kind::kSnout)},
    {"circular_torus", Drawn::kRayCast, item_kind_bits(core::Kind::kCircularTorus)},
    {"sphere_cap", Drawn::kRayCast,
     item_kind_bits(core::Kind::kSphere, core::Kind::kSphericalDish, core::Kind::kEllipticalDish)},
    {"rectangular_torus", Drawn::kRayCast, item_kind_bits(core::Kind::kRectangularTorus)},
    {"pyramid", Drawn::kRayCast, item_kind_bits(core::Kind::kPyramid)},
    {"box", Drawn::kRayCast, item_kind_bits(core::Kind::kBox)},
    {"line", Drawn::kLines, item_kind_bits(core::Kind::kLine)},
    {"mesh", Drawn::kTriangles, item_kind_bits(core::Kind::kFacetGroup, core::Kind::kMesh)},
}};

constexpr const BatchKindInfo& info_of(BatchKind kind) {
  return kBatchKinds[std::size_t(kind)];
}
constexpr std::string_view name_of(BatchKind kind) {
  return info_of(kind).name;
}
constexpr bool is_ray_cast(BatchKind kind) {
  return info_of(kind).drawn == Drawn::kRayCast;
}
/// Texels of each record, the same for all kinds of items that share a batch.
constexpr int texels_per_record(BatchKind kind) {
  return gpuprims::texels_per_item(core::Kind(std::countr_zero(info_of(kind).item_kinds)));
}
constexpr std::size_t record_bytes(BatchKind kind) {
  return std::size_t(texels_per_record(kind)) * sizeof(gpuprims::Texel);
}
inline constexpr auto kBatchOfKind = [] {
  std::array<BatchKind, core::kKindCount> batches{};
  for (int kind = 0; kind < core::kKindCount; ++kind)
    for (int batch = 0; batch < kBatchKindCount; ++batch)
      if ((kBatchKinds[std::size_t(batch)].item_kinds >> kind & 1u) != 0) batches[std::size_t(kind)] = BatchKind(batch);
  return batches;
}();
/// The batch that draws items of a kind.
constexpr BatchKind batch_of(core::Kind kind) {
  return kBatchOfKind[std::size_t(kind)];
}

/// Defines for the shaders of one kind: "CYLINDER" and so on, and "TEXELS_PER_RECORD 4".
std::vector<std::string> batch_defines(BatchKind kind);
/// Defines for shaders of several kinds: "CYLINDER_KIND 0u" and so on, with the value of each BatchKind.
std::vector<std::string> batch_kind_defines();

}  // namespace sightline::gpuscene
