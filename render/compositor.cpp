#include "sightline/render/internal/compositor.h"

#include <cassert>
#include <cstdint>
#include <limits>
#include <string>

#include "sightline/gl/internal/pipeline_state.h"

namespace sightline::render {
namespace {

constexpr GLint kWindowDepthsUniform = 1;

/// Whether the corner opposite to x, y has coordinates of GL's numbers.
bool within_range(const gl::ExternalTarget& to) {
  const auto fits = [](std::int64_t corner, std::int64_t size) {
    return corner + size <= std::numeric_limits<GLint>::max();
  };
  return fits(to.x, to.width) && fits(to.y, to.height);
}

}  // namespace

core::Expected<void> check_target(const gl::Functions& gl, const gl::ExternalTarget& to) {
  if (!within_range(to))
    return core::fail("external target: expected a rectangle below 2^31 pixels, found " + std::to_string(to.width) +
                      "x" + std::to_string(to.height) + " at " + std::to_string(to.x) + ", " + std::to_string(to.y));
  const auto depth = [](double d) { return d >= 0.0 && d <= 1.0; };
  if (!depth(to.near_depth) || !depth(to.far_depth) || to.near_depth == to.far_depth)
    return core::fail("external target: expected two different depths between 0 and 1 at the near and far plane");
  if (to.framebuffer != 0 && !gl.IsFramebuffer(to.framebuffer))
    return core::fail("external target: " + std::to_string(to.framebuffer) +
                      " is no framebuffer in the engine's context");
  gl::discard_errors(gl);  // the application's
  const std::string name = "external target " + std::to_string(to.framebuffer);
  if (auto complete = gl::check_complete(gl, to.framebuffer, name); !complete) return complete;
  GLint drawn = GL_NONE;
  gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, to.framebuffer);
  gl.GetIntegerv(GL_DRAW_BUFFER0, &drawn);
  if (drawn == GL_NONE) return core::fail(name + ": its draw buffer is GL_NONE, so no colour would be drawn");
  return {};
}

core::Expected<void> Compositor::clear(const gl::ExternalTarget& to, const gpuprims::Background& background) {
  if (to.clear_colour) {
    if (!background_pass_) background_pass_.emplace(*gl_);
    if (auto done = background_pass_->fill(background, to); !done) return done;
  }
  if (!to.clear_depth) return {};
  const gl::Functions& gl = *gl_;
  gl::reset_pipeline_state(gl);
  gl.Scissor(to.x, to.y, to.width, to.height);
  gl.Enable(GL_SCISSOR_TEST);
  const auto far_depth = GLfloat(to.far_depth);
  gl.ClearNamedFramebufferfv(to.framebuffer, GL_DEPTH, 0, &far_depth);
  return {};
}

core::Expected<void> Compositor::draw(const RenderTarget& from, const gl::ExternalTarget& to,
                                      const gpuprims::Background& background) {
  assert(to.width == from.width() && to.height == from.height());
  if (auto good = check_target(*gl_, to); !good) return good;
  if (auto done = clear(to, background); !done) return done;
  return put(from, to);
}

core::Expected<void> Compositor::put(const RenderTarget& from, const gl::ExternalTarget& to) {
  const gl::Functions& gl = *gl_;
  const bool layer = source_ == Source::kLayer;
  const int samples = from.format().samples;
  GLint their_samples = 0;
  if (samples > 1) gl.GetNamedFramebufferParameteriv(to.framebuffer, GL_SAMPLES, &their_samples);
  const bool each = samples > 1 && their_samples == samples;
  const auto made = pass_.program(each ? each_sample_ : whole_pixels_, kComposite, samples, {layer, each});
  if (!made) return tl::unexpected(made.error());
  pass_.begin(**made, to);
  pass_.test_depth(to);
  if (layer) gl.DepthMask(GL_FALSE);
  if (layer || (samples > 1 && !each)) pass_.blend();
  gl.ProgramUniform2f((*made)->id(), kWindowDepthsUniform, GLfloat(to.near_depth), GLfloat(to.far_depth));
  pass_.draw(**made, std::array{from.colour().id(), from.depth().id()}, from.texture_target());
  return {};
}

}  // namespace sightline::render
