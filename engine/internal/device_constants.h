// What was fitted to a device instead of being measured: docs/results/hybrid.md lists these, with what is measured.
// Internal to engine.
#pragma once

namespace sightline::engine {

/// Share by which frames of the GPU path are presumed to be more expensive where software draws, until measured frames
/// show otherwise (ControllerConfig::presumed_gpu_excess). llvmpipe: 1.15 to 1.2 times the frame of the CPU's path.
inline constexpr double kSoftwareGpuExcess = 0.1;

/// Frames without the occlusion test that follow one another overlap, where software draws by the CPU's own cores, too:
/// they take so much of what a part that is waited for tells. llvmpipe: 0.72 to 0.78 with 7,000 to a million items. On
/// a GPU the parts of the CPU and of the GPU are measured.
inline constexpr double kSoftwareOverlap = 0.75;

}  // namespace sightline::engine
