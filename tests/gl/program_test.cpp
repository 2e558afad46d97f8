#include "sightline/gl/internal/program.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/gl/internal/buffer.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/texture.h"
#include "sightline/gl/internal/vertex_array.h"
#include "sightline/tests/gl/test_shaders.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::gl::program_test {
namespace {

using ProgramTest = tests::GlTest;

ProgramDescription describe(const std::string& name, std::vector<StageDescription> stages) {
  ProgramDescription description;
  description.name = name;
  description.stages = std::move(stages);
  description.shaders.tables = {tests::shaders()};
  return description;
}

ProgramDescription triangle() {
  return describe("triangle", {{GL_VERTEX_SHADER, {"triangle.vert"}}, {GL_FRAGMENT_SHADER, {"triangle.frag"}}});
}

/// Draws three times, near, then far, then a nearer half, into colour, ids and reverse-Z float depth.
TEST_F(ProgramTest, TriangleWithIdsAndReversedDepth) {
  constexpr int kSize = 16;
  constexpr std::size_t kPixels = 256;
  auto color = Texture2D::create(gl(), kSize, kSize, GL_RGBA8, "color");
  auto ids = Texture2D::create(gl(), kSize, kSize, GL_R32UI, "ids");
  auto depth = Texture2D::create(gl(), kSize, kSize, GL_DEPTH_COMPONENT32F, "depth");
  ASSERT_TRUE(color && ids && depth);
  const std::array<Attachment, 3> attachments = {
      {{GL_COLOR_ATTACHMENT0, &*color, 0}, {GL_COLOR_ATTACHMENT1, &*ids, 0}, {GL_DEPTH_ATTACHMENT, &*depth, 0}}};
  auto target = Framebuffer::create(gl(), attachments, "target");
  ASSERT_TRUE(target) << target.error().message;
  auto whole = Program::create(gl(), triangle());
  ASSERT_TRUE(whole) << whole.error().message;
  ProgramDescription half_description = triangle();
  half_description.shaders.defines = {"HALF"};
  auto half = Program::create(gl(), half_description);
  ASSERT_TRUE(half) << half.error().message;
  EXPECT_EQ(half->uniform("no_such_uniform"), -1);

  const VertexArray vertices(gl());
  vertices.bind();
  target->bind();
  gl().Viewport(0, 0, kSize, kSize);
  gl().ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  gl().Enable(GL_DEPTH_TEST);
  gl().DepthFunc(GL_GREATER);
  const float far_depth = 0.0f;
  const std::array<GLuint, 4> no_id = {0xffffffffu, 0, 0, 0};
  gl().ClearNamedFramebufferfv(target->id(), GL_DEPTH, 0, &far_depth);
  gl().ClearNamedFramebufferuiv(target->id(), GL_COLOR, 1, no_id.data());

  const auto draw = [&](const Program& program, float z, GLuint id, float red) {
    gl().ProgramUniform1f(program.id(), program.uniform("u_depth"), z);
    gl().ProgramUniform1ui(program.id(), program.uniform("u_id"), id);
    gl().ProgramUniform4f(program.id(), program.uniform("u_color"), red, 0.0f, 0.0f, 1.0f);
    program.use();
    gl().DrawArrays(GL_TRIANGLES, 0, 3);
  };
  draw(*whole, 0.5f, 1, 0.0f);
  draw(*whole, 0.25f, 2, 0.0f);
  draw(*half, 0.75f, 4000000000u, 1.0f);

  std::vector<std::uint32_t> id_pixels(kPixels);
  std::vector<float> depth_pixels(kPixels);
  std::vector<std::uint32_t> color_pixels(kPixels);
  ids->read(0, GL_RED_INTEGER, GL_UNSIGNED_INT, std::as_writable_bytes(std::span(id_pixels)));
  depth->read(0, GL_DEPTH_COMPONENT, GL_FLOAT, std::as_writable_bytes(std::span(depth_pixels)));
  color->read(0, GL_RGBA, GL_UNSIGNED_BYTE, std::as_writable_bytes(std::span(color_pixels)));
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      if (x + y == kSize - 1) continue;  // the half's edge runs through these centres
      SCOPED_TRACE(testing::Message() << "pixel " << x << ", " << y);
      const auto i = static_cast<std::size_t>(y) * kSize + static_cast<std::size_t>(x);
      const bool in_half = x + y < kSize - 1;
      EXPECT_EQ(id_pixels[i], in_half ? 4000000000u : 1u);
      EXPECT_EQ(depth_pixels[i], in_half ? 0.75f : 0.5f);
      EXPECT_EQ(color_pixels[i], in_half ? 0xff0000ffu : 0xff000000u);
    }
  }
}

