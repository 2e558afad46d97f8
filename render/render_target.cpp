#include "sightline/render/internal/render_target.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <iterator>
#include <limits>

#include "sightline/core/internal/store.h"
#include "sightline/gl/internal/pipeline_state.h"
#include "sightline/gpuprims/internal/view_block.h"

namespace sightline::render {
namespace {

/// GL stores rows bottom to top; images store them top to bottom.
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

core::Expected<RenderTarget::Attachments> RenderTarget::make_attachments(const gl::Functions& gl, int width, int height,
                                                                         const TargetFormat& format) {
  Attachments made;
  std::vector<gl::Attachment> list;
  const auto attach = [&](gl::Texture2D& texture, GLenum point, GLenum texels,
                          const char* what) -> core::Expected<void> {
    if (auto done = core::store(gl::Texture2D::create(gl, width, height, texels, what, format.samples), texture); !done)
      return done;
    list.push_back({point, &texture});
    return {};
  };
  auto done = attach(made.colour, GL_COLOR_ATTACHMENT0, GL_RGBA8, "colour target");
  if (done && format.ids) done = attach(made.ids, GL_COLOR_ATTACHMENT1, GL_R32UI, "id target");
  if (done && format.normals) done = attach(made.normals, GL_COLOR_ATTACHMENT2, GL_RGBA32F, "normal target");
  if (done) done = attach(made.depth, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F, "depth target");
  if (done) done = core::store(gl::Framebuffer::create(gl, list, "render target"), made.framebuffer);
  if (!done) return tl::unexpected(done.error());
  return made;
}

core::Expected<RenderTarget> RenderTarget::create(const gl::Context& context, int width, int height,
                                                  const TargetFormat& format) {
  const gl::Functions& gl = context.functions();
  if (format.samples > kMostSamples)
    return core::fail("render target: " + std::to_string(format.samples) + " samples wanted, " +
                      std::to_string(kMostSamples) + " are the most");
  RenderTarget target;
  target.gl_ = &gl;
  target.format_ = format;
  if (auto done = core::store(make_attachments(gl, width, height, format), target.drawn_); !done)
    return tl::unexpected(done.error());
  const int samples = target.format_.samples = target.drawn_.colour.samples();
  target.sample_offsets_.assign(std::size_t(samples), glm::vec2(0.0f));
  if (samples > kMostSamples)
    return core::fail("render target: " + std::to_string(format.samples) + " samples wanted, the context makes " +
                      std::to_string(samples) + " of them, and " + std::to_string(kMostSamples) + " are the most");
  if (samples == 1) return target;

  target.drawn_.framebuffer.bind();
  for (int i = 0; i < samples; ++i) {
    GLfloat place[2];
    gl.GetMultisamplefv(GL_SAMPLE_POSITION, GLuint(i), place);
    target.sample_offsets_[std::size_t(i)] = {place[0] - 0.5f, place[1] - 0.5f};
  }
  if (auto done = core::store(make_attachments(gl, width, height, {format.ids, format.normals, 1}), target.single_);
      !done)
    return tl::unexpected(done.error());
  target.pass_.emplace(gl);
  const auto program = target.pass_->program(target.one_sample_, kOneSample, samples, {format.ids, format.normals});
  if (!program) return tl::unexpected(program.error());
  return target;
}

void RenderTarget::begin_drawing() const {
  gl::reset_pipeline_state(*gl_);
  framebuffer().bind();
  gl_->Viewport(0, 0, width(), height());
  gl_->ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  gl_->Enable(GL_DEPTH_TEST);
  gl_->DepthFunc(GL_GREATER);
}

const RenderTarget::Attachments& RenderTarget::resolved_attachments() const {
  if (format_.samples == 1) return drawn_;
  gl::reset_pipeline_state(*gl_);  // the scissor test clips blits, too
  const GLuint single = single_.framebuffer.id();
  gl_->NamedFramebufferDrawBuffer(single, GL_COLOR_ATTACHMENT0);
  gl_->BlitNamedFramebuffer(drawn_.framebuffer.id(), single, 0, 0, width(), height(), 0, 0, width(), height(),
                            GL_COLOR_BUFFER_BIT, GL_NEAREST);
  // Blits of depths and of ids may choose different samples.
  const GLenum buffers[] = {GL_NONE, format_.ids ? GLenum(GL_COLOR_ATTACHMENT1) : GL_NONE,
                            format_.normals ? GLenum(GL_COLOR_ATTACHMENT2) : GL_NONE};
  gl_->NamedFramebufferDrawBuffers(single, GLsizei(std::size(buffers)), buffers);
  single_.framebuffer.bind();
  gl_->Viewport(0, 0, width(), height());
  gl_->Enable(GL_DEPTH_TEST);
  gl_->DepthFunc(GL_ALWAYS);
  gl_->Disable(GL_STENCIL_TEST);
  pass_->draw(one_sample_, std::array{drawn_.depth.id(), drawn_.ids.id(), drawn_.normals.id()},
              GL_TEXTURE_2D_MULTISAMPLE);
  gl_->NamedFramebufferDrawBuffer(single, GL_COLOR_ATTACHMENT0);
  return single_;
}

const gl::Framebuffer& RenderTarget::resolved() const {
  return resolved_attachments().framebuffer;
}

std::array<GLuint, 3> RenderTarget::resolved_textures() const {
  const Attachments& from = resolved_attachments();
  return {from.colour.id(), from.depth.id(), from.ids.id()};
}

void RenderTarget::copy_to(const RenderTarget& to) const {
  assert(to.width() == width() && to.height() == height() && to.format_.samples == format_.samples);
  for (const auto texture : {&Attachments::colour, &Attachments::depth, &Attachments::ids, &Attachments::normals})
    if ((drawn_.*texture).id() != 0)
      gl_->CopyImageSubData((drawn_.*texture).id(), texture_target(), 0, 0, 0, 0, (to.drawn_.*texture).id(),
                            texture_target(), 0, 0, 0, 0, width(), height(), 1);
}

void RenderTarget::read(std::span<std::uint32_t> colours, std::span<float> depths, std::span<std::uint32_t> ids) const {
  const Attachments& from = resolved_attachments();
  from.colour.read(0, GL_RGBA, GL_UNSIGNED_BYTE, std::as_writable_bytes(colours));
  from.depth.read(0, GL_DEPTH_COMPONENT, GL_FLOAT, std::as_writable_bytes(depths));
  if (has_ids()) from.ids.read(0, GL_RED_INTEGER, GL_UNSIGNED_INT, std::as_writable_bytes(ids));
}

void RenderTarget::write(std::span<const std::uint32_t> colours, std::span<const float> depths,
                         std::span<const std::uint32_t> ids) const {
  assert(format_.samples == 1 && colours.size() == std::size_t(width()) * std::size_t(height()));
  drawn_.colour.write(GL_RGBA, GL_UNSIGNED_BYTE, std::as_bytes(colours));
  drawn_.depth.write(GL_DEPTH_COMPONENT, GL_FLOAT, std::as_bytes(depths));
  if (has_ids()) drawn_.ids.write(GL_RED_INTEGER, GL_UNSIGNED_INT, std::as_bytes(ids));
}

std::size_t RenderTarget::memory_bytes() const {
  const std::size_t sample = 8u + (has_ids() ? 4u : 0u) + (has_normals() ? 16u : 0u);
  const std::size_t per_pixel = format_.samples == 1 ? 1u : std::size_t(format_.samples) + 1u;
  return std::size_t(width()) * std::size_t(height()) * sample * per_pixel;
}

image::Image RenderTarget::read_colour() const {
  const auto rgba = read_flipped<std::uint8_t>(resolved_attachments().colour, GL_RGBA, GL_UNSIGNED_BYTE, 4);
  image::Image image{width(), height(), std::vector<std::uint8_t>(rgba.size() / 4 * 3)};
  for (std::size_t i = 0; i < rgba.size() / 4; ++i)
    std::copy_n(rgba.begin() + std::ptrdiff_t(4 * i), 3, image.pixels.begin() + std::ptrdiff_t(3 * i));
  return image;
}

image::IdImage RenderTarget::read_ids() const {
  assert(has_ids());
  return {width(), height(),
          read_flipped<std::uint32_t>(resolved_attachments().ids, GL_RED_INTEGER, GL_UNSIGNED_INT, 1)};
}

image::NormalImage RenderTarget::read_normals() const {
  assert(has_normals());
  return {width(), height(), read_flipped<std::array<float, 3>>(resolved_attachments().normals, GL_RGB, GL_FLOAT, 1)};
}

std::vector<float> RenderTarget::read_reversed_depths() const {
  return read_flipped<float>(resolved_attachments().depth, GL_DEPTH_COMPONENT, GL_FLOAT, 1);
}

image::DepthImage RenderTarget::read_depth(const core::View& view) const {
  image::DepthImage image{width(), height(), read_reversed_depths()};
  gpuprims::to_distances(view, image.metres);
  return image;
}

core::Expected<void> RenderTarget::read_distances(const core::View& view, std::vector<float>& metres) const {
  assert(format_.samples == 1);
  metres.resize(std::size_t(width()) * std::size_t(height()));
  gl::discard_errors(*gl_);
  drawn_.depth.read(0, GL_DEPTH_COMPONENT, GL_FLOAT, std::as_writable_bytes(std::span(metres)));
  if (const GLenum error = gl::check_error(*gl_); error != GL_NO_ERROR)
    return core::fail("render target: reading depth back failed with " + gl::error_name(error));
  // As gpuprims::eye_depth().
  const core::dmat4 clip = gpuprims::reversed_clip_from_eye(view);
  const double a = clip[3][2], b = clip[3][3], c = clip[2][2], d = clip[2][3];
  constexpr float kNothing = std::numeric_limits<float>::infinity();
  for (float& value : metres) {
    const float distance = float((a - b * double(value)) / (c - d * double(value)));
    value = value == 0.0f ? kNothing : distance;
  }
  return {};
}

double RenderTarget::orthographic_error(const core::View& view) {
  if (!view.orthographic()) return 0.0;
  const core::dmat4 clip = gpuprims::reversed_clip_from_eye(view);
  constexpr double kDepthUnits = 0x1p-21;  // of shaders, rasteriser and the depth buffer
  return kDepthUnits * std::abs(gpuprims::eye_depth(clip, 0.0) - gpuprims::eye_depth(clip, 1.0));
}

}  // namespace sightline::render
