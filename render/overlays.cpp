#include "sightline/render/internal/overlays.h"

#include "sightline/core/internal/store.h"
#include "sightline/gl/internal/pipeline_state.h"

namespace sightline::render {
namespace {

constexpr GLint kLineColourUniform = 3;

}  // namespace

// --- sums ------------------------------------------------------------------------------------------------------------

core::Expected<BlendedSums> BlendedSums::create(const gl::Functions& gl, const RenderTarget& image) {
  BlendedSums made;
  made.gl_ = &gl;
  const auto make = [&](gl::Texture2D& texture, GLenum format, const char* what) -> core::Expected<void> {
    return core::store(gl::Texture2D::create(gl, image.width(), image.height(), format, what, image.format().samples),
                       texture);
  };
  auto done = make(made.sums_, GL_RGBA16F, "sums of transparent surfaces");
  if (done) done = make(made.let_pass_, GL_R32F, "light that transparent surfaces let pass");
  if (done) done = make(made.nearest_, GL_R32F, "depth of transparent surfaces");
  const gl::Attachment attachments[] = {{GL_COLOR_ATTACHMENT0, &made.sums_},
                                        {GL_COLOR_ATTACHMENT1, &made.let_pass_},
                                        {GL_COLOR_ATTACHMENT2, &made.nearest_},
                                        {GL_DEPTH_ATTACHMENT, &image.depth()}};
  if (done)
    done = core::store(gl::Framebuffer::create(gl, attachments, "sums of transparent surfaces"), made.framebuffer_);
  if (!done) return tl::unexpected(done.error());
  return made;
}

void BlendedSums::clear() const {
  gl::reset_pipeline_state(*gl_);
  const float nothing[4] = {0.0f, 0.0f, 0.0f, 0.0f}, all[4] = {1.0f, 1.0f, 1.0f, 1.0f};
  gl_->ClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 0, nothing);
  gl_->ClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 1, all);
  gl_->ClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 2, nothing);
}

void BlendedSums::begin_drawing() const {
  const gl::Functions& gl = *gl_;
  gl::reset_pipeline_state(gl);
  framebuffer_.bind();
  gl.Viewport(0, 0, sums_.width(), sums_.height());
  gl.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_GREATER);
  gl.DepthMask(GL_FALSE);
  gl.Enable(GL_BLEND);
  gl.BlendEquationSeparatei(0, GL_FUNC_ADD, GL_FUNC_ADD);
  gl.BlendFuncSeparatei(0, GL_ONE, GL_ONE, GL_ONE, GL_ONE);
  gl.BlendEquationSeparatei(1, GL_FUNC_ADD, GL_FUNC_ADD);
  gl.BlendFuncSeparatei(1, GL_ZERO, GL_SRC_COLOR, GL_ZERO, GL_SRC_ALPHA);
  gl.BlendEquationSeparatei(2, GL_MAX, GL_MAX);
  gl.BlendFuncSeparatei(2, GL_ONE, GL_ONE, GL_ONE, GL_ONE);
}

std::size_t BlendedSums::memory_bytes() const {
  return 16u * std::size_t(sums_.width()) * std::size_t(sums_.height()) * std::size_t(sums_.samples());
}

// --- layers ----------------------------------------------------------------------------------------------------------

core::Expected<void> Overlays::make_layer(const gl::Context& context, const RenderTarget& image) {
  const int samples = image.format().samples;
  if (layer_ && layer_->width() == image.width() && layer_->height() == image.height() &&
      layer_->format().samples == samples)
    return {};
  return core::store(RenderTarget::create(context, image.width(), image.height(), {.samples = samples}), layer_);
}

core::Expected<const RenderTarget*> Overlays::begin_layer(const gl::Context& context, const RenderTarget& image,
                                                          bool behind) {
  if (auto done = make_layer(context, image); !done) return tl::unexpected(done.error());
  const gl::Functions& gl = *gl_;
  gl::reset_pipeline_state(gl);
  const GLuint framebuffer = layer_->framebuffer().id();
  const float nothing[4] = {0.0f, 0.0f, 0.0f, 0.0f}, far_depth = 0.0f;
  gl.ClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, nothing);
  const GLenum target = image.texture_target();
  if (behind)
    gl.CopyImageSubData(image.depth().id(), target, 0, 0, 0, 0, layer_->depth().id(), target, 0, 0, 0, 0, image.width(),
                        image.height(), 1);
  else
    gl.ClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &far_depth);
  return &*layer_;
}

core::Expected<const BlendedSums*> Overlays::begin_sums(const RenderTarget& image) {
  if (!sums_ || sums_depth_ != image.depth().id()) {
    sums_.reset();
    if (auto done = core::store(BlendedSums::create(*gl_, image), sums_); !done) return tl::unexpected(done.error());
    sums_depth_ = image.depth().id();
  }
  sums_->clear();
  return &*sums_;
}

core::Expected<void> Overlays::resolve_sums(const gl::Context& context, const RenderTarget& image) {
  const auto layer = begin_layer(context, image, false);
  if (!layer) return tl::unexpected(layer.error());
  const auto made = pass_.program(resolve_, kBlendResolve, image.format().samples);
  if (!made) return tl::unexpected(made.error());
  layer_->begin_drawing();
  pass_.draw(**made, sums_->textures(), layer_->texture_target());
  return {};
}

core::Expected<void> Overlays::put_layer(const gl::ExternalTarget& over) {
  auto done = layers_.put(*layer_, over);
  gl::reset_pipeline_state(*gl_);
  return done;
}

core::Expected<void> Overlays::put_outline(const RenderTarget& image, const core::vec3& colour, const PixelBox& within,
                                           const gl::ExternalTarget& over) {
  if (auto good = check_target(*gl_, over); !good) return good;
  const auto made = pass_.program(outline_, kOutline, image.format().samples);
  if (!made) return tl::unexpected(made.error());
  pass_.begin(**made, over);
  gl_->DepthMask(GL_FALSE);
  pass_.blend();
  gl_->Enable(GL_SCISSOR_TEST);
  gl_->Scissor(over.x + within.x, over.y + within.y, within.width, within.height);
  gl_->ProgramUniform3f((*made)->id(), kLineColourUniform, colour.r, colour.g, colour.b);
  pass_.draw(**made, std::array{layer_->colour().id(), layer_->depth().id(), image.depth().id()},
             layer_->texture_target());
  gl::reset_pipeline_state(*gl_);
  return {};
}

std::size_t Overlays::memory_bytes() const {
  return (layer_ ? layer_->memory_bytes() : 0) + (sums_ ? sums_->memory_bytes() : 0);
}

}  // namespace sightline::render
