#include "sightline/study/gpu/feedback_pass.h"

#include <utility>

#include "sightline/culling/gpu/internal/shaders.h"
#include "sightline/study/gpu/shaders.h"

namespace sightline::study {

gl::ProgramDescription describe_feedback(std::string name, std::vector<std::string> defines) {
  gl::ProgramDescription description;
  description.name = std::move(name);
  description.shaders.tables = {shaders(), culling::shaders()};
  description.shaders.defines = std::move(defines);
  return description;
}

core::Expected<FeedbackPass> FeedbackPass::create(const gl::Functions& gl, const gl::ProgramDescription& description,
                                                  std::size_t record_bytes, std::size_t capacity) {
  auto program = gl::Program::create(gl, description);
  if (!program) return tl::unexpected(program.error());
  auto output = gl::Buffer::create(gl, record_bytes * capacity, nullptr, 0, description.name);
  if (!output) return tl::unexpected(output.error());
  auto framebuffer = gl::Framebuffer::create_attachmentless(gl, 1, 1, description.name);
  if (!framebuffer) return tl::unexpected(framebuffer.error());
  FeedbackPass pass;
  pass.gl_ = &gl;
  pass.record_bytes_ = record_bytes;
  pass.program_ = std::move(*program);
  pass.output_ = std::move(*output);
  pass.array_ = gl::VertexArray(gl);
  pass.framebuffer_ = std::move(*framebuffer);
  pass.feedback_ = gl::TransformFeedback(gl);
  pass.feedback_.set_buffer(pass.output_.id(), 0, pass.output_.size());
  pass.written_ = gl::Query(gl, GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN);
  return pass;
}

void FeedbackPass::run(std::uint32_t points) const {
  framebuffer_.bind();
  program_.use();
  array_.bind();
  gl_->Enable(GL_RASTERIZER_DISCARD);
  written_.begin();
  feedback_.begin_points();
  gl_->DrawArrays(GL_POINTS, 0, GLsizei(points));
  feedback_.end();
  written_.end();
  gl_->Disable(GL_RASTERIZER_DISCARD);
}

}  // namespace sightline::study
