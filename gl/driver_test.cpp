#include "sightline/gl/internal/driver_test.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "sightline/gl/internal/buffer.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/pipeline_state.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/query.h"
#include "sightline/gl/internal/shaders.h"
#include "sightline/gl/internal/texture.h"
#include "sightline/gl/internal/timer.h"
#include "sightline/gl/internal/transform_feedback.h"
#include "sightline/gl/internal/vertex_array.h"

namespace sightline::gl {
namespace {

constexpr int kSize = 8;  // pixels on a side
constexpr std::int64_t kGuaranteedBlock = 1 << 27;

enum Shape : GLint { kAll, kLeft, kPoints };

ProgramDescription describe(const char* name, std::vector<StageDescription> stages) {
  ProgramDescription description;
  description.name = name;
  description.stages = std::move(stages);
  description.shaders.tables = {shaders()};
  return description;
}
ProgramDescription image_program() {
  auto description = describe("self-test's image",
                              {{GL_VERTEX_SHADER, {"driver_check.vert"}}, {GL_FRAGMENT_SHADER, {"driver_check.frag"}}});
  description.shaders.defines = {"WRITES_DEPTH"};
  return description;
}
ProgramDescription feedback_program() {
  auto description = describe("self-test's feedback", {{GL_VERTEX_SHADER, {"driver_check_feedback.vert"}},
                                                       {GL_GEOMETRY_SHADER, {"driver_check_feedback.geom"}}});
  description.feedback_varyings = {"first", "last"};
  return description;
}
ProgramDescription sum_program() {
  return describe("self-test's sum", {{GL_COMPUTE_SHADER, {"driver_check.comp"}}});
}

ProgramDescription proxies_program(bool geometry_stage) {
  auto description = describe("self-test's solids", {{GL_VERTEX_SHADER, {"driver_check_proxies.vert"}},
                                                     {GL_FRAGMENT_SHADER, {"driver_check_proxies.frag"}}});
  if (geometry_stage) description.stages.push_back({GL_GEOMETRY_SHADER, {"driver_check_proxies.geom"}});
  if (!geometry_stage) description.shaders.defines = {"CORNERS"};
  return description;
}

std::optional<Program> make_program(const Functions& gl, const ProgramDescription& description) {
  auto made = Program::create(gl, description);
  return made ? std::optional(std::move(*made)) : std::nullopt;
}

/// Draws shapes into an image of numbers and one of depths, and looks at pixels.
class CheckImage {
 public:
  static std::optional<CheckImage> create(const Functions& gl) {
    CheckImage image(gl);
    auto numbers = Texture2D::create(gl, kSize, kSize, GL_R32UI, "self-test's numbers");
    auto depths = Texture2D::create(gl, kSize, kSize, GL_DEPTH_COMPONENT32F, "self-test's depths");
    auto program = make_program(gl, image_program());
    if (!numbers || !depths || !program) return std::nullopt;
    image.numbers_ = std::move(*numbers);
    image.depths_ = std::move(*depths);
    image.program_ = std::move(*program);
    const std::array<Attachment, 2> attachments = {
        {{GL_COLOR_ATTACHMENT0, &image.numbers_, 0}, {GL_DEPTH_ATTACHMENT, &image.depths_, 0}}};
    auto framebuffer = Framebuffer::create(gl, attachments, "self-test");
    if (!framebuffer) return std::nullopt;
    image.framebuffer_ = std::move(*framebuffer);
    return image;
  }

