// Options of the GPU culler.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace sightline::culling {

/// How the GPU culls. Both give the same answer in the same order, so that images are equal to the bit.
enum class GpuVariant : std::uint8_t {
  kGeometry,  ///< vertex and geometry stages with transform feedback
  kCompute,   ///< compute shaders
};
constexpr std::string_view name_of(GpuVariant variant) {
  return variant == GpuVariant::kGeometry ? "geometry" : "compute";
}

struct GpuCullerConfig {
  /// None: the variant that costs less in this context, measured when the culler is made. Pass it to later cullers of
  /// the same context (GpuCuller::variant(), if variant_settled()), so that it is measured once.
  std::optional<GpuVariant> variant;

  bool operator==(const GpuCullerConfig&) const = default;
};

}  // namespace sightline::culling
