#include "sightline/render/render_target.h"

#include <algorithm>
#include <cassert>
#include <limits>

#include "sightline/gpuprims/view_block.h"

namespace sightline::render {
namespace {

/// GL rows run bottom to top, ours top to bottom.
template <class T>
std::vector<T> read_flipped(const gl::Texture2D& texture, GLenum format, GLenum type, std::size_t channels) {
  const std::size_t row = std::size_t(texture.width()) * channels, rows = std::size_t(texture.height());
  std::vector<T> bottom_up(row * rows), top_down(row * rows);
  texture.read(0, format, type, std::as_writable_bytes(std::span(bottom_up)));
  for (std::size_t y = 0; y < rows; ++y)
    std::copy_n(bottom_up.begin() + std::ptrdiff_t((rows - 1 - y) * row), row,
                top_down.begin() + std::ptrdiff_t(y * row));
  return top_down;
}

}  // namespace

core::Expected<RenderTarget> RenderTarget::create(const gl::Context& context, int width, int height, bool with_ids,
                                                  bool with_normals) {
  const gl::Functions& gl = context.functions();
  RenderTarget target;
  std::vector<gl::Attachment> attachments;
  const auto attach = [&](gl::Texture2D& texture, GLenum point, GLenum format,
                          const char* what) -> core::Expected<void> {
    auto made = gl::Texture2D::create(gl, width, height, format, what);
    if (!made) return tl::unexpected(made.error());
    texture = std::move(*made);
    attachments.push_back({point, &texture});
    return {};
  };
  auto done = attach(target.colour_, GL_COLOR_ATTACHMENT0, GL_RGBA8, "colour target");
  if (done && with_ids) done = attach(target.ids_, GL_COLOR_ATTACHMENT1, GL_R32UI, "id target");
  if (done && with_normals) done = attach(target.normals_, GL_COLOR_ATTACHMENT2, GL_RGBA32F, "normal target");
  if (done) done = attach(target.depth_, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F, "depth target");
  if (!done) return tl::unexpected(done.error());
  auto framebuffer = gl::Framebuffer::create(gl, attachments, "render target");
  if (!framebuffer) return tl::unexpected(framebuffer.error());
  target.framebuffer_ = std::move(*framebuffer);
  return target;
}

std::size_t RenderTarget::memory_bytes() const {
  return std::size_t(width()) * std::size_t(height()) * (8u + (has_ids() ? 4u : 0u) + (has_normals() ? 16u : 0u));
}

Image RenderTarget::read_colour() const {
  const auto rgba = read_flipped<std::uint8_t>(colour_, GL_RGBA, GL_UNSIGNED_BYTE, 4);
  Image image{width(), height(), std::vector<std::uint8_t>(rgba.size() / 4 * 3)};
  for (std::size_t i = 0; i < rgba.size() / 4; ++i)
    std::copy_n(rgba.begin() + std::ptrdiff_t(4 * i), 3, image.pixels.begin() + std::ptrdiff_t(3 * i));
  return image;
}

IdImage RenderTarget::read_ids() const {
  assert(has_ids());
  return {width(), height(), read_flipped<std::uint32_t>(ids_, GL_RED_INTEGER, GL_UNSIGNED_INT, 1)};
}

NormalImage RenderTarget::read_normals() const {
  assert(has_normals());
  return {width(), height(), read_flipped<std::array<float, 3>>(normals_, GL_RGB, GL_FLOAT, 1)};
}

DepthImage RenderTarget::read_depth(const core::View& view) const {
  DepthImage image{width(), height(), read_flipped<float>(depth_, GL_DEPTH_COMPONENT, GL_FLOAT, 1)};
  const core::dmat4 clip = gpuprims::reversed_clip_from_eye(view);
  for (float& depth : image.metres)
    depth = depth == 0.0f ? std::numeric_limits<float>::infinity() : float(gpuprims::eye_depth(clip, depth));
  return image;
}

}  // namespace sightline::render
