// Items so small that their shape does not show, each drawn as one splat.
#pragma once

#include <span>
#include <vector>

#include "sightline/core/view.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/vertex_array.h"
#include "sightline/gpuscene/internal/gpu_scene.h"
#include "sightline/render/internal/render_target.h"

namespace sightline::render {

struct PointSplat {
  glm::vec3 centre;        ///< in eye space, metres
  float side;              ///< pixels, at most PointSplats::largest_side()
  core::ItemId item;       ///< id
  std::uint32_t material;  ///< row of the GPU scene's material table
};

/// Draws screen-aligned squares. A square covers the samples inside it, with the depth of its centre and the mean of
/// the colours that a ball of its material shows. It is transparent as its material is. It is not drawn where section
/// planes cut its centre away, or where its centre is outside the view volume.
///
/// Costs one program, for targets of one format, and 24 bytes for each splat of the largest draw so far, rounded up.
class PointSplats {
 public:
  /// Fails with the driver's log.
  static core::Expected<PointSplats> create(const gl::Context& context, const TargetFormat& format);
  /// The programs of targets of any format.
  static std::vector<gl::PipelineDescription> all_programs();

  /// Draws the splats beside what the target holds of the same view. Where two items have the same depth, the pixel
  /// keeps what it has. Sets GL state as Renderer::draw() does. Does not wait for the GPU. Fails for views that
  /// Renderer does not draw, and when the GPU has not enough memory.
  core::Expected<void> draw(const core::View& view, std::span<const PointSplat> splats, const gpuscene::GpuScene& scene,
                            const RenderTarget& target);

  /// Pixels; depends on the implementation.
  float largest_side() const { return largest_side_; }
  std::size_t memory_bytes() const { return view_block_.size() + vertices_.size(); }

 private:
  core::Expected<void> upload(const core::View& view, std::span<const PointSplat> splats, const RenderTarget& target);

  const gl::Functions* gl_ = nullptr;
  gl::Program program_;
  gl::VertexArray array_;
  gl::Buffer view_block_, vertices_;
  float largest_side_ = 0.0f;
};

}  // namespace sightline::render
