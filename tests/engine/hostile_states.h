// State that an application may leave in a context which it shares: one row each.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "sightline/gl/internal/buffer.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/query.h"
#include "sightline/gl/internal/texture.h"
#include "sightline/gl/internal/transform_feedback.h"
#include "sightline/gl/internal/vertex_array.h"
#include "sightline/gpuscene/internal/draw_lists.h"

namespace sightline::tests {

/// The application's own.
struct ForeignObjects {
  static constexpr GLsizei kUnits = 8;

  explicit ForeignObjects(const gl::Functions& functions)
      : table(functions),
        buffer(*gl::Buffer::create(table, 1 << 16, nullptr, GL_DYNAMIC_STORAGE_BIT, "foreign")),
        texture(*gl::Texture2D::create(table, 4, 4, GL_RGBA8, "foreign")),
        framebuffer(
            *gl::Framebuffer::create(table, std::array{gl::Attachment{GL_COLOR_ATTACHMENT0, &texture}}, "foreign")),
        feedback(table),
        vertices(table),
        samples(table, GL_SAMPLES_PASSED) {
    gl::ProgramDescription description;
    description.name = "foreign";
    description.stages = {{GL_VERTEX_SHADER, {"count_records.vert"}}};
    description.shaders = gpuscene::DrawLists::shader_context();
    description.feedback_varyings = {"command_count", "record_count"};
    program = *gl::Program::create(table, description);
    feedback.set_buffer(buffer.id(), 0, buffer.size());
    table.CreateSamplers(1, &sampler);
    table.SamplerParameteri(sampler, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    table.SamplerParameteri(sampler, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    table.CreateProgramPipelines(1, &pipeline);
  }
  ~ForeignObjects() {
    table.DeleteSamplers(1, &sampler);
    table.DeleteProgramPipelines(1, &pipeline);
  }

  const gl::Functions& table;
  gl::Buffer buffer;
  gl::Texture2D texture;
  gl::Framebuffer framebuffer;
  gl::TransformFeedback feedback;
  gl::VertexArray vertices;
  gl::Query samples;
  gl::Program program;
  GLuint sampler = 0, pipeline = 0;
};

struct HostileState {
  const char* name;
  std::function<void()> set, unset;
};

/// All state of OpenGL 4.5 core that could come between a draw and its image, or between an image and who reads it.
/// Rows that another row is stronger than are left out. `unset` gives GL's initial value.
inline std::vector<HostileState> hostile_states(const ForeignObjects& own) {
  const gl::Functions& gl = own.table;
  std::vector<HostileState> rows;
  const auto row = [&](const char* name, std::function<void()> set, std::function<void()> unset) {
    rows.push_back({name, std::move(set), std::move(unset)});
  };
  const auto enabled = [&](
                           const char* name, GLenum capability, std::function<void()> set = [] {},
                           std::function<void()> unset = [] {}) {
    row(
        name, [&gl, capability, set] { set(), gl.Enable(capability); },
        [&gl, capability, unset] { unset(), gl.Disable(capability); });
  };
  const auto bound = [&](const char* name, GLenum point) {
    row(
        name, [&own, point] { own.table.BindBuffer(point, own.buffer.id()); },
        [&gl, point] { gl.BindBuffer(point, 0); });
  };
  const auto stored = [&](const char* name, GLenum parameter, GLint value) {
    const bool alignment = parameter == GL_PACK_ALIGNMENT || parameter == GL_UNPACK_ALIGNMENT;
    row(
        name, [&gl, parameter, value] { gl.PixelStorei(parameter, value); },
        [&gl, parameter, alignment] { gl.PixelStorei(parameter, alignment ? 4 : 0); });
  };

  // Vertices and what is made of them
  enabled("primitive restart", GL_PRIMITIVE_RESTART, [&] { gl.PrimitiveRestartIndex(3); });
  enabled("primitive restart with the fixed index", GL_PRIMITIVE_RESTART_FIXED_INDEX);
  row(
      "last vertex provokes not", [&] { gl.ProvokingVertex(GL_FIRST_VERTEX_CONVENTION); },
      [&] { gl.ProvokingVertex(GL_LAST_VERTEX_CONVENTION); });
  row(
      "vertex array", [&] { own.vertices.bind(); }, [&] { gl.BindVertexArray(0); });
  row(
      "program", [&] { own.program.use(); }, [&] { gl.UseProgram(0); });
  row(
      "program pipeline", [&] { gl.UseProgram(0), gl.BindProgramPipeline(own.pipeline); },
      [&] { gl.BindProgramPipeline(0); });
  row(
      "transform feedback object", [&] { gl.BindTransformFeedback(GL_TRANSFORM_FEEDBACK, own.feedback.id()); },
      [&] { gl.BindTransformFeedback(GL_TRANSFORM_FEEDBACK, 0); });
  row(
      "transform feedback, paused",
      [&] {
        own.program.use();
        own.feedback.begin_points();
        gl.PauseTransformFeedback();
      },
      [&] {
        own.program.use();
        gl.BindTransformFeedback(GL_TRANSFORM_FEEDBACK, own.feedback.id());
        gl.ResumeTransformFeedback();
        own.feedback.end();
        gl.UseProgram(0);
      });
  enabled("rasterizer discard", GL_RASTERIZER_DISCARD);
  row(
      "clip distances",
      [&] {
        for (GLenum i = 0; i < 8; ++i) gl.Enable(GL_CLIP_DISTANCE0 + i);
      },
      [&] {
        for (GLenum i = 0; i < 8; ++i) gl.Disable(GL_CLIP_DISTANCE0 + i);
      });
  enabled("depth clamp", GL_DEPTH_CLAMP);
  row(
      "clip control", [&] { gl.ClipControl(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE); },
      [&] { gl.ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE); });
  row(
      "viewport", [&] { gl.Viewport(3, 5, 20, 10); }, [&] { gl.Viewport(0, 0, 0, 0); });
  row(
      "viewport 0", [&] { gl.ViewportIndexedf(0, 3.0f, 5.0f, 20.0f, 10.0f); }, [&] { gl.Viewport(0, 0, 0, 0); });
  row(
      "depth range", [&] { gl.DepthRange(0.75, 0.25); }, [&] { gl.DepthRange(0.0, 1.0); });
  row(
      "depth range of viewport 0", [&] { gl.DepthRangeIndexed(0, 0.75, 0.25); }, [&] { gl.DepthRange(0.0, 1.0); });

  // Rasterisation
  enabled(
      "culling of faces", GL_CULL_FACE, [&] { gl.CullFace(GL_FRONT_AND_BACK); }, [&] { gl.CullFace(GL_BACK); });
  enabled(
      "culling of front faces", GL_CULL_FACE, [&] { gl.CullFace(GL_FRONT); }, [&] { gl.CullFace(GL_BACK); });
  row(
      "clockwise front faces", [&] { gl.FrontFace(GL_CW); }, [&] { gl.FrontFace(GL_CCW); });
  row(
      "polygons as lines", [&] { gl.PolygonMode(GL_FRONT_AND_BACK, GL_LINE); },
      [&] { gl.PolygonMode(GL_FRONT_AND_BACK, GL_FILL); });
  row(
      "polygons as points", [&] { gl.PolygonMode(GL_FRONT_AND_BACK, GL_POINT); },
      [&] { gl.PolygonMode(GL_FRONT_AND_BACK, GL_FILL); });
  enabled(
      "polygon offset", GL_POLYGON_OFFSET_FILL, [&] { gl.PolygonOffset(-100.0f, -100.0f); },
      [&] { gl.PolygonOffset(0.0f, 0.0f); });
  enabled("smooth polygons", GL_POLYGON_SMOOTH);
  enabled("smooth lines", GL_LINE_SMOOTH);
  row(
      "line width", [&] { gl.LineWidth(7.0f); }, [&] { gl.LineWidth(1.0f); });
  row(
      "point size", [&] { gl.PointSize(7.0f); }, [&] { gl.PointSize(1.0f); });
  row(
      "hint for derivatives", [&] { gl.Hint(GL_FRAGMENT_SHADER_DERIVATIVE_HINT, GL_FASTEST); },
      [&] { gl.Hint(GL_FRAGMENT_SHADER_DERIVATIVE_HINT, GL_DONT_CARE); });

  // Samples
  row(
      "no multisampling", [&] { gl.Disable(GL_MULTISAMPLE); }, [&] { gl.Enable(GL_MULTISAMPLE); });
  enabled(
      "sample mask", GL_SAMPLE_MASK, [&] { gl.SampleMaski(0, 0x5); }, [&] { gl.SampleMaski(0, ~0u); });
  enabled(
      "sample coverage", GL_SAMPLE_COVERAGE, [&] { gl.SampleCoverage(0.5f, GL_FALSE); },
      [&] { gl.SampleCoverage(1.0f, GL_FALSE); });
  enabled("alpha to coverage", GL_SAMPLE_ALPHA_TO_COVERAGE);
  enabled("alpha to one", GL_SAMPLE_ALPHA_TO_ONE);
  enabled(
      "sample shading", GL_SAMPLE_SHADING, [&] { gl.MinSampleShading(1.0f); }, [&] { gl.MinSampleShading(0.0f); });

  // From fragments to pixels
  enabled("scissor test", GL_SCISSOR_TEST, [&] { gl.Scissor(3, 5, 20, 10); });
  row(
      "scissor test of viewport 0", [&] { gl.ScissorIndexed(0, 3, 5, 20, 10), gl.Enablei(GL_SCISSOR_TEST, 0); },
      [&] { gl.Disable(GL_SCISSOR_TEST); });
  enabled(
      "stencil test", GL_STENCIL_TEST, [&] { gl.StencilFunc(GL_NEVER, 0, ~0u); },
      [&] { gl.StencilFunc(GL_ALWAYS, 0, ~0u); });
  row(
      "no depth test", [&] { gl.Disable(GL_DEPTH_TEST); }, [&] { gl.Disable(GL_DEPTH_TEST); });
  enabled(
      "depth test that all fail", GL_DEPTH_TEST, [&] { gl.DepthFunc(GL_NEVER); }, [&] { gl.DepthFunc(GL_LESS); });
  row(
      "depth not written", [&] { gl.DepthMask(GL_FALSE); }, [&] { gl.DepthMask(GL_TRUE); });
  enabled(
      "blending", GL_BLEND, [&] { gl.BlendFunc(GL_ZERO, GL_ONE); }, [&] { gl.BlendFunc(GL_ONE, GL_ZERO); });
  row(
      "blending of colour alone", [&] { gl.BlendFunci(0, GL_ONE, GL_ONE), gl.Enablei(GL_BLEND, 0); },
      [&] { gl.BlendFunc(GL_ONE, GL_ZERO), gl.Disable(GL_BLEND); });
  enabled(
      "subtracting blending", GL_BLEND, [&] { gl.BlendEquation(GL_FUNC_REVERSE_SUBTRACT); },
      [&] { gl.BlendEquation(GL_FUNC_ADD); });
  enabled(
      "logic operation", GL_COLOR_LOGIC_OP, [&] { gl.LogicOp(GL_INVERT); }, [&] { gl.LogicOp(GL_COPY); });
  row(
      "no dithering", [&] { gl.Disable(GL_DITHER); }, [&] { gl.Enable(GL_DITHER); });
  enabled("sRGB framebuffers", GL_FRAMEBUFFER_SRGB);
  row(
      "colour not written", [&] { gl.ColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE); },
      [&] { gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE); });
  row(
      "ids not written", [&] { gl.ColorMaski(1, GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE); },
      [&] { gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE); });
  row(
      "framebuffer", [&] { own.framebuffer.bind(); }, [&] { gl.BindFramebuffer(GL_FRAMEBUFFER, 0); });
  row(
      "clear values", [&] { gl.ClearColor(1.0f, 0.0f, 1.0f, 0.0f), gl.ClearDepth(0.5), gl.ClearStencil(3); },
      [&] { gl.ClearColor(0.0f, 0.0f, 0.0f, 0.0f), gl.ClearDepth(1.0), gl.ClearStencil(0); });
  row(
      "query of samples", [&] { own.samples.begin(); }, [&] { own.samples.end(); });

  // What is bound
  bound("array buffer", GL_ARRAY_BUFFER);
  bound("draw indirect buffer", GL_DRAW_INDIRECT_BUFFER);
  bound("dispatch indirect buffer", GL_DISPATCH_INDIRECT_BUFFER);
  if (gl.MultiDrawElementsIndirectCountARB) bound("parameter buffer", GL_PARAMETER_BUFFER_ARB);
  bound("query buffer", GL_QUERY_BUFFER);
  bound("pixel pack buffer", GL_PIXEL_PACK_BUFFER);
  bound("pixel unpack buffer", GL_PIXEL_UNPACK_BUFFER);
  bound("texture buffer", GL_TEXTURE_BUFFER);
  bound("copy read buffer", GL_COPY_READ_BUFFER);
  bound("copy write buffer", GL_COPY_WRITE_BUFFER);
  for (const auto& [name, point] :
       {std::pair{"uniform buffers", GL_UNIFORM_BUFFER}, {"storage buffers", GL_SHADER_STORAGE_BUFFER}})
    row(
        name,
        [&own, point = GLenum(point)] {
          for (GLuint i = 0; i < 8; ++i) own.table.BindBufferBase(point, i, own.buffer.id());
        },
        [&gl, point = GLenum(point)] {
          for (GLuint i = 0; i < 8; ++i) gl.BindBufferBase(point, i, 0);
        });
  row(
      "ranges of uniform and storage buffers",
      [&own] {
        for (GLuint i = 0; i < 4; ++i) {
          own.table.BindBufferRange(GL_UNIFORM_BUFFER, i, own.buffer.id(), 1024 * GLintptr(i + 1), 512);
          own.table.BindBufferRange(GL_SHADER_STORAGE_BUFFER, i, own.buffer.id(), 1024 * GLintptr(i + 1), 256);
        }
      },
      [&gl] {
        for (GLuint i = 0; i < 4; ++i) {
          gl.BindBufferBase(GL_UNIFORM_BUFFER, i, 0);
          gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, i, 0);
        }
      });
  row(
      "textures",
      [&] {
        for (GLuint unit = 0; unit < GLuint(own.kUnits); ++unit) gl.BindTextureUnit(unit, own.texture.id());
        gl.ActiveTexture(GL_TEXTURE5);
      },
      [&] {
        for (GLuint unit = 0; unit < GLuint(own.kUnits); ++unit) gl.BindTextureUnit(unit, 0);
        gl.ActiveTexture(GL_TEXTURE0);
      });
  row(
      "samplers",
      [&] {
        for (GLuint unit = 0; unit < GLuint(own.kUnits); ++unit) gl.BindSampler(unit, own.sampler);
      },
      [&] { gl.BindSamplers(0, own.kUnits, nullptr); });

  // Pixels on their way to and from memory
  stored("pack alignment", GL_PACK_ALIGNMENT, 8);
  stored("pack row length", GL_PACK_ROW_LENGTH, 7);
  stored("pack skip pixels", GL_PACK_SKIP_PIXELS, 3);
  stored("pack skip rows", GL_PACK_SKIP_ROWS, 3);
  stored("pack swap bytes", GL_PACK_SWAP_BYTES, GL_TRUE);
  stored("pack least significant bit first", GL_PACK_LSB_FIRST, GL_TRUE);
  stored("pack image height", GL_PACK_IMAGE_HEIGHT, 3);
  stored("pack skip images", GL_PACK_SKIP_IMAGES, 3);
  stored("unpack alignment", GL_UNPACK_ALIGNMENT, 8);
  stored("unpack row length", GL_UNPACK_ROW_LENGTH, 7);
  stored("unpack skip pixels", GL_UNPACK_SKIP_PIXELS, 3);
  stored("unpack skip rows", GL_UNPACK_SKIP_ROWS, 3);
  stored("unpack swap bytes", GL_UNPACK_SWAP_BYTES, GL_TRUE);
  stored("unpack image height", GL_UNPACK_IMAGE_HEIGHT, 3);
  stored("unpack skip images", GL_UNPACK_SKIP_IMAGES, 3);
  row(
      "clamping of what is read", [&] { gl.ClampColor(GL_CLAMP_READ_COLOR, GL_TRUE); },
      [&] { gl.ClampColor(GL_CLAMP_READ_COLOR, GL_FIXED_ONLY); });
  return rows;
}

}  // namespace sightline::tests
