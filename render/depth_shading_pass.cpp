#include "sightline/render/internal/depth_shading_pass.h"

#include "sightline/gl/internal/pipeline_state.h"
#include "sightline/gpuprims/internal/view_block.h"

namespace sightline::render {
namespace {

enum Uniform : GLint { kPixelDepth = 3, kShading = 4, kLines = 5 };

}  // namespace

core::Expected<void> DepthShadingPass::draw(const RenderTarget& image, const core::View& view, float shading,
                                            float lines) {
  const auto program = pass_.program(program_, kDepthShading, image.format().samples);
  if (!program) return tl::unexpected(program.error());
  const gl::Functions& gl = *gl_;
  const gl::ExternalTarget whole{image.framebuffer().id(), 0, 0, image.width(), image.height()};
  pass_.begin(**program, whole);
  gl.DepthMask(GL_FALSE);  // it is read
  gl.ColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
  gl.Enablei(GL_BLEND, 0);
  gl.BlendEquationSeparatei(0, GL_FUNC_ADD, GL_FUNC_ADD);
  gl.BlendFuncSeparatei(0, GL_ZERO, GL_SRC_COLOR, GL_ZERO, GL_ONE);
  const glm::vec2 step = gpuprims::pixel_depth(view, image.height());
  const GLuint id = (*program)->id();
  gl.ProgramUniform2f(id, kPixelDepth, step.x, step.y);
  gl.ProgramUniform1f(id, kShading, shading);
  gl.ProgramUniform1f(id, kLines, lines);
  const GLuint depth = image.depth().id();
  pass_.draw(**program, {&depth, 1}, image.texture_target());
  gl::reset_pipeline_state(gl);
  return {};
}

}  // namespace sightline::render