  void begin(float cleared_depth) const {
    reset_pipeline_state(*gl_);
    const GLuint nothing[4] = {0, 0, 0, 0};
    gl_->ClearNamedFramebufferuiv(framebuffer_.id(), GL_COLOR, 0, nothing);
    gl_->ClearNamedFramebufferfv(framebuffer_.id(), GL_DEPTH, 0, &cleared_depth);
    framebuffer_.bind();
    set_up();
  }
  /// For any framebuffer.
  void set_up() const {
    gl_->Viewport(0, 0, kSize, kSize);
    gl_->ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    gl_->Enable(GL_DEPTH_TEST);
    gl_->DepthFunc(GL_GREATER);
    gl_->Enable(GL_PROGRAM_POINT_SIZE);
    array_.bind();
    program_.use();
  }
  /// `less_below`: pixel before which fragments write `less_depth`.
  void use(Shape shape, float depth, float edge = 0.0f, float less_below = 0.0f, float less_depth = 0.0f) const {
    const GLuint id = program_.id();
    gl_->ProgramUniform1i(id, 0, shape);
    gl_->ProgramUniform1f(id, 1, edge);
    gl_->ProgramUniform1f(id, 2, depth);
    gl_->ProgramUniform1f(id, 3, float(kSize));
    gl_->ProgramUniform1f(id, 4, less_below);
    gl_->ProgramUniform1f(id, 5, less_depth);
  }
  void draw(Shape shape, float depth, float edge = 0.0f, float less_below = 0.0f, float less_depth = 0.0f) const {
    use(shape, depth, edge, less_below, less_depth);
    gl_->DrawArrays(GL_TRIANGLES, 0, 3);
  }

  /// Reads the middle row: numbers + 1, 0 where nothing is.
  std::array<GLuint, kSize> numbers() const {
    std::array<GLuint, kSize * kSize> all;
    numbers_.read(0, GL_RED_INTEGER, GL_UNSIGNED_INT, std::as_writable_bytes(std::span(all)));
    std::array<GLuint, kSize> row;
    std::copy_n(all.begin() + kSize * (kSize / 2), kSize, row.begin());
    return row;
  }
  std::array<float, kSize * kSize> depths() const {
    std::array<float, kSize * kSize> all;
    depths_.read(0, GL_DEPTH_COMPONENT, GL_FLOAT, std::as_writable_bytes(std::span(all)));
    return all;
  }
  const VertexArray& array() const { return array_; }

 private:
  explicit CheckImage(const Functions& gl) : gl_(&gl), array_(gl) {}

