#include "sightline/render/internal/pixel_pass.h"

#include "sightline/gl/internal/pipeline_state.h"
#include "sightline/render/internal/render_target.h"
#include "sightline/render/internal/shaders.h"

namespace sightline::render {
namespace {

constexpr GLuint kDrawBuffers = 8;  // as many as GL guarantees

gl::ProgramDescription describe_pixel_pass(const PixelShader& shader, int samples, std::array<bool, 2> switches) {
  gl::ProgramDescription description;
  description.name = shader.file;
  description.stages = {{GL_VERTEX_SHADER, {"whole_viewport.vert"}}, {GL_FRAGMENT_SHADER, {shader.file}}};
  description.shaders.tables = {shaders()};
  if (samples > 1) description.shaders.defines.push_back("SAMPLES " + std::to_string(samples));
  for (std::size_t i = 0; i < switches.size(); ++i)
    if (const char* define = shader.switches[i][switches[i]]) description.shaders.defines.emplace_back(define);
  return description;
}

}  // namespace

std::vector<gl::PipelineDescription> PixelPass::all_programs() {
  std::vector<gl::PipelineDescription> all;
  for (const PixelShader& shader : kPixelShaders)
    for (const int samples : kSampleCounts)
      for (const bool first : {false, true})
        for (const bool second : {false, true}) all.push_back({describe_pixel_pass(shader, samples, {first, second})});
  return all;
}

core::Expected<const gl::Program*> PixelPass::program(gl::Program& made, const PixelShader& shader, int samples,
                                                      std::array<bool, 2> switches) const {
  if (no_attributes_.id() == 0) no_attributes_ = gl::VertexArray(*gl_);
  if (auto there = gl::check_names(*gl_, {no_attributes_.id()}, "vertex array"); !there)
    return tl::unexpected(there.error());
  if (made.id() != 0) return &made;
  auto program = gl::Program::create(*gl_, describe_pixel_pass(shader, samples, switches));
  if (!program) return tl::unexpected(program.error());
  made = std::move(*program);
  return &made;
}

void PixelPass::begin(const gl::Program& program, const gl::ExternalTarget& to) const {
  const gl::Functions& gl = *gl_;
  gl::reset_pipeline_state(gl);
  gl.Disable(GL_DEPTH_TEST);
  gl.Disable(GL_STENCIL_TEST);
  gl.Disable(GL_FRAMEBUFFER_SRGB);
  gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, to.framebuffer);
  for (GLuint i = 1; i < kDrawBuffers; ++i) gl.ColorMaski(i, GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  gl.Viewport(to.x, to.y, to.width, to.height);
  gl.ProgramUniform2i(program.id(), kCorner, to.x, to.y);
  gl.ProgramUniform1i(program.id(), kLinearColour, to.linear_colour);
}

void PixelPass::test_depth(const gl::ExternalTarget& to) const {
  gl_->Enable(GL_DEPTH_TEST);
  gl_->DepthFunc(to.near_depth < to.far_depth ? GL_LESS : GL_GREATER);
}

void PixelPass::blend() const {
  gl_->Enablei(GL_BLEND, 0);
  gl_->BlendEquationSeparatei(0, GL_FUNC_ADD, GL_FUNC_ADD);
  gl_->BlendFuncSeparatei(0, GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
}

void PixelPass::draw(const gl::Program& program, std::span<const GLuint> textures, GLenum texture_target) const {
  const gl::Functions& gl = *gl_;
  for (std::size_t i = 0; i < textures.size(); ++i) gl.BindTextureUnit(GLuint(i), textures[i]);
  program.use();
  no_attributes_.bind();
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  gl.UseProgram(0);
  // Later draws write to them.
  for (std::size_t i = 0; i < textures.size(); ++i) gl::unbind_texture(gl, GLuint(i), texture_target);
}

}  // namespace sightline::render
