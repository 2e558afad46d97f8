// Where a renderer draws: colour, reverse-Z float depth, and item ids and normals on request.
#pragma once

#include "sightline/core/view.h"
#include "sightline/gl/context.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/texture.h"
#include "sightline/image/image.h"

namespace sightline::render {

/// What a target has besides colour and depth; what is not asked for costs nothing. A Renderer is made for one form.
struct TargetForm {
  bool ids = false;
  bool normals = false;
  int samples = 1;  ///< per pixel: edges are smooth from 2 on
};

class RenderTarget {
 public:
  /// Fails on sizes and samples the context does not have.
  static core::Expected<RenderTarget> create(const gl::Context& context, int width, int height,
                                             const TargetForm& form = {});

  int width() const { return drawn_.colour.width(); }
  int height() const { return drawn_.colour.height(); }
  bool has_ids() const { return form_.ids; }
  bool has_normals() const { return form_.normals; }
  const TargetForm& form() const { return form_; }
  /// Where samples lie in a pixel, from its centre; one at the centre without multisampling.
  const std::vector<glm::vec2>& sample_offsets() const { return sample_offsets_; }
  /// What is drawn to.
  const gl::Framebuffer& framebuffer() const { return drawn_.framebuffer; }
  /// The picture with one value per pixel: colours averaged, of all else one sample's value.
  const gl::Framebuffer& resolved() const;
  std::size_t memory_bytes() const;

  /// Read-backs resolve, and wait for the GPU: for pictures and tests, never on the way from cull to draw.
  image::Image read_colour() const;
  image::IdImage read_ids() const;          ///< only of a target with ids
  image::NormalImage read_normals() const;  ///< only of a target with normals
  /// Whether any pixel shows anything but the background, by the depth of one sample each.
  bool covered() const;
  /// Depth as distances along the axis of the view that was drawn.
  image::DepthImage read_depth(const core::View& view) const;

 private:
  struct Attachments {
    gl::Texture2D colour, depth, ids, normals;
    gl::Framebuffer framebuffer;
  };
  static core::Expected<Attachments> make_attachments(const gl::Functions& gl, int width, int height,
                                                      const TargetForm& form);
  /// What read-backs read.
  const Attachments& resolved_attachments() const;

  const gl::Functions* gl_ = nullptr;
  TargetForm form_;
  Attachments drawn_, single_;  // single_: only of a multisampled target
  std::vector<glm::vec2> sample_offsets_;
};

}  // namespace sightline::render
