#include "sightline/render/internal/enlarge_pass.h"

#include <array>
#include <cassert>

namespace sightline::render {
namespace {

constexpr GLint kScaleUniform = 3;

}  // namespace

core::Expected<void> EnlargePass::draw(const RenderTarget& from, const RenderTarget& to) {
  assert(from.has_ids() == to.has_ids() && !to.has_normals());
  const auto program = pass_.program(program_, kEnlarge, 1, {to.has_ids(), false});
  if (!program) return tl::unexpected(program.error());
  const std::array textures = from.resolved_textures();
  to.begin_drawing();
  gl_->DepthFunc(GL_ALWAYS);
  gl_->ProgramUniform2f((*program)->id(), kScaleUniform, GLfloat(from.width()) / GLfloat(to.width()),
                        GLfloat(from.height()) / GLfloat(to.height()));
  pass_.draw(**program, textures, GL_TEXTURE_2D);
  return {};
}

}  // namespace sightline::render