  const Functions* gl_;
  Texture2D numbers_, depths_;
  Framebuffer framebuffer_;
  Program program_;
  VertexArray array_;
};

bool clip_control_works(const CheckImage& image) {
  image.begin(0.0f);
  image.draw(kAll, 0.625f);
  const auto depths = image.depths();
  return std::all_of(depths.begin(), depths.end(), [](float depth) { return std::abs(depth - 0.625f) < 1e-6f; });
}

/// Before the fourth pixel fragments are behind what is there, the rest in front; then all in front of those alone.
bool conservative_depth_works(const CheckImage& image) {
  image.begin(0.5f);
  image.draw(kAll, 0.75f, 0.0f, 4.0f, 0.25f);
  const auto first = image.numbers();
  image.draw(kAll, 0.875f, 0.0f, 4.0f, 0.625f);
  const auto second = image.numbers();
  const auto drawn = [](GLuint number) { return number != 0; };
  return std::none_of(first.begin(), first.begin() + 4, drawn) && std::all_of(first.begin() + 4, first.end(), drawn) &&
         std::all_of(second.begin(), second.end(), drawn);
}

/// Points of two indirect draws: numbers 1 and 2 from the base vertex 3, then 6.
CheckResult indexed_points(const Functions& gl, const CheckImage& image, bool count_from_buffer) {
  struct Command {
    GLuint count, instances, first;
    GLint base_vertex;
    GLuint base_instance;
  };
  const std::array<GLuint, 3> indices = {1, 2, 6};
  const std::array<Command, 2> commands = {{{2, 1, 0, 3, 0}, {1, 1, 2, 0, 0}}};
  const GLuint one = 1;
  auto index_buffer = Buffer::create(gl, sizeof indices, indices.data(), 0, "self-test's indices");
  auto command_buffer = Buffer::create(gl, sizeof commands, commands.data(), 0, "self-test's commands");
  auto count_buffer = Buffer::create(gl, sizeof one, &one, 0, "self-test's count");
  if (!index_buffer || !command_buffer || !count_buffer) return CheckResult::kNotRun;
  image.begin(0.0f);
  image.use(kPoints, 0.5f);
  gl.VertexArrayElementBuffer(image.array().id(), index_buffer->id());
  gl.BindBuffer(GL_DRAW_INDIRECT_BUFFER, command_buffer->id());
  if (count_from_buffer) {
    gl.BindBuffer(GL_PARAMETER_BUFFER_ARB, count_buffer->id());
    gl.MultiDrawElementsIndirectCountARB(GL_POINTS, GL_UNSIGNED_INT, nullptr, 0, 2, sizeof(Command));
    gl.BindBuffer(GL_PARAMETER_BUFFER_ARB, 0);
  } else {
    gl.MultiDrawElementsIndirect(GL_POINTS, GL_UNSIGNED_INT, nullptr, 2, sizeof(Command));
  }
  gl.BindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
  std::array<GLuint, kSize> expected{};
  for (const GLuint number : {4u, 5u, 6u})
    if (number < 6 || !count_from_buffer) expected[number] = number + 1;
  const auto numbers = image.numbers();
  // Where the base vertex is not counted, that is another check's matter.
  const bool right =
      count_from_buffer ? numbers[6] == 0 && numbers != std::array<GLuint, kSize>{} : numbers == expected;
  return right ? CheckResult::kPassed : CheckResult::kFailed;
}

CheckResult check_samples(const Functions& gl, const CheckImage& image, int samples) {
  auto depths = Texture2D::create(gl, kSize, kSize, GL_DEPTH_COMPONENT32F, "self-test's samples", samples);
  if (!depths) return CheckResult::kNotRun;
  auto framebuffer = Framebuffer::create(gl, std::array{Attachment{GL_DEPTH_ATTACHMENT, &*depths, 0}}, "self-test");
  if (!framebuffer) return CheckResult::kNotRun;
  reset_pipeline_state(gl);
  const float far_depth = 0.0f;
  gl.ClearNamedFramebufferfv(framebuffer->id(), GL_DEPTH, 0, &far_depth);
  framebuffer->bind();
  image.set_up();
  const Query passed(gl, GL_SAMPLES_PASSED);
  const auto count = [&](float edge) {
    gl.ClearNamedFramebufferfv(framebuffer->id(), GL_DEPTH, 0, &far_depth);
    passed.begin();
    image.draw(kLeft, 0.5f, edge);
    passed.end();
    return double(passed.result()) / (kSize * depths->samples());  // pixels of a row
  };
  // Up to the end of the third pixel, and to the middle of the fourth.
  const double whole = count(3.0f / kSize * 2.0f - 1.0f), half = count(3.5f / kSize * 2.0f - 1.0f) - 3.0;
  return std::abs(whole - 3.0) < 1e-9 && half >= 0.25 && half <= 0.75 ? CheckResult::kPassed : CheckResult::kFailed;
}

CheckResult check_feedback(const Functions& gl) {
  constexpr GLuint kVertices = 6;
  const auto program = make_program(gl, feedback_program());
  auto buffer =
      Buffer::create(gl, 5 * kVertices * sizeof(GLuint), nullptr, GL_DYNAMIC_STORAGE_BIT, "self-test's feedback");
  auto framebuffer = Framebuffer::create_attachmentless(gl, 1, 1, "self-test");
  if (!program || !buffer || !framebuffer) return CheckResult::kNotRun;
  const VertexArray array(gl);
  const TransformFeedback feedback(gl);
  const Query written(gl, GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN), counted(gl, GL_PRIMITIVES_GENERATED);
  feedback.set_buffer(buffer->id(), 0, buffer->size());
  framebuffer->bind();
  gl.Enable(GL_RASTERIZER_DISCARD);
  array.bind();
  program->use();
  written.begin();
  counted.begin(1);
  feedback.begin_points();
  gl.DrawArrays(GL_POINTS, 0, kVertices);
  feedback.end();
  counted.end(1);
  written.end();
  gl.Disable(GL_RASTERIZER_DISCARD);
  std::array<GLuint, 5 * kVertices> words;
  buffer->read(0, buffer->size(), words.data());
  bool right = written.result() == kVertices / 2 && counted.result() == kVertices / 2;
  for (GLuint i = 0; i < kVertices / 2; ++i)
    for (GLuint word = 0; word < 5; ++word) right &= words[5 * i + word] == 10 * i + word;
  return right ? CheckResult::kPassed : CheckResult::kFailed;
}

/// Adds 1 and 2^-30 on the GPU, and writes the sum and what it lost at the end of a buffer.
std::optional<std::array<float, 2>> sum_at_end(const Functions& gl, const Program& program, std::size_t bytes) {
  auto buffer = Buffer::create(gl, bytes, nullptr, GL_DYNAMIC_STORAGE_BIT, "self-test's storage");
  if (!buffer) return std::nullopt;
  const std::size_t offset = bytes - 2 * sizeof(float);
  gl.ProgramUniform2f(program.id(), 0, 1.0f, 0x1p-30f);
  gl.ProgramUniform1ui(program.id(), 1, GLuint(offset / sizeof(float)));
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer->id());
  program.use();
  gl.DispatchCompute(1, 1, 1);
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  std::array<float, 2> sum{};
  buffer->read(offset, sizeof sum, sum.data());
  return sum;
}

void check_computing(const Functions& gl, const Capabilities& has, DriverTest& test) {
  const auto program = make_program(gl, sum_program());
  if (!program) return;
  const auto result = [&](DriverCheck check) -> CheckResult& { return test.results[std::size_t(check)]; };
  const auto passed = [](bool right) { return right ? CheckResult::kPassed : CheckResult::kFailed; };
  if (const auto sum = sum_at_end(gl, *program, 4096))
    result(DriverCheck::kPreciseSums) = passed((*sum)[0] == 1.0f && (*sum)[1] == 0x1p-30f);
  // A software rasteriser's buffers are ordinary memory.
  if (has.software || has.max_storage_block_bytes <= kGuaranteedBlock) return;
  if (const auto sum = sum_at_end(gl, *program, kGuaranteedBlock + 4096))
    result(DriverCheck::kStorageBlocks) = passed((*sum)[0] == 1.0f);
}

CheckResult check_timer(const Functions& gl) {
  GLint bits = 0;
  gl.GetQueryiv(GL_TIMESTAMP, GL_QUERY_COUNTER_BITS, &bits);
  GLint64 now = 0;
  gl.GetInteger64v(GL_TIMESTAMP, &now);
  return bits > 0 && now != 0 ? CheckResult::kPassed : CheckResult::kFailed;
}

/// Draws small boxes as ray-cast solids are drawn, and times that.
class CheckProxies {
 public:
  CheckProxies(const Functions& gl, const Program& points, const Program& triangles, const Buffer& indices)
      : gl_(gl), points_(points), triangles_(triangles), array_(gl), timer_(gl) {
    gl.VertexArrayElementBuffer(array_.id(), indices.id());
    array_.bind();
  }

