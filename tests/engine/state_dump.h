// All state of a context that OpenGL 4.5 core lets one ask for, by name: independent of what the library saves.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "sightline/gl/functions.h"

namespace sightline::tests {

using StateDump = std::map<std::string, std::vector<double>>;

inline StateDump dump_state(const gl::Functions& gl) {
  StateDump dump;
  const auto doubles = [&](const std::string& name, GLenum what, int count = 1) {
    std::vector<GLfloat> values(std::size_t(std::max(count, 4)), 0.0f);
    gl.GetFloatv(what, values.data());
    dump[name].assign(values.begin(), values.begin() + count);
  };
  const auto integers = [&](const std::string& name, GLenum what, int count = 1) {
    std::vector<GLint> values(std::size_t(std::max(count, 4)), 0);
    gl.GetIntegerv(what, values.data());
    dump[name].assign(values.begin(), values.begin() + count);
  };
  const auto indexed = [&](const std::string& name, GLenum what, GLuint from, GLuint to, int count = 1) {
    for (GLuint i = from; i < to; ++i) {
      std::vector<GLint> values(4, 0);
      gl.GetIntegeri_v(what, i, values.data());
      dump[name + " " + std::to_string(i)].assign(values.begin(), values.begin() + count);
    }
  };
  const auto indexed64 = [&](const std::string& name, GLenum what, GLuint to) {
    for (GLuint i = 0; i < to; ++i) {
      GLint64 value = 0;
      gl.GetInteger64i_v(what, i, &value);
      dump[name + " " + std::to_string(i)] = {double(value)};
    }
  };
#define FLAG(what) dump[#what] = { double(gl.IsEnabled(what)) }
#define INTEGER(what) integers(#what, what)
#define INTEGERS(what, count) integers(#what, what, count)
#define NUMBER(what) doubles(#what, what)
#define NUMBERS(what, count) doubles(#what, what, count)

  // Vertices
  INTEGER(GL_VERTEX_ARRAY_BINDING);
  INTEGER(GL_ARRAY_BUFFER_BINDING);
  INTEGER(GL_ELEMENT_ARRAY_BUFFER_BINDING);
  FLAG(GL_PRIMITIVE_RESTART);
  FLAG(GL_PRIMITIVE_RESTART_FIXED_INDEX);
  INTEGER(GL_PRIMITIVE_RESTART_INDEX);
  INTEGER(GL_PROVOKING_VERTEX);
  INTEGER(GL_PATCH_VERTICES);
  NUMBERS(GL_PATCH_DEFAULT_INNER_LEVEL, 2);
  NUMBERS(GL_PATCH_DEFAULT_OUTER_LEVEL, 4);
  for (GLuint i = 0; i < 8; ++i)
    dump["clip distance " + std::to_string(i)] = {double(gl.IsEnabled(GL_CLIP_DISTANCE0 + i))};
  FLAG(GL_DEPTH_CLAMP);
  INTEGER(GL_CLIP_ORIGIN);
  INTEGER(GL_CLIP_DEPTH_MODE);
  INTEGER(GL_CURRENT_PROGRAM);
  INTEGER(GL_PROGRAM_PIPELINE_BINDING);
  FLAG(GL_RASTERIZER_DISCARD);
  INTEGER(GL_TRANSFORM_FEEDBACK_BINDING);
  INTEGER(GL_TRANSFORM_FEEDBACK_BUFFER_BINDING);
  INTEGER(GL_TRANSFORM_FEEDBACK_PAUSED);
  INTEGER(GL_TRANSFORM_FEEDBACK_ACTIVE);

  // Rasterisation
  NUMBER(GL_POINT_SIZE);
  NUMBER(GL_POINT_FADE_THRESHOLD_SIZE);
  INTEGER(GL_POINT_SPRITE_COORD_ORIGIN);
  FLAG(GL_PROGRAM_POINT_SIZE);
  NUMBER(GL_LINE_WIDTH);
  FLAG(GL_LINE_SMOOTH);
  FLAG(GL_CULL_FACE);
  INTEGER(GL_CULL_FACE_MODE);
  INTEGER(GL_FRONT_FACE);
  FLAG(GL_POLYGON_SMOOTH);
  INTEGERS(GL_POLYGON_MODE, 2);
  NUMBER(GL_POLYGON_OFFSET_FACTOR);
  NUMBER(GL_POLYGON_OFFSET_UNITS);
  FLAG(GL_POLYGON_OFFSET_POINT);
  FLAG(GL_POLYGON_OFFSET_LINE);
  FLAG(GL_POLYGON_OFFSET_FILL);
  for (GLuint i = 0; i < 16; ++i) {
    const std::string at = " of viewport " + std::to_string(i);
    GLfloat viewport[4];
    gl.GetFloati_v(GL_VIEWPORT, i, viewport);
    dump["place" + at].assign(viewport, viewport + 4);
    GLdouble range[2];
    gl.GetDoublei_v(GL_DEPTH_RANGE, i, range);
    dump["depth range" + at].assign(range, range + 2);
    dump["scissor test" + at] = {double(gl.IsEnabledi(GL_SCISSOR_TEST, i))};
  }
  indexed("scissor box", GL_SCISSOR_BOX, 0, 16, 4);

  // Samples
  FLAG(GL_MULTISAMPLE);
  FLAG(GL_SAMPLE_ALPHA_TO_COVERAGE);
  FLAG(GL_SAMPLE_ALPHA_TO_ONE);
  FLAG(GL_SAMPLE_COVERAGE);
  NUMBER(GL_SAMPLE_COVERAGE_VALUE);
  INTEGER(GL_SAMPLE_COVERAGE_INVERT);
  FLAG(GL_SAMPLE_SHADING);
  NUMBER(GL_MIN_SAMPLE_SHADING_VALUE);
  FLAG(GL_SAMPLE_MASK);
  indexed("sample mask", GL_SAMPLE_MASK_VALUE, 0, 1);

  // From fragments to pixels
  FLAG(GL_STENCIL_TEST);
  INTEGER(GL_STENCIL_FUNC);
  INTEGER(GL_STENCIL_REF);
  INTEGER(GL_STENCIL_VALUE_MASK);
  INTEGER(GL_STENCIL_WRITEMASK);
  INTEGER(GL_STENCIL_FAIL);
  INTEGER(GL_STENCIL_PASS_DEPTH_FAIL);
  INTEGER(GL_STENCIL_PASS_DEPTH_PASS);
  INTEGER(GL_STENCIL_BACK_FUNC);
  INTEGER(GL_STENCIL_BACK_REF);
  INTEGER(GL_STENCIL_BACK_VALUE_MASK);
  INTEGER(GL_STENCIL_BACK_WRITEMASK);
  INTEGER(GL_STENCIL_BACK_FAIL);
  INTEGER(GL_STENCIL_BACK_PASS_DEPTH_FAIL);
  INTEGER(GL_STENCIL_BACK_PASS_DEPTH_PASS);
  FLAG(GL_DEPTH_TEST);
  INTEGER(GL_DEPTH_FUNC);
  INTEGER(GL_DEPTH_WRITEMASK);
  for (GLuint i = 0; i < 8; ++i) {
    const std::string at = " of draw buffer " + std::to_string(i);
    dump["blending" + at] = {double(gl.IsEnabledi(GL_BLEND, i))};
    GLboolean mask[4];
    gl.GetBooleani_v(GL_COLOR_WRITEMASK, i, mask);
    dump["colour mask" + at].assign(mask, mask + 4);
  }
  for (const GLenum what : {GL_BLEND_SRC_RGB, GL_BLEND_SRC_ALPHA, GL_BLEND_DST_RGB, GL_BLEND_DST_ALPHA,
                            GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA})
    indexed("blending " + std::to_string(what), what, 0, 8);
  NUMBERS(GL_BLEND_COLOR, 4);
  FLAG(GL_FRAMEBUFFER_SRGB);
  FLAG(GL_DITHER);
  FLAG(GL_COLOR_LOGIC_OP);
  INTEGER(GL_LOGIC_OP_MODE);
  NUMBERS(GL_COLOR_CLEAR_VALUE, 4);
  NUMBER(GL_DEPTH_CLEAR_VALUE);
  INTEGER(GL_STENCIL_CLEAR_VALUE);
  INTEGER(GL_DRAW_FRAMEBUFFER_BINDING);
  INTEGER(GL_READ_FRAMEBUFFER_BINDING);
  INTEGER(GL_DRAW_BUFFER);
  INTEGER(GL_DRAW_BUFFER1);
  INTEGER(GL_READ_BUFFER);
  INTEGER(GL_RENDERBUFFER_BINDING);

  // Buffers
  INTEGER(GL_DRAW_INDIRECT_BUFFER_BINDING);
  INTEGER(GL_DISPATCH_INDIRECT_BUFFER_BINDING);
  if (gl.MultiDrawElementsIndirectCountARB) INTEGER(GL_PARAMETER_BUFFER_BINDING_ARB);
  INTEGER(GL_QUERY_BUFFER_BINDING);
  INTEGER(GL_PIXEL_PACK_BUFFER_BINDING);
  INTEGER(GL_PIXEL_UNPACK_BUFFER_BINDING);
  INTEGER(GL_COPY_READ_BUFFER_BINDING);
  INTEGER(GL_COPY_WRITE_BUFFER_BINDING);
  INTEGER(GL_TEXTURE_BUFFER_BINDING);
  INTEGER(GL_UNIFORM_BUFFER_BINDING);
  INTEGER(GL_SHADER_STORAGE_BUFFER_BINDING);
  INTEGER(GL_ATOMIC_COUNTER_BUFFER_BINDING);
  indexed("uniform buffer", GL_UNIFORM_BUFFER_BINDING, 0, 16);
  indexed64("start of uniform buffer", GL_UNIFORM_BUFFER_START, 16);
  indexed64("size of uniform buffer", GL_UNIFORM_BUFFER_SIZE, 16);
  indexed("storage buffer", GL_SHADER_STORAGE_BUFFER_BINDING, 0, 8);
  indexed64("start of storage buffer", GL_SHADER_STORAGE_BUFFER_START, 8);
  indexed64("size of storage buffer", GL_SHADER_STORAGE_BUFFER_SIZE, 8);
  indexed("counter buffer", GL_ATOMIC_COUNTER_BUFFER_BINDING, 0, 1);
  indexed("feedback buffer", GL_TRANSFORM_FEEDBACK_BUFFER_BINDING, 0, 4);

  // Textures
  INTEGER(GL_ACTIVE_TEXTURE);
  const GLint active = GLint(dump["GL_ACTIVE_TEXTURE"][0]);
  for (GLuint unit = 0; unit < 16; ++unit) {
    gl.ActiveTexture(GL_TEXTURE0 + unit);
    for (const GLenum what :
         {GL_TEXTURE_BINDING_1D, GL_TEXTURE_BINDING_2D, GL_TEXTURE_BINDING_3D, GL_TEXTURE_BINDING_1D_ARRAY,
          GL_TEXTURE_BINDING_2D_ARRAY, GL_TEXTURE_BINDING_RECTANGLE, GL_TEXTURE_BINDING_BUFFER,
          GL_TEXTURE_BINDING_CUBE_MAP, GL_TEXTURE_BINDING_CUBE_MAP_ARRAY, GL_TEXTURE_BINDING_2D_MULTISAMPLE,
          GL_TEXTURE_BINDING_2D_MULTISAMPLE_ARRAY, GL_SAMPLER_BINDING})
      integers("binding " + std::to_string(what) + " of unit " + std::to_string(unit), what);
  }
  gl.ActiveTexture(GLenum(active));
  for (const GLenum what : {GL_IMAGE_BINDING_NAME, GL_IMAGE_BINDING_LEVEL, GL_IMAGE_BINDING_FORMAT})
    indexed("image " + std::to_string(what), what, 0, 8);

  // Pixels on their way to and from memory, hints
  for (const GLenum what : {GL_PACK_ALIGNMENT, GL_PACK_ROW_LENGTH, GL_PACK_SKIP_PIXELS, GL_PACK_SKIP_ROWS,
                            GL_PACK_SWAP_BYTES, GL_PACK_LSB_FIRST, GL_PACK_IMAGE_HEIGHT, GL_PACK_SKIP_IMAGES,
                            GL_UNPACK_ALIGNMENT, GL_UNPACK_ROW_LENGTH, GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_ROWS,
                            GL_UNPACK_SWAP_BYTES, GL_UNPACK_LSB_FIRST, GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_IMAGES})
    integers("pixels " + std::to_string(what), what);
  INTEGER(GL_CLAMP_READ_COLOR);
  INTEGER(GL_LINE_SMOOTH_HINT);
  INTEGER(GL_POLYGON_SMOOTH_HINT);
  INTEGER(GL_TEXTURE_COMPRESSION_HINT);
  INTEGER(GL_FRAGMENT_SHADER_DERIVATIVE_HINT);
  FLAG(GL_TEXTURE_CUBE_MAP_SEAMLESS);
  FLAG(GL_DEBUG_OUTPUT);
  FLAG(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  INTEGER(GL_DEBUG_GROUP_STACK_DEPTH);
  for (const GLenum what : {GL_SAMPLES_PASSED, GL_ANY_SAMPLES_PASSED, GL_PRIMITIVES_GENERATED, GL_TIME_ELAPSED}) {
    GLint query = 0;
    gl.GetQueryiv(what, GL_CURRENT_QUERY, &query);
    dump["query " + std::to_string(what)] = {double(query)};
  }
#undef FLAG
#undef INTEGER
#undef INTEGERS
#undef NUMBER
#undef NUMBERS
  return dump;
}

}  // namespace sightline::tests