/// Shaders of samples cast their rays through floor(gl_FragCoord.xy) + gl_SamplePosition. gl_FragCoord.z is the depth
/// where gl_FragCoord.xy is, which may be the place of the sample or the pixel's centre.
TEST_F(ProgramTest, FragmentsOfSamplesTellTheirPlaces) {
  constexpr int kSize = 8, kSamples = 4;
  constexpr std::size_t kPixels = kSize * kSize;
  auto coordinates = Texture2D::create(gl(), kSize, kSize, GL_RGBA32F, "coordinates", kSamples);
  auto places = Texture2D::create(gl(), kSize, kSize, GL_RGBA32F, "places", kSamples);
  auto one = Texture2D::create(gl(), kSize, kSize, GL_RGBA32F, "one sample");
  ASSERT_TRUE(coordinates && places && one);
  const std::array<Attachment, 2> attachments = {
      {{GL_COLOR_ATTACHMENT0, &*coordinates, 0}, {GL_COLOR_ATTACHMENT1, &*places, 0}}};
  auto target = Framebuffer::create(gl(), attachments, "target");
  const std::array<Attachment, 1> of_one = {{{GL_COLOR_ATTACHMENT0, &*one, 0}}};
  auto single = Framebuffer::create(gl(), of_one, "one sample");
  ASSERT_TRUE(target && single);
  const auto make = [&](const char* fragment, const char* define) {
    ProgramDescription description =
        describe(fragment, {{GL_VERTEX_SHADER, {"triangle.vert"}}, {GL_FRAGMENT_SHADER, {fragment}}});
    description.shaders.defines = {define};
    auto program = Program::create(gl(), description);
    EXPECT_TRUE(program) << program.error().message;
    return std::move(*program);
  };
  const Program draw = make("sample_places.frag", "SLOPE"), copy = make("one_sample.frag", "WHOLE");
  const VertexArray vertices(gl());
  vertices.bind();
  target->bind();
  gl().Viewport(0, 0, kSize, kSize);
  gl().ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  gl().ProgramUniform1f(draw.id(), draw.uniform("u_depth"), 0.25f);
  draw.use();
  gl().DrawArrays(GL_TRIANGLES, 0, 3);
  std::array<std::array<GLfloat, 2>, kSamples> expected{};
  for (GLuint s = 0; s < kSamples; ++s) gl().GetMultisamplefv(GL_SAMPLE_POSITION, s, expected[s].data());

  single->bind();
  copy.use();
  const auto sample = [&](const Texture2D& of, int which) {
    gl().ProgramUniform1i(copy.id(), copy.uniform("u_sample"), which);
    gl().BindTextureUnit(0, of.id());
    gl().DrawArrays(GL_TRIANGLES, 0, 3);
    std::vector<std::array<float, 4>> values(kPixels);
    one->read(0, GL_RGBA, GL_FLOAT, std::as_writable_bytes(std::span(values)));
    return values;
  };
  for (int s = 0; s < kSamples; ++s) {
    const auto at = sample(*coordinates, s), place = sample(*places, s);
    for (std::size_t i = 0; i < kPixels; ++i) {
      SCOPED_TRACE(testing::Message() << "sample " << s << ", pixel " << i << ", gl_FragCoord " << at[i][0] << ' '
                                      << at[i][1] << ' ' << at[i][2] << ", gl_SamplePosition " << place[i][0] << ' '
                                      << place[i][1]);
      ASSERT_EQ(at[i][3], float(s));
      ASSERT_EQ(std::floor(at[i][0]), float(i % kSize));
      ASSERT_EQ(std::floor(at[i][1]), float(i / kSize));
      ASSERT_EQ(place[i][0], expected[std::size_t(s)][0]);
      ASSERT_EQ(place[i][1], expected[std::size_t(s)][1]);
      EXPECT_NEAR(at[i][2], 0.25f + (at[i][0] + 2.0f * at[i][1]) / 64.0f, 1e-6f);
    }
  }
}

TEST_F(ProgramTest, FeedbackInOrder) {
  ProgramDescription description = describe("double", {{GL_VERTEX_SHADER, {"double.vert"}}});
  description.shaders.defines = {"FACTOR 2u"};
  description.feedback_varyings = {"v_doubled"};
  auto program = Program::create(gl(), description);
  ASSERT_TRUE(program) << program.error().message;
  std::vector<std::uint32_t> values(1000);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::uint32_t>(i * i);
  auto input = Buffer::create(gl(), std::span(values), 0, "input");
  auto output = Buffer::create(gl(), 4 * values.size(), nullptr, 0, "output");
  auto target = Framebuffer::create_attachmentless(gl(), 1, 1, "nothing");
  ASSERT_TRUE(input && output && target);

  const VertexArray vertices(gl());
  gl().VertexArrayVertexBuffer(vertices.id(), 0, input->id(), 0, 4);
  gl().VertexArrayAttribIFormat(vertices.id(), 0, 1, GL_UNSIGNED_INT, 0);
  gl().VertexArrayAttribBinding(vertices.id(), 0, 0);
  gl().EnableVertexArrayAttrib(vertices.id(), 0);
  vertices.bind();
  target->bind();
  program->use();
  gl().Enable(GL_RASTERIZER_DISCARD);
  gl().BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, output->id());
  gl().BeginTransformFeedback(GL_POINTS);
  gl().DrawArrays(GL_POINTS, 0, static_cast<GLsizei>(values.size()));
  gl().EndTransformFeedback();

  std::vector<std::uint32_t> doubled(values.size());
  output->read(0, output->size(), doubled.data());
  for (std::size_t i = 0; i < values.size(); ++i) ASSERT_EQ(doubled[i], 2 * values[i]) << i;
}

