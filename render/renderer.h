// render: view + visible set -> image. Programs only for what a scene holds, one indirect multi-draw per batch, id
// images, PNG and PFM files, image comparison. Knows nothing of cullers.
#pragma once

#include <array>
#include <optional>

#include "sightline/core/view.h"
#include "sightline/gl/program.h"
#include "sightline/gl/vertex_array.h"
#include "sightline/gpuscene/draw_lists.h"
#include "sightline/render/render_target.h"
#include "sightline/render/section_caps.h"

namespace sightline::render {

class Renderer {
 public:
  /// Compiles one program for each batch that `scene` holds and none else, for targets of one form. Fails with the
  /// driver's log.
  static core::Expected<Renderer> create(const gl::Context& context, const gpuscene::GpuScene& scene,
                                         const TargetForm& form = {});

  /// Clears the target and draws what the lists name. Cylinders, snouts and torus slices are exact up to float
  /// arithmetic; with several samples per pixel they cover those whose rays hit them, in the colour and at the depth of
  /// one. Depth is reverse-Z whatever the view's own convention. Sets all GL state it needs
  /// (but see gl::reset_pipeline_state) and leaves it set. Does not wait.
  core::Expected<void> draw(const core::View& view, const core::Snapshot& snapshot, const gpuscene::GpuScene& scene,
                            const gpuscene::DrawLists& lists, const RenderTarget& target);

  std::array<float, 3> background{0.86f, 0.88f, 0.91f};  ///< sRGB

  std::size_t memory_bytes() const;

 private:
  core::Expected<void> upload_view(const core::View& view, const core::Snapshot& snapshot, const RenderTarget& target);
  void draw_batch(const gpuscene::Batch& batch, const gpuscene::GpuScene& scene,
                  const gpuscene::DrawLists& lists) const;
  void submit_batch(const gpuscene::Batch& batch, const gpuscene::GpuScene& scene,
                    const gpuscene::DrawLists& lists) const;
  core::Expected<void> draw_section_caps(const core::Snapshot& snapshot, const gpuscene::Batch& meshes,
                                         const gpuscene::GpuScene& scene, const gpuscene::DrawLists& lists,
                                         const RenderTarget& target);

  const gl::Functions* gl_ = nullptr;
  std::array<gl::Program, gpuscene::kBatchKindCount> programs_;
  gl::VertexArray corner_array_, mesh_array_;
  gl::Buffer view_block_, chunk_rows_;
  gl::TextureBuffer chunk_texels_;
  std::size_t chunk_capacity_ = 0;
  std::optional<SectionCaps> section_caps_;  // from the first view with sections on, if there are meshes
};

}  // namespace sightline::render
