// The target of a renderer: colour, reverse-Z float depth, and item ids and normals on request.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "sightline/core/view.h"
#include "sightline/gl/context.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/texture.h"
#include "sightline/render/image/image.h"
#include "sightline/render/internal/pixel_pass.h"

namespace sightline::render {

/// Per pixel: shaders write the covered ones into one word (gl_SampleMask).
inline constexpr int kMostSamples = 32;
/// The numbers that drivers have. Programs are compiled for one of them.
inline constexpr std::array kSampleCounts = {1, 2, 4, 8, 16, kMostSamples};

/// What a target has besides colour and depth. Parts that are not requested cost nothing. A Renderer is made for one
/// format.
struct TargetFormat {
  bool ids = false;
  bool normals = false;
  int samples =
      1;  ///< per pixel, kMostSamples at most; from 2 on edges are smooth. A target may have more than asked for
};

class RenderTarget {
 public:
  /// Fails on sizes and sample counts that the context does not support.
  static core::Expected<RenderTarget> create(const gl::Context& context, int width, int height,
                                             const TargetFormat& format = {});

  int width() const { return drawn_.colour.width(); }
  int height() const { return drawn_.colour.height(); }
  bool has_ids() const { return format_.ids; }
  bool has_normals() const { return format_.normals; }
  const TargetFormat& format() const { return format_; }
  /// Offsets of the samples from the pixel centre; without multisampling one, at the centre.
  const std::vector<glm::vec2>& sample_offsets() const { return sample_offsets_; }
  /// The framebuffer that draws write to.
  const gl::Framebuffer& framebuffer() const { return drawn_.framebuffer; }
  /// Its colour: sRGB values, multisampled if the format is.
  const gl::Texture2D& colour() const { return drawn_.colour; }
  /// Its depth: reverse-Z, multisampled if the format is.
  const gl::Texture2D& depth() const { return drawn_.depth; }
  /// The target of its textures.
  GLenum texture_target() const { return format_.samples == 1 ? GL_TEXTURE_2D : GL_TEXTURE_2D_MULTISAMPLE; }
  /// Makes draws write to it, in the state that all draws begin with: reverse-Z depth test, no blending.
  void begin_drawing() const;
  /// The image with one value per pixel: the average of the colours, and one sample's value of everything else.
  const gl::Framebuffer& resolved() const;
  /// Textures of its colour, depth and, or else 0, ids.
  std::array<GLuint, 3> resolved_textures() const;
  /// Copies all that is drawn here to a target of the same size and format.
  void copy_to(const RenderTarget& to) const;
  std::size_t memory_bytes() const;
  /// Reads all that is drawn, as write() takes it: of several samples per pixel the mean of the colours, and one
  /// sample's depth and id. Waits for the GPU.
  void read(std::span<std::uint32_t> colours, std::span<float> depths, std::span<std::uint32_t> ids) const;
  /// Replaces all that is drawn, row by row from the bottom up: colours with red in the lowest byte and alpha in the
  /// highest, reversed depths, and ids, if the target has any. Only for a target with one sample per pixel.
  void write(std::span<const std::uint32_t> colours, std::span<const float> depths,
             std::span<const std::uint32_t> ids) const;

  /// Read-backs resolve the image and wait for the GPU. They are for images and tests, not for use between cull and
  /// draw.
  image::Image read_colour() const;
  image::IdImage read_ids() const;          ///< only for a target with ids
  image::NormalImage read_normals() const;  ///< only for a target with normals
  /// Depth as distance along the axis of `view`, which must be the view that was drawn.
  image::DepthImage read_depth(const core::View& view) const;
  /// As they are stored: 0 where nothing was drawn, and the larger the nearer. Rows from the top.
  std::vector<float> read_reversed_depths() const;
  /// Reads distances for occlusion tests between two passes of a frame: row by row from the bottom up. Only for a
  /// target with one sample per pixel. In orthographic views distances are off by orthographic_error() at most, in
  /// perspective ones by a few units in the last place. Fails with GL's error: what it would leave in `metres` must not
  /// hide anything.
  core::Expected<void> read_distances(const core::View& view, std::vector<float>& metres) const;
  /// What a float depth loses of a distance, metres; 0 in perspective views.
  static double orthographic_error(const core::View& view);

 private:
  struct Attachments {
    gl::Texture2D colour, depth, ids, normals;
    gl::Framebuffer framebuffer;
  };
  static core::Expected<Attachments> make_attachments(const gl::Functions& gl, int width, int height,
                                                      const TargetFormat& format);
  /// The attachments that read-backs read.
  const Attachments& resolved_attachments() const;

  const gl::Functions* gl_ = nullptr;
  TargetFormat format_;
  Attachments drawn_;
  // Only for a multisampled target.
  Attachments single_;
  std::optional<PixelPass> pass_;
  gl::Program one_sample_;
  std::vector<glm::vec2> sample_offsets_;
};

}  // namespace sightline::render
