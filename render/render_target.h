// Where a renderer draws: colour, reverse-Z float depth, and item ids and normals on request.
#pragma once

#include "sightline/core/view.h"
#include "sightline/gl/context.h"
#include "sightline/gl/framebuffer.h"
#include "sightline/gl/texture.h"
#include "sightline/render/image.h"

namespace sightline::render {

class RenderTarget {
 public:
  /// `with_ids` and `with_normals` add their attachments; what is not asked for costs nothing. Normals take a Renderer
  /// that writes them. Fails on sizes the context does not have.
  static core::Expected<RenderTarget> create(const gl::Context& context, int width, int height, bool with_ids,
                                             bool with_normals = false);

  int width() const { return colour_.width(); }
  int height() const { return colour_.height(); }
  bool has_ids() const { return ids_.id() != 0; }
  bool has_normals() const { return normals_.id() != 0; }
  const gl::Framebuffer& framebuffer() const { return framebuffer_; }
  std::size_t memory_bytes() const;

  /// Read-backs wait for the GPU: for pictures and tests, never on the way from cull to draw.
  Image read_colour() const;
  IdImage read_ids() const;          ///< only of a target with ids
  NormalImage read_normals() const;  ///< only of a target with normals
  /// Depth as distances along the axis of the view that was drawn.
  DepthImage read_depth(const core::View& view) const;

 private:
  gl::Texture2D colour_, depth_, ids_, normals_;
  gl::Framebuffer framebuffer_;
};

}  // namespace sightline::render
