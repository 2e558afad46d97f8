// An application that draws by itself, into a framebuffer of its own.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/view.h"
#include "sightline/gl/context.h"
#include "sightline/gl/external_target.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/texture.h"
#include "sightline/gl/internal/vertex_array.h"

namespace sightline::tests {

/// How an application makes depths: normalised device z is offset + scale * (reverse-Z depth from 1 to 0), then come
/// glClipControl and glDepthRange.
struct DepthMode {
  const char* name;
  double offset, scale;
  GLenum clip_depth;
  double range_near, range_far;  // glDepthRange
  double near_depth, far_depth;  // gl::ExternalTarget
  GLenum format = GL_DEPTH_COMPONENT24;
};

inline constexpr DepthMode kDepthModes[] = {
    {"Classic", 1.0, -2.0, GL_NEGATIVE_ONE_TO_ONE, 0.0, 1.0, 0.0, 1.0},
    {"ReverseZ", 0.0, 1.0, GL_ZERO_TO_ONE, 0.0, 1.0, 1.0, 0.0, GL_DEPTH_COMPONENT32F},
    {"ZeroToOne", 1.0, -1.0, GL_ZERO_TO_ONE, 0.0, 1.0, 0.0, 1.0, GL_DEPTH_COMPONENT32F},
    {"ZeroToOneWithoutClipControl", 1.0, -1.0, GL_NEGATIVE_ONE_TO_ONE, 0.0, 1.0, 0.5, 1.0},
    {"ReverseMinusOneToOne", -1.0, 2.0, GL_NEGATIVE_ONE_TO_ONE, 0.0, 1.0, 1.0, 0.0},
    {"DepthRange", 1.0, -2.0, GL_NEGATIVE_ONE_TO_ONE, 0.2, 0.7, 0.2, 0.7, GL_DEPTH24_STENCIL8},
};

class Application {
 public:
  static constexpr std::array<float, 4> kSky{0.2f, 0.4f, 0.6f, 1.0f};

  Application(const gl::Functions& functions, int width, int height, const DepthMode& depth_mode = kDepthModes[0],
              int samples = 1, GLenum colours = GL_RGBA8)
      : gl(functions), mode(depth_mode), array(functions) {
    colour = *gl::Texture2D::create(gl, width, height, colours, "application colour", samples);
    depth = *gl::Texture2D::create(gl, width, height, mode.format, "application depth", samples);
    const bool stencil = mode.format == GL_DEPTH24_STENCIL8;
    const gl::Attachment attachments[] = {
        {GL_COLOR_ATTACHMENT0, &colour}, {GLenum(stencil ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT), &depth}};
    framebuffer = *gl::Framebuffer::create(gl, attachments, "application");
    static constexpr gl::ShaderFile kShaders[] = {
        {"quad.vert",
         "// A test's own shader.\n"
         "layout(location = 0) uniform mat4 clip_from_world;\n"
         "layout(location = 1) uniform vec4 corners[4];\n"
         "void main() { gl_Position = clip_from_world * corners[gl_VertexID]; }\n"},
        {"quad.frag",
         "// A test's own shader.\n"
         "layout(location = 5) uniform vec4 colour;\nout vec4 pixel;\nvoid main() { pixel = colour; }\n"}};
    gl::ProgramDescription description;
    description.name = "application";
    description.stages = {{GL_VERTEX_SHADER, {"quad.vert"}}, {GL_FRAGMENT_SHADER, {"quad.frag"}}};
    description.shaders.tables = {kShaders};
    program = *gl::Program::create(gl, description);
  }

  int width() const { return colour.width(); }
  int height() const { return colour.height(); }

  /// All of its framebuffer, or a part of it.
  gl::ExternalTarget target() const { return target(0, 0, width(), height()); }
  gl::ExternalTarget target(int x, int y, int w, int h) const {
    return {framebuffer.id(), x, y, w, h, mode.near_depth, mode.far_depth};
  }

  void clear() const {
    set_state();
    gl.ClearNamedFramebufferfv(framebuffer.id(), GL_COLOR, 0, kSky.data());
    const auto far_depth = GLfloat(mode.far_depth);
    if (mode.format == GL_DEPTH24_STENCIL8)
      gl.ClearNamedFramebufferfi(framebuffer.id(), GL_DEPTH_STENCIL, 0, far_depth, 3);
    else
      gl.ClearNamedFramebufferfv(framebuffer.id(), GL_DEPTH, 0, &far_depth);
  }

