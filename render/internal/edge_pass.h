// Lines of items over their image: as wide as wanted, and hidden where the image's depth hides them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sightline/core/view.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/vertex_array.h"
#include "sightline/render/internal/edge_lines.h"
#include "sightline/render/internal/pixel_pass.h"
#include "sightline/render/internal/render_target.h"

namespace sightline::render {

/// Draws lines as edge_lines.h has it. Costs two programs, and one byte for each pixel, from the first draw on; 24
/// bytes a segment.
class EdgePass {
 public:
  explicit EdgePass(const gl::Functions& gl) : gl_(&gl), pass_(gl) {}

  /// Number of segments, which those that are added next follow.
  std::uint32_t size() const { return segment_count_; }
  /// Fails when the GPU has not enough memory; then nothing has changed.
  core::Expected<void> add(std::span<const EdgeSegment> segments);
  /// Forgets all segments.
  void clear();

  /// Draws over the colour of the image; depth and ids stay. `view` is the one that was drawn. `curves` must be sorted
  /// by their parts. Sets GL state and leaves it set. Fails with the driver's log, and when the GPU has not enough
  /// memory.
  core::Expected<void> draw(const RenderTarget& image, const core::View& view, std::span<const MeshLines> meshes,
                            std::span<const CurvedLine> curves, const LineStyle& style);

  /// The programs for images of any number of samples.
  static std::vector<gl::PipelineDescription> all_programs();
  std::size_t memory_bytes() const { return segments_.size() + curves_.size() + cover_pixels(); }

 private:
  core::Expected<void> prepare(const RenderTarget& image);
  core::Expected<void> upload(std::span<const CurvedLine> curves);
  void set_view(const gl::Program& program, const RenderTarget& image, const core::View& view, const LineStyle& style);
  void draw_meshes(std::span<const MeshLines> meshes) const;
  void draw_curves(std::span<const CurvedLine> curves) const;
  std::size_t cover_pixels() const { return std::size_t(cover_.width()) * std::size_t(cover_.height()); }

  const gl::Functions* gl_;
  PixelPass pass_;
  gl::Buffer segments_, curves_;
  std::uint32_t segment_count_ = 0;
  gl::Program mesh_program_, curve_program_, put_program_;  // for the samples of the first image
  gl::VertexArray mesh_array_, curve_array_;
  gl::Texture2D cover_;
  gl::Framebuffer framebuffer_;
};

}  // namespace sightline::render
