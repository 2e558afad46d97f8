#include "sightline/gl/internal/saved_state.h"

#include <algorithm>
#include <cassert>

#include "sightline/gl/internal/pipeline_state.h"

namespace sightline::gl {
namespace {

/// Beside those that reset_pipeline_state() turns off. GL keeps scissor test and blending for each viewport and buffer.
constexpr GLenum kMoreCapabilities[] = {GL_MULTISAMPLE, GL_DEPTH_TEST, GL_STENCIL_TEST, GL_FRAMEBUFFER_SRGB,
                                        GL_PROGRAM_POINT_SIZE};
bool is_indexed(GLenum capability) {
  return capability == GL_SCISSOR_TEST || capability == GL_BLEND;
}
template <class Visit>
void for_each_unindexed_capability(const Visit& visit) {
  for (const auto list : {pipeline_capabilities(), std::span<const GLenum>(kMoreCapabilities)})
    for (const GLenum capability : list)
      if (!is_indexed(capability)) visit(capability);
}

constexpr std::pair<GLenum, GLenum> kTextureTargets[] = {
    {GL_TEXTURE_2D, GL_TEXTURE_BINDING_2D},
    {GL_TEXTURE_2D_MULTISAMPLE, GL_TEXTURE_BINDING_2D_MULTISAMPLE},
    {GL_TEXTURE_BUFFER, GL_TEXTURE_BINDING_BUFFER},
};
constexpr std::pair<GLenum, GLenum> kBufferPoints[] = {
    {GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING},
    {GL_SHADER_STORAGE_BUFFER, GL_SHADER_STORAGE_BUFFER_BINDING},
    {GL_DRAW_INDIRECT_BUFFER, GL_DRAW_INDIRECT_BUFFER_BINDING},
    {GL_QUERY_BUFFER, GL_QUERY_BUFFER_BINDING},
    {GL_PARAMETER_BUFFER_ARB, GL_PARAMETER_BUFFER_BINDING_ARB},  // last: an extension's
};
constexpr GLenum kBlending[] = {GL_BLEND_SRC_RGB,   GL_BLEND_DST_RGB,      GL_BLEND_SRC_ALPHA,
                                GL_BLEND_DST_ALPHA, GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA};
constexpr GLenum kUnpackSkips[] = {GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_ROWS};

std::size_t buffer_points(const Functions& gl) {
  return std::size(kBufferPoints) - (gl.MultiDrawElementsIndirectCountARB ? 0 : 1);
}

template <class Ranges>
void save_ranges(const Functions& gl, GLenum binding, GLenum start, GLenum size, Ranges& ranges) {
  for (GLuint i = 0; i < ranges.size(); ++i) {
    gl.GetIntegeri_v(binding, i, &ranges[i].buffer);
    gl.GetInteger64i_v(start, i, &ranges[i].start);
    gl.GetInteger64i_v(size, i, &ranges[i].size);
  }
}

template <class Ranges>
void restore_ranges(const Functions& gl, GLenum point, const Ranges& ranges) {
  for (GLuint i = 0; i < ranges.size(); ++i) {
    const auto& [buffer, start, size] = ranges[i];
    if (buffer != 0 && size != 0)
      gl.BindBufferRange(point, i, GLuint(buffer), GLintptr(start), GLsizeiptr(size));
    else
      gl.BindBufferBase(point, i, GLuint(buffer));
  }
}

}  // namespace

SavedState::SavedState(const Functions& gl) : gl_(gl) {
  save_rasterisation();
  save_bindings();
}

SavedState::~SavedState() {
  restore_bindings();
  restore_rasterisation();
}

GLint SavedState::get(GLenum name) const {
  GLint value = 0;
  gl_.GetIntegerv(name, &value);
  return value;
}

void SavedState::save_rasterisation() {
  std::size_t count = 0;
  for_each_unindexed_capability([&](GLenum capability) { enabled_[count++] = gl_.IsEnabled(capability); });
  assert(count <= kMostCapabilities);
  clip_control_ = {get(GL_CLIP_ORIGIN), get(GL_CLIP_DEPTH_MODE)};
  depth_func_ = get(GL_DEPTH_FUNC);
  front_face_ = get(GL_FRONT_FACE);
  cull_face_ = get(GL_CULL_FACE_MODE);
  provoking_vertex_ = get(GL_PROVOKING_VERTEX);
  derivative_hint_ = get(GL_FRAGMENT_SHADER_DERIVATIVE_HINT);
  gl_.GetIntegerv(GL_POLYGON_MODE, polygon_mode_.data());
  gl_.GetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
  gl_.GetFloatv(GL_LINE_WIDTH, &line_width_);
  for (GLuint i = 0; i < kDrawBuffers; ++i) {
    gl_.GetBooleani_v(GL_COLOR_WRITEMASK, i, draw_buffers_[i].mask.data());
    draw_buffers_[i].blends = gl_.IsEnabledi(GL_BLEND, i);
  }
  for (GLuint buffer = 0; buffer < blending_.size(); ++buffer)
    for (std::size_t i = 0; i < std::size(kBlending); ++i)
      gl_.GetIntegeri_v(kBlending[i], buffer, &blending_[buffer][i]);
  for (GLuint i = 0; i < kViewports; ++i) {
    ViewportState& state = viewports_[i];
    gl_.GetFloati_v(GL_VIEWPORT, i, state.viewport.data());
    gl_.GetDoublei_v(GL_DEPTH_RANGE, i, state.depth_range.data());
    gl_.GetIntegeri_v(GL_SCISSOR_BOX, i, state.scissor.data());
    state.scissors = gl_.IsEnabledi(GL_SCISSOR_TEST, i);
  }
}

void SavedState::restore_rasterisation() const {
  std::size_t count = 0;
  for_each_unindexed_capability([&](GLenum capability) { (enabled_[count++] ? gl_.Enable : gl_.Disable)(capability); });
  gl_.ClipControl(GLenum(clip_control_[0]), GLenum(clip_control_[1]));
  gl_.DepthFunc(GLenum(depth_func_));
  gl_.FrontFace(GLenum(front_face_));
  gl_.CullFace(GLenum(cull_face_));
  gl_.ProvokingVertex(GLenum(provoking_vertex_));
  gl_.Hint(GL_FRAGMENT_SHADER_DERIVATIVE_HINT, GLenum(derivative_hint_));
  gl_.PolygonMode(GL_FRONT_AND_BACK, GLenum(polygon_mode_[0]));
  gl_.DepthMask(depth_mask_);
  gl_.LineWidth(line_width_);
  for (GLuint i = 0; i < kDrawBuffers; ++i) {
    const auto& mask = draw_buffers_[i].mask;
    gl_.ColorMaski(i, mask[0], mask[1], mask[2], mask[3]);
    (draw_buffers_[i].blends ? gl_.Enablei : gl_.Disablei)(GL_BLEND, i);
  }
  for (GLuint buffer = 0; buffer < blending_.size(); ++buffer) {
    const auto value = [&](std::size_t i) { return GLenum(blending_[buffer][i]); };
    gl_.BlendFuncSeparatei(buffer, value(0), value(1), value(2), value(3));
    gl_.BlendEquationSeparatei(buffer, value(4), value(5));
  }
  for (GLuint i = 0; i < kViewports; ++i) {
    const ViewportState& state = viewports_[i];
    gl_.ViewportIndexedf(i, state.viewport[0], state.viewport[1], state.viewport[2], state.viewport[3]);
    gl_.DepthRangeIndexed(i, state.depth_range[0], state.depth_range[1]);
    gl_.ScissorIndexed(i, state.scissor[0], state.scissor[1], state.scissor[2], state.scissor[3]);
    (state.scissors ? gl_.Enablei : gl_.Disablei)(GL_SCISSOR_TEST, i);
  }
}

void SavedState::save_bindings() {
  framebuffers_ = {get(GL_DRAW_FRAMEBUFFER_BINDING), get(GL_READ_FRAMEBUFFER_BINDING)};
  program_ = get(GL_CURRENT_PROGRAM);
  pipeline_ = get(GL_PROGRAM_PIPELINE_BINDING);
  vertex_array_ = get(GL_VERTEX_ARRAY_BINDING);
  feedback_ = get(GL_TRANSFORM_FEEDBACK_BINDING);
  for (std::size_t i = 0; i < buffer_points(gl_); ++i) buffers_[i] = get(kBufferPoints[i].second);
  save_ranges(gl_, GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE, uniform_blocks_);
  save_ranges(gl_, GL_SHADER_STORAGE_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_START, GL_SHADER_STORAGE_BUFFER_SIZE,
              storage_blocks_);
  active_texture_ = get(GL_ACTIVE_TEXTURE);
  for (GLuint i = 0; i < kTextureUnits; ++i) {
    gl_.ActiveTexture(GL_TEXTURE0 + i);
    for (std::size_t k = 0; k < std::size(kTextureTargets); ++k) units_[i].textures[k] = get(kTextureTargets[k].second);
    units_[i].sampler = get(GL_SAMPLER_BINDING);
  }
  gl_.ActiveTexture(GLenum(active_texture_));
  for (std::size_t i = 0; i < std::size(kUnpackSkips); ++i) unpack_skips_[i] = get(kUnpackSkips[i]);
}

void SavedState::restore_bindings() const {
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, GLuint(framebuffers_[0]));
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, GLuint(framebuffers_[1]));
  gl_.BindTransformFeedback(GL_TRANSFORM_FEEDBACK, GLuint(feedback_));
  gl_.BindProgramPipeline(GLuint(pipeline_));
  gl_.UseProgram(gl_.IsProgram(GLuint(program_)) ? GLuint(program_) : 0);  // one that was deleted in use is gone
  gl_.BindVertexArray(GLuint(vertex_array_));
  restore_ranges(gl_, GL_UNIFORM_BUFFER, uniform_blocks_);
  restore_ranges(gl_, GL_SHADER_STORAGE_BUFFER, storage_blocks_);
  // After the ranges, which bind to these points, too.
  for (std::size_t i = 0; i < buffer_points(gl_); ++i) gl_.BindBuffer(kBufferPoints[i].first, GLuint(buffers_[i]));
  for (GLuint i = 0; i < kTextureUnits; ++i) {
    gl_.ActiveTexture(GL_TEXTURE0 + i);
    for (std::size_t k = 0; k < std::size(kTextureTargets); ++k)
      gl_.BindTexture(kTextureTargets[k].first, GLuint(units_[i].textures[k]));
    gl_.BindSampler(i, GLuint(units_[i].sampler));
  }
  gl_.ActiveTexture(GLenum(active_texture_));
  for (std::size_t i = 0; i < std::size(kUnpackSkips); ++i) gl_.PixelStorei(kUnpackSkips[i], unpack_skips_[i]);
}

}  // namespace sightline::gl
