// Internal to sightline-study: the GPU forms of culling (study/gpu) beside the CPU's.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "sightline/gl/context.h"
#include "sightline/study/tables/report.h"

namespace sightline::study {

/// On a model's first path.
struct GpuResults {
  Results culling;                 ///< figure 5.15: with read-back where it is the GPU's
  std::optional<Results> drawing;  ///< figure 5.14: whole frames; of models that have cylinders
};

/// Borrows the prepared model. A form that this context cannot run is left out, with a line on stderr; fails when the
/// scene of cylinders does not fit the GPU.
core::Expected<GpuResults> run_gpu(const gl::Context& context, const Model& model, const SessionOptions& options);

void print_gpu(const gl::Context& context, const std::vector<GpuResults>& all);
/// Figures 5.14 and 5.15. The directory must exist.
core::Expected<void> write_gpu_figures(const GpuResults& results, const std::filesystem::path& directory);

}  // namespace sightline::study