TEST_F(ProgramTest, ComputeReadsATextureBuffer) {
  auto program = Program::create(gl(), describe("square", {{GL_COMPUTE_SHADER, {"square.comp"}}}));
  ASSERT_TRUE(program) << program.error().message;
  std::vector<std::uint32_t> values(1000);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::uint32_t>(i);
  auto input = Buffer::create(gl(), std::span(values), 0, "input");
  auto output = Buffer::create(gl(), 4 * values.size(), nullptr, 0, "output");
  ASSERT_TRUE(input && output);
  auto view = TextureBuffer::create(gl(), *input, GL_R32UI, "view");
  ASSERT_TRUE(view) << view.error().message;
  program->use();
  gl().BindTextureUnit(0, view->id());
  gl().BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, output->id());
  gl().DispatchCompute(static_cast<GLuint>((values.size() + 63) / 64), 1, 1);
  gl().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  std::vector<std::uint32_t> squares(values.size());
  output->read(0, output->size(), squares.data());
  for (std::size_t i = 0; i < values.size(); ++i) ASSERT_EQ(squares[i], values[i] * values[i]) << i;
}

TEST_F(ProgramTest, CompileErrorNamesFileAndLine) {
  const auto program = Program::create(gl(), describe("wrong", {{GL_VERTEX_SHADER, {"broken.vert"}}}));
  ASSERT_FALSE(program);
  const std::string& message = program.error().message;
  EXPECT_NE(message.find("GL program 'wrong', vertex stage broken.vert does not compile"), std::string::npos)
      << message;
  EXPECT_NE(message.find("broken.glsl:3"), std::string::npos) << message;
  EXPECT_NE(message.find("no_such_name"), std::string::npos) << message;
  context->take_errors();
}

TEST_F(ProgramTest, LinesAfterAnIncludeAreRight) {
  const std::vector<ShaderFile> table = {{"a.vert", "\n#include \"b.glsl\"\n\nvoid main() { wrong; }\n"},
                                         {"b.glsl", "// 1\n// 2\n// 3\n// 4\n"}};
  ProgramDescription description = describe("lines", {{GL_VERTEX_SHADER, {"a.vert"}}});
  description.shaders.tables = {table};
  const auto program = Program::create(gl(), description);
  ASSERT_FALSE(program);
  EXPECT_NE(program.error().message.find("a.vert:4"), std::string::npos) << program.error().message;
  context->take_errors();
}

TEST_F(ProgramTest, MissingFileCycleAndLinkErrorsAreNamed) {
  const auto missing = Program::create(gl(), describe("absent", {{GL_VERTEX_SHADER, {"absent.vert"}}}));
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("no shader file is named 'absent.vert'"), std::string::npos);

  const std::vector<ShaderFile> table = {{"a", "#include \"b\"\n"},
                                         {"b", "#include \"a\"\n"},
                                         {"no_main.vert", "void helper();\nvoid main() { helper(); }\n"},
                                         {"main.frag", "void main() {}\n"}};
  ProgramDescription cyclic = describe("cyclic", {{GL_VERTEX_SHADER, {"a"}}});
  cyclic.shaders.tables = {table};
  const auto cycle = Program::create(gl(), cyclic);
  ASSERT_FALSE(cycle);
  EXPECT_NE(cycle.error().message.find("include cycle: a -> b -> a"), std::string::npos) << cycle.error().message;

  ProgramDescription unlinkable =
      describe("unlinkable", {{GL_VERTEX_SHADER, {"no_main.vert"}}, {GL_FRAGMENT_SHADER, {"main.frag"}}});
  unlinkable.shaders.tables = {table};
  const auto linked = Program::create(gl(), unlinkable);
  ASSERT_FALSE(linked);
  EXPECT_NE(linked.error().message.find("'unlinkable' does not link"), std::string::npos) << linked.error().message;
  context->take_errors();
}

TEST_F(ProgramTest, UnknownStageIsAnError) {
  const auto program = Program::create(gl(), describe("odd", {{GL_TEXTURE_2D, {"triangle.vert"}}}));
  ASSERT_FALSE(program);
  EXPECT_NE(program.error().message.find("not a shader stage"), std::string::npos) << program.error().message;
  context->take_errors();
}

}  // namespace
}  // namespace sightline::gl::program_test
