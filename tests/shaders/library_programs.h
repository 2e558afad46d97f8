// Every program that the library can ask a driver for.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "sightline/culling/gpu/internal/gpu_occlusion.h"
#include "sightline/culling/gpu/internal/gpu_pass.h"
#include "sightline/gl/internal/driver_test.h"
#include "sightline/gl/internal/shader_source.h"
#include "sightline/gpuscene/internal/draw_lists.h"
#include "sightline/gpuscene/internal/element_writer.h"
#include "sightline/render/internal/edge_pass.h"
#include "sightline/render/internal/pixel_pass.h"
#include "sightline/render/internal/point_splats.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::tests {

/// A pipeline as it is with these workarounds.
inline gl::PipelineDescription worked_around(gl::PipelineDescription pipeline, gl::Workarounds workarounds) {
  for (gl::ProgramDescription& program : pipeline)
    program.shaders = gl::with_workarounds(std::move(program.shaders), workarounds);
  return pipeline;
}

/// Whether the pipeline's texts ask for one of these workarounds.
inline bool asks_for(const gl::PipelineDescription& pipeline, gl::Workarounds workarounds) {
  const std::vector<std::string> defines = gl::with_workarounds({}, workarounds).defines;
  for (const gl::ProgramDescription& program : pipeline)
    for (const gl::StageDescription& stage : program.stages) {
      const auto source = gl::assemble_stage(program.shaders, stage.files);
      for (const std::string& define : defines)
        if (source && source->text.find(define) != std::string::npos) return true;
    }
  return false;
}

/// Without any workaround.
inline std::vector<gl::PipelineDescription> library_programs() {
  std::vector<gl::PipelineDescription> all;
  for (const auto& list :
       {gl::driver_test_programs(), gpuscene::DrawLists::all_programs(), gpuscene::ElementWriter::all_programs(),
        culling::geometry_programs(), culling::compute_programs(), culling::GpuDepthPyramid::all_programs(),
        render::Renderer::all_programs(), render::PointSplats::all_programs(), render::PixelPass::all_programs(),
        render::EdgePass::all_programs()})
    all.insert(all.end(), list.begin(), list.end());
  return all;
}

}  // namespace sightline::tests
