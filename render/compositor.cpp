#include "sightline/render/internal/compositor.h"

#include <cassert>
#include <cmath>
#include <utility>

#include "sightline/gl/internal/pipeline_state.h"
#include "sightline/render/internal/shaders.h"

namespace sightline::render {
namespace {

enum Uniform : GLint { kCorner, kWindowDepths, kLinearColour };
enum TextureUnit : GLuint { kColours, kDepths };
constexpr GLuint kDrawBuffers = 8;

gl::ProgramDescription describe(int samples, bool each_sample) {
  gl::ProgramDescription description;
  description.name = "picture into a foreign framebuffer";
  description.stages = {{GL_VERTEX_SHADER, {"whole_viewport.vert"}}, {GL_FRAGMENT_SHADER, {"composite.frag"}}};
  description.shaders.tables = {shaders()};
  if (samples > 1) description.shaders.defines.push_back("SAMPLES " + std::to_string(samples));
  if (each_sample) description.shaders.defines.emplace_back("EACH_SAMPLE");
  return description;
}

/// IEC 61966-2-1.
float linear_of(float srgb) {
  return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f);
}

core::Expected<void> check(const gl::Functions& gl, const core::ExternalTarget& to) {
  const auto depth = [](double d) { return d >= 0.0 && d <= 1.0; };
  if (!depth(to.near_depth) || !depth(to.far_depth) || to.near_depth == to.far_depth)
    return core::fail("external target: expected two different depths between 0 and 1 at the near and far plane");
  if (to.framebuffer != 0 && !gl.IsFramebuffer(to.framebuffer))
    return core::fail("external target: " + std::to_string(to.framebuffer) +
                      " is no framebuffer in the engine's context");
  gl::discard_errors(gl);  // the application's
  return gl::check_complete(gl, to.framebuffer, "external target " + std::to_string(to.framebuffer));
}

}  // namespace

core::Expected<const gl::Program*> Compositor::program(int samples, bool each_sample) {
  gl::Program& made = each_sample ? each_sample_ : whole_pixels_;
  if (made.id() != 0) return &made;
  auto program = gl::Program::create(*gl_, describe(samples, each_sample));
  if (!program) return tl::unexpected(program.error());
  made = std::move(*program);
  return &made;
}

void Compositor::clear(const core::ExternalTarget& to, const std::array<float, 3>& background) const {
  const gl::Functions& gl = *gl_;
  gl.Scissor(to.x, to.y, to.width, to.height);
  gl.Enable(GL_SCISSOR_TEST);
  if (to.clear_colour) {
    std::array<float, 4> colour{background[0], background[1], background[2], 1.0f};
    if (to.linear_colour)
      for (std::size_t i = 0; i < 3; ++i) colour[i] = linear_of(colour[i]);
    gl.ClearNamedFramebufferfv(to.framebuffer, GL_COLOR, 0, colour.data());
  }
  const auto far_depth = GLfloat(to.far_depth);
  if (to.clear_depth) gl.ClearNamedFramebufferfv(to.framebuffer, GL_DEPTH, 0, &far_depth);
  gl.Disable(GL_SCISSOR_TEST);
}

core::Expected<void> Compositor::draw(const RenderTarget& from, const core::ExternalTarget& to,
                                      const std::array<float, 3>& background) {
  assert(to.width == from.width() && to.height == from.height());
  const gl::Functions& gl = *gl_;
  if (auto good = check(gl, to); !good) return good;
  const int samples = from.format().samples;
  GLint their_samples = 0;
  if (samples > 1) gl.GetNamedFramebufferParameteriv(to.framebuffer, GL_SAMPLES, &their_samples);
  const bool each_sample = samples > 1 && their_samples == samples;
  const auto made = program(samples, each_sample);
  if (!made) return tl::unexpected(made.error());

  gl::reset_pipeline_state(gl);
  gl.Disable(GL_STENCIL_TEST);
  gl.Disable(GL_FRAMEBUFFER_SRGB);
  gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, to.framebuffer);
  if (to.clear_colour || to.clear_depth) clear(to, background);
  for (GLuint i = 1; i < kDrawBuffers; ++i) gl.ColorMaski(i, GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  gl.Viewport(to.x, to.y, to.width, to.height);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(to.near_depth < to.far_depth ? GL_LESS : GL_GREATER);
  if (samples > 1 && !each_sample) {
    gl.Enablei(GL_BLEND, 0);
    gl.BlendEquationSeparatei(0, GL_FUNC_ADD, GL_FUNC_ADD);
    gl.BlendFuncSeparatei(0, GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  }
  gl.BindTextureUnit(kColours, from.colour().id());
  gl.BindTextureUnit(kDepths, from.depth().id());
  for (const GLuint unit : {kColours, kDepths}) gl.BindSampler(unit, 0);  // an application's may compare depths
  const GLuint id = (*made)->id();
  gl.ProgramUniform2i(id, kCorner, to.x, to.y);
  gl.ProgramUniform2f(id, kWindowDepths, GLfloat(to.near_depth), GLfloat(to.far_depth));
  gl.ProgramUniform1i(id, kLinearColour, to.linear_colour);
  (*made)->use();
  no_attributes_.bind();
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  gl.UseProgram(0);
  // The next frame draws to them.
  const GLenum target = samples > 1 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D;
  for (const GLuint unit : {kColours, kDepths}) gl::unbind_texture(gl, unit, target);
  return {};
}

}  // namespace sightline::render
