// Every program that the library can ask a driver for.
#pragma once

#include <vector>

#include "sightline/culling/gpu/internal/gpu_occlusion.h"
#include "sightline/culling/gpu/internal/gpu_pass.h"
#include "sightline/gl/internal/driver_test.h"
#include "sightline/gpuscene/internal/draw_lists.h"
#include "sightline/gpuscene/internal/element_writer.h"
#include "sightline/render/internal/pixel_pass.h"
#include "sightline/render/internal/point_splats.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::tests {

inline std::vector<gl::PipelineDescription> library_programs() {
  std::vector<gl::PipelineDescription> all;
  for (const auto& list :
       {gl::driver_test_programs(), gpuscene::DrawLists::all_programs(), gpuscene::ElementWriter::all_programs(), culling::geometry_programs(),
        culling::compute_programs(), culling::GpuDepthPyramid::all_programs(), render::Renderer::all_programs(),
        render::PointSplats::all_programs(), render::PixelPass::all_programs()})
    all.insert(all.end(), list.begin(), list.end());
  return all;
}

}  // namespace sightline::tests
