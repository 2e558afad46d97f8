// Culling within the draw itself (Carlos, section 5.3.1): the vertex stage of ray-cast cylinders tests their boxes, a
// geometry stage drops what is outside before anything is rasterised.
#pragma once

#include "sightline/apps/study/gpu/planes.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::study {

/// Cylinders alone, as in the original. Promise: conservative; the image is that of drawing everything.
class InDraw {
 public:
  /// That pass the geometry stage for each cylinder that does.
  static constexpr unsigned kTrianglesPerCylinder = 6;

  /// `scene`: of `snapshot`, which has cylinders. The context must live longer and be current in all calls. Fails when
  /// the GPU has not the memory, or with the driver's log.
  static core::Expected<InDraw> create(const gl::Context& context, const core::Snapshot& snapshot,
                                       const gpuscene::GpuScene& scene);
  static std::vector<gl::PipelineDescription> all_programs();

  /// Clears the target and draws the cylinders that `view` can see. `renderer`: of the scene, for its state. Leaves
  /// state set as Renderer::draw() does, and texture unit 4 and uniform block 1.
  core::Expected<void> draw(const core::View& view, const core::Snapshot& snapshot, const gpuscene::GpuScene& scene,
                            render::Renderer& renderer, const render::RenderTarget& target);

  /// Beside what drawing takes anyway.
  std::size_t memory_bytes() const { return boxes_.buffer.size(); }

 private:
  const gl::Functions* gl_ = nullptr;
  gl::Program program_;
  gl::VertexArray array_;
  GpuPlanes planes_;
  TexelArray boxes_;  // by record
  gpuscene::DrawLists all_, none_;
};

}  // namespace sightline::study
