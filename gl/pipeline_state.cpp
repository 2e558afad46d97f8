#include "sightline/gl/internal/pipeline_state.h"

namespace sightline::gl {
namespace {

/// Off for all viewports, draw buffers and samples. The list leaves out state that does not affect this library's
/// pixels: the stencil test (there is no stencil buffer), sRGB conversion (no format uses it), point parameters.
constexpr GLenum kOff[] = {
    GL_RASTERIZER_DISCARD,
    GL_PRIMITIVE_RESTART,
    GL_PRIMITIVE_RESTART_FIXED_INDEX,
    GL_CLIP_DISTANCE0,
    GL_CLIP_DISTANCE1,
    GL_CLIP_DISTANCE2,
    GL_CLIP_DISTANCE3,
    GL_CLIP_DISTANCE4,
    GL_CLIP_DISTANCE5,
    GL_CLIP_DISTANCE6,
    GL_CLIP_DISTANCE7,
    GL_CULL_FACE,
    GL_DEPTH_CLAMP,
    GL_LINE_SMOOTH,
    GL_POLYGON_SMOOTH,
    GL_POLYGON_OFFSET_FILL,
    GL_POLYGON_OFFSET_LINE,
    GL_POLYGON_OFFSET_POINT,
    GL_SCISSOR_TEST,
    GL_SAMPLE_ALPHA_TO_COVERAGE,
    GL_SAMPLE_ALPHA_TO_ONE,
    GL_SAMPLE_COVERAGE,
    GL_SAMPLE_MASK,
    GL_SAMPLE_SHADING,
    GL_BLEND,
    GL_COLOR_LOGIC_OP,
    GL_DITHER,
};

}  // namespace

std::span<const GLenum> pipeline_capabilities() {
  return kOff;
}

void unbind_texture(const Functions& gl, GLuint unit, GLenum target) {
  gl.ActiveTexture(GL_TEXTURE0 + unit);
  gl.BindTexture(target, 0);
}

void reset_pipeline_state(const Functions& gl) {
  for (const GLenum capability : kOff) gl.Disable(capability);
  gl.Enable(GL_MULTISAMPLE);
  gl.ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  gl.DepthRange(0.0, 1.0);
  gl.DepthMask(GL_TRUE);
  gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  gl.FrontFace(GL_CCW);
  gl.CullFace(GL_BACK);
  gl.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  gl.LineWidth(1.0f);
  gl.ProvokingVertex(GL_LAST_VERTEX_CONVENTION);  // flat values are equal, but interpolation may begin at this vertex
  gl.Hint(GL_FRAGMENT_SHADER_DERIVATIVE_HINT, GL_DONT_CARE);
  // Fetches from buffer textures need no sampler, and yet a driver of NVIDIA's calls them undefined beside one that
  // compares depths.
  gl.BindSamplers(0, kTextureUnits, nullptr);
  // On Mesa it also affects plain multi-draws.
  if (gl.MultiDrawElementsIndirectCountARB) gl.BindBuffer(GL_PARAMETER_BUFFER_ARB, 0);
}

}  // namespace sightline::gl