  /// In milliseconds, the least of several times; none when the timer does not tell one.
  std::optional<double> least_ms(bool geometry_stage) {
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 4; ++i) {
      timer_.begin();
      draw(geometry_stage);
      timer_.end();
      gl_.Finish();
      const auto ms = timer_.poll();
      if (!ms || *ms == GpuTimer::kNoTime) return std::nullopt;
      least = std::min(least, *ms);
    }
    return least;
  }

  static std::vector<std::uint16_t> indices() {
    std::vector<std::uint16_t> all;
    for (int i = 0; i < kBoxes; ++i)
      for (const int corner : {1, 3, 5, 5, 3, 7, 5, 7, 4, 4, 7, 6, 2, 6, 3, 3, 6, 7})
        all.push_back(std::uint16_t(8 * i + corner));
    return all;
  }

 private:
  static constexpr int kBoxes = 4096, kTimes = 16;
  void draw(bool geometry_stage) {
    (geometry_stage ? points_ : triangles_).use();
    if (geometry_stage) return gl_.DrawArraysInstanced(GL_POINTS, 0, kBoxes, kTimes);
    gl_.DrawElementsInstanced(GL_TRIANGLES, kBoxes * 18, GL_UNSIGNED_SHORT, nullptr, kTimes);
  }

  const Functions& gl_;
  const Program &points_, &triangles_;
  VertexArray array_;
  GpuTimer timer_;
};