  /// What it sets before it draws.
  void set_state() const {
    framebuffer.bind();
    gl.Viewport(0, 0, width(), height());
    gl.ClipControl(GL_LOWER_LEFT, mode.clip_depth);
    gl.DepthRange(mode.range_near, mode.range_far);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(mode.near_depth < mode.far_depth ? GL_LESS : GL_GREATER);
    gl.BindProgramPipeline(0);
    program.use();
    array.bind();
  }

  /// A quadrilateral in the world.
  void draw(const core::View& view, const std::array<core::dvec3, 4>& corners, core::vec3 rgb) const {
    set_state();
    core::dmat4 clip = view.clip_from_eye();
    for (int column = 0; column < 4; ++column)
      clip[column][2] = mode.offset * clip[column][3] + mode.scale * clip[column][2];
    const core::dmat4 full = clip * view.eye_from_world();
    std::array<float, 16> matrix;
    for (int i = 0; i < 16; ++i) matrix[std::size_t(i)] = float(full[i / 4][i % 4]);
    gl.ProgramUniformMatrix4fv(program.id(), 0, 1, GL_FALSE, matrix.data());
    std::array<float, 16> points;
    constexpr std::array<std::size_t, 4> kStrip{0, 1, 3, 2};
    for (std::size_t i = 0; i < 4; ++i)
      for (int k = 0; k < 4; ++k) points[4 * i + std::size_t(k)] = k < 3 ? float(corners[kStrip[i]][k]) : 1.0f;
    gl.ProgramUniform4fv(program.id(), 1, 4, points.data());
    gl.ProgramUniform4f(program.id(), 5, rgb.x, rgb.y, rgb.z, 1.0f);
    gl.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  }

  std::vector<std::uint8_t> pixels() const {
    std::vector<std::uint8_t> rgba(std::size_t(4 * width() * height()));
    colour.read(0, GL_RGBA, GL_UNSIGNED_BYTE, std::as_writable_bytes(std::span(rgba)));
    return rgba;
  }
  std::vector<float> depths() const {
    std::vector<float> values(std::size_t(width() * height()));
    depth.read(0, GL_DEPTH_COMPONENT, GL_FLOAT, std::as_writable_bytes(std::span(values)));
    return values;
  }

  /// The depths of one sample of each pixel.
  std::vector<float> sample_depths(int sample) const {
    static constexpr gl::ShaderFile kShaders[] = {
        {"whole.vert",
         "// A test's own shader.\n"
         "void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0, 1); }\n"},
        {"sample.frag",
         "// A test's own shader.\n"
         "layout(binding = 0) uniform sampler2DMS depths;\nlayout(location = 0) uniform int number;\nout float depth;\n"
         "void main() { depth = texelFetch(depths, ivec2(gl_FragCoord.xy), number).r; }\n"}};
    gl::ProgramDescription description;
    description.name = "sample of a depth";
    description.stages = {{GL_VERTEX_SHADER, {"whole.vert"}}, {GL_FRAGMENT_SHADER, {"sample.frag"}}};
    description.shaders.tables = {kShaders};
    const gl::Program reader = *gl::Program::create(gl, description);
    const gl::Texture2D values = *gl::Texture2D::create(gl, width(), height(), GL_R32F, "depths of a sample");
    const gl::Attachment attachment{GL_COLOR_ATTACHMENT0, &values};
    const gl::Framebuffer into = *gl::Framebuffer::create(gl, {&attachment, 1}, "depths of a sample");
    set_state();
    into.bind();
    gl.Disable(GL_DEPTH_TEST);
    reader.use();
    gl.BindTextureUnit(0, depth.id());
    gl.ProgramUniform1i(reader.id(), 0, sample);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    std::vector<float> read(std::size_t(width() * height()));
    values.read(0, GL_RED, GL_FLOAT, std::as_writable_bytes(std::span(read)));
    return read;
  }

  const gl::Functions& gl;
  DepthMode mode;
  gl::Texture2D colour, depth;
  gl::Framebuffer framebuffer;
  gl::Program program;
  gl::VertexArray array;
};

}  // namespace sightline::tests
