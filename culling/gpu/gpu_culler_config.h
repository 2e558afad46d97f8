// What can be chosen of the GPU culler.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace sightline::culling {

/// How the GPU culls. Both give the same answer in the same order, so that pictures are equal to the bit.
enum class GpuForm : std::uint8_t {
  kGeometry,  ///< vertex and geometry stages with transform feedback
  kCompute,   ///< compute shaders
};
constexpr std::string_view name_of(GpuForm form) {
  return form == GpuForm::kGeometry ? "geometry" : "compute";
}

/// How item boxes lie in GPU memory. All are conservative: the boxes of the smaller ones contain the floats, and what
/// that keeps too much is in docs/hybrid-culling.md. Beside them there are boxes of clusters, 24 bytes per 64 items,
/// and where the scene uses layers another 4 bytes per item.
enum class GpuBoundsForm : std::uint8_t {
  kFloat,       ///< 24 bytes per item
  kCompact,     ///< 8 bytes per item: corners on a grid of 1024 steps across the cluster's box
  kParameters,  ///< 0.25 bytes per item: computed from the records that draw it; meshes and lines as kCompact
};
constexpr std::string_view name_of(GpuBoundsForm form) {
  return form == GpuBoundsForm::kFloat ? "float" : form == GpuBoundsForm::kCompact ? "compact" : "parameters";
}

struct GpuCullerConfig {
  /// None: the one that costs less in this context, measured when the culler is made. Name it to later ones of the
  /// same context (GpuCuller::form(), if form_settled()), so that it is measured once.
  std::optional<GpuForm> form;
  GpuBoundsForm bounds = GpuBoundsForm::kFloat;
};

}  // namespace sightline::culling