/// Not on software rasterisers, where timers mean nothing. There both take as long (docs/results/drawing.md), so the
/// form that computes less stays.
CheckResult check_geometry_stage(const Functions& gl, const Capabilities& has, const CheckImage& image) {
  if (has.software) return CheckResult::kNotRun;
  const auto points = make_program(gl, proxies_program(true)), triangles = make_program(gl, proxies_program(false));
  const std::vector<std::uint16_t> list = CheckProxies::indices();
  auto indices = Buffer::create(gl, std::span(list), 0, "self-test's boxes");
  if (!points || !triangles || !indices) return CheckResult::kNotRun;
  image.begin(0.0f);
  CheckProxies boxes(gl, *points, *triangles, *indices);
  const auto with = boxes.least_ms(true), without = with ? boxes.least_ms(false) : std::nullopt;
  if (!without) return CheckResult::kNotRun;
  // The margin keeps the choice from changing by chance, and stands for what the renderer's vertices fetch.
  return *with <= 1.5 * *without ? CheckResult::kPassed : CheckResult::kFailed;
}

void check_drawing(const Functions& gl, const Capabilities& has, DriverTest& test) {
  const auto image = CheckImage::create(gl);
  if (!image) return;
  const auto result = [&](DriverCheck check) -> CheckResult& { return test.results[std::size_t(check)]; };
  const auto passed = [](bool right) { return right ? CheckResult::kPassed : CheckResult::kFailed; };
  result(DriverCheck::kClipControl) = passed(clip_control_works(*image));
  result(DriverCheck::kConservativeDepth) = passed(conservative_depth_works(*image));
  result(DriverCheck::kBaseVertex) = indexed_points(gl, *image, false);
  if (has.indirect_count) result(DriverCheck::kIndirectCount) = indexed_points(gl, *image, true);
  if (has.max_samples > 4) result(DriverCheck::kSamples) = check_samples(gl, *image, has.max_samples);
  if (test[DriverCheck::kTimer] == CheckResult::kPassed)
    result(DriverCheck::kGeometryStage) = check_geometry_stage(gl, has, *image);
}

}  // namespace

std::vector<PipelineDescription> driver_test_programs() {
  return {{image_program()}, {feedback_program()}, {sum_program()}, {proxies_program(true)}, {proxies_program(false)}};
}

DriverTest run_driver_test(const Functions& gl, const Capabilities& has) {
  const auto begin = std::chrono::steady_clock::now();
  DriverTest test;
  reset_pipeline_state(gl);
  test.results[std::size_t(DriverCheck::kTimer)] = check_timer(gl);
  check_drawing(gl, has, test);
  test.results[std::size_t(DriverCheck::kFeedback)] = check_feedback(gl);
  check_computing(gl, has, test);
  discard_errors(gl);
  test.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  return test;
}

}  // namespace sightline::gl
