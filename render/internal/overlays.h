// Overlays of a complete image: transparent surfaces in any order, ghosts, and outlines.
#pragma once

#include <array>
#include <optional>

#include "sightline/render/internal/compositor.h"

namespace sightline::render {

/// Pixels of an image, from its lower left corner.
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Sums over the transparent surfaces of each sample, in any order: weighted blended transparency (M. McGuire, L.
/// Bavoil, "Weighted Blended Order-Independent Transparency", JCGT 2013). The share of light that all of them let pass
/// is exact; of their colours there is a mean, in which near surfaces weigh more. So one surface is exact, and surfaces
/// of one colour are, however many. 16 bytes for each sample.
class BlendedSums {
 public:
  /// For surfaces in front of what `image` shows: its depth is borrowed.
  static core::Expected<BlendedSums> create(const gl::Functions& gl, const RenderTarget& image);

  void clear() const;
  /// Makes draws of Surface::kBlended add to the sums, where the image's depth does not hide them.
  void begin_drawing() const;
  const gl::Framebuffer& framebuffer() const { return framebuffer_; }
  std::array<GLuint, 3> textures() const { return {sums_.id(), let_pass_.id(), nearest_.id()}; }
  std::size_t memory_bytes() const;

 private:
  const gl::Functions* gl_ = nullptr;
  gl::Texture2D sums_, let_pass_, nearest_;
  gl::Framebuffer framebuffer_;
};

/// The layers that lie over an image, one at a time, and the programs that put them there. Nothing is made before it
/// is used. All calls set GL state and leave it set. An image is drawn over in place: its depth and ids stay.
class Overlays {
 public:
  explicit Overlays(const gl::Functions& gl) : gl_(&gl), pass_(gl), layers_(gl, Compositor::Source::kLayer) {}

  /// An empty layer of the size and samples of the image, for Surface::kGhost. `behind`: surfaces that the
  /// image hides are not drawn to it.
  core::Expected<const RenderTarget*> begin_layer(const gl::Context& context, const RenderTarget& image, bool behind);
  /// Empty sums over the image, for Surface::kBlended.
  core::Expected<const BlendedSums*> begin_sums(const RenderTarget& image);

  /// Makes a layer of the sums.
  core::Expected<void> resolve_sums(const gl::Context& context, const RenderTarget& image);
  /// Blends the layer over a framebuffer, where nothing there is nearer.
  core::Expected<void> put_layer(const gl::ExternalTarget& over);
  /// Draws a line of that colour (sRGB) around the surfaces in the layer, two pixels wide. It is fainter around what
  /// the image hides. No depth is tested. Looks for the line `within` these pixels of the image alone: a whole
  /// image takes longer than most frames.
  core::Expected<void> put_outline(const RenderTarget& image, const core::vec3& colour, const PixelBox& within,
                                   const gl::ExternalTarget& over);

  std::size_t memory_bytes() const;

 private:
  core::Expected<void> make_layer(const gl::Context& context, const RenderTarget& image);

  const gl::Functions* gl_;
  PixelPass pass_;
  Compositor layers_;
  std::optional<RenderTarget> layer_;
  std::optional<BlendedSums> sums_;
  GLuint sums_depth_ = 0;          // texture of the image that sums_ was made for
  gl::Program resolve_, outline_;  // for one number of samples
};

}  // namespace sightline::render
