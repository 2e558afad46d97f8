#include "sightline/render/internal/background_pass.h"

#include "sightline/core/internal/srgb.h"
#include "sightline/gl/internal/pipeline_state.h"

namespace sightline::render {
namespace {

constexpr GLint kBottom = 3, kTop = 4, kHeight = 5;

}  // namespace

void BackgroundPass::fill_evenly(const core::vec3& colour, const gl::ExternalTarget& to) const {
  glm::vec4 filled(colour, 1.0f);
  if (to.linear_colour)
    for (int i = 0; i < 3; ++i) filled[i] = float(core::linear_from_srgb(filled[i]));
  gl::reset_pipeline_state(*gl_);  // masks limit what is cleared
  gl_->Disable(GL_FRAMEBUFFER_SRGB);
  gl_->Scissor(to.x, to.y, to.width, to.height);
  gl_->Enable(GL_SCISSOR_TEST);
  gl_->ClearNamedFramebufferfv(to.framebuffer, GL_COLOR, 0, &filled.x);
  gl_->Disable(GL_SCISSOR_TEST);
}

core::Expected<void> BackgroundPass::fill(const gpuprims::Background& background, const gl::ExternalTarget& to) {
  if (background.top == background.bottom) return fill_evenly(background.top, to), core::Expected<void>();
  const auto program = pass_.program(program_, kBackground, 1);
  if (!program) return tl::unexpected(program.error());
  pass_.begin(**program, to);
  gl_->DepthMask(GL_FALSE);
  const GLuint id = (*program)->id();
  gl_->ProgramUniform3fv(id, kBottom, 1, &background.bottom.x);
  gl_->ProgramUniform3fv(id, kTop, 1, &background.top.x);
  gl_->ProgramUniform1f(id, kHeight, float(to.height));
  pass_.draw(**program, {}, GL_TEXTURE_2D);
  gl::reset_pipeline_state(*gl_);
  return {};
}

}  // namespace sightline::render
