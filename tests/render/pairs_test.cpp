// Pairs of floats in shaders against long double. A compiler that reorders or contracts their sums is found here.
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include "sightline/core/view.h"
#include "sightline/gl/internal/buffer.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gpuprims/internal/shaders.h"
#include "sightline/gpuprims/internal/view_block.h"
#include "sightline/tests/render/shaders.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::render {
namespace {

using Exact = glm::vec<3, long double>;

struct Case {
  glm::vec4 matrix[3], rest[3], a, a_low, b, b_low;
};
struct Answer {
  glm::vec4 high, low;
};

/// Numbers of very different sizes, many of whose sums cancel.
class PairCases {
 public:
  Case operator()() {
    Case c{};
    const core::dvec3 right = glm::normalize(direction()), up = glm::normalize(glm::cross(right, direction()));
    const core::dvec3 columns[3] = {right, up, glm::cross(right, up)};
    for (int i = 0; i < 3; ++i) {
      const auto bits = glm::floatBitsToUint(glm::vec3(columns[i])) & 0xfffff000u;
      c.matrix[i] = glm::vec4(glm::uintBitsToFloat(bits), 0.0f);
      c.rest[i] = glm::vec4(columns[i] - core::dvec3(c.matrix[i]), 0.0);
    }
    const core::dvec3 a = size() * direction(),
                      b = chance_(random_) < 0.5 ? size() * direction() : -a * (1.0 + 1e-7 * size());
    set(a, c.a, c.a_low), set(b, c.b, c.b_low);
    return c;
  }

 private:
  core::dvec3 direction() { return {side_(random_), side_(random_), side_(random_)}; }
  double size() { return std::exp2(exponent_(random_)); }
  static void set(const core::dvec3& value, glm::vec4& high, glm::vec4& low) {
    high = glm::vec4(value, 0.0);
    low = glm::vec4(value - core::dvec3(high), 0.0);
  }
  std::mt19937 random_{4301};
  std::uniform_real_distribution<double> side_{-1.0, 1.0}, chance_{0.0, 1.0}, exponent_{-12.0, 12.0};
};

Exact exact(const glm::vec4& high, const glm::vec4& low) {
  return Exact(glm::vec3(high)) + Exact(glm::vec3(low));
}

/// Largest component.
long double largest(const Exact& v) {
  const Exact size = glm::abs(v);
  return std::max(size.x, std::max(size.y, size.z));
}

using PairsTest = tests::GlTest;

TEST_F(PairsTest, AreAsExactAsTheySay) {
  constexpr GLuint kCases = 1u << 16;
  PairCases next;
  std::vector<Case> cases(kCases);
  for (Case& c : cases) c = next();

  gl::ProgramDescription description;
  description.name = "pairs";
  description.stages = {{GL_COMPUTE_SHADER, {"pairs.comp"}}};
  description.shaders.tables = {tests::shaders(), gpuprims::shaders()};
  auto program = gl::Program::create(gl(), description);
  ASSERT_TRUE(program) << program.error().message;
  auto input = gl::Buffer::create(gl(), cases.size() * sizeof(Case), cases.data(), 0, "cases");
  auto output = gl::Buffer::create(gl(), 4 * cases.size() * sizeof(Answer), nullptr, 0, "answers");
  ASSERT_TRUE(input && output);
  gl().BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, input->id());
  gl().BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, output->id());
  gl().ProgramUniform1ui(program->id(), 0, kCases);
  program->use();
  gl().DispatchCompute(kCases / 64, 1, 1);
  gl().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  std::vector<Answer> answers(4 * cases.size());
  output->read(0, output->size(), answers.data());

  for (GLuint i = 0; i < kCases; ++i) {
    const Case& c = cases[i];
    const Exact a = exact(c.a, c.a_low), b = exact(c.b, c.b_low);
    const auto answer = [&](int which) { return exact(answers[4 * i + which].high, answers[4 * i + which].low); };
    const long double sizes = largest(glm::abs(a) + glm::abs(b)), product = largest(a) * largest(b);
    ASSERT_LE(largest(answer(0) - (a + b)), 0x1p-46L * sizes) << "sum " << i;
    ASSERT_LE(largest(answer(1) - glm::cross(a, b)), 0x1p-44L * product) << "cross product " << i;
    Exact turned(0.0L);
    for (int k = 0; k < 3; ++k) turned += exact(c.matrix[k], c.rest[k]) * a[k];
    ASSERT_LE(largest(answer(2) - turned), 0x1p-33L * largest(a)) << "turned " << i;
    const long double total = a.x * b.x + a.y * b.y + a.z * b.z;
    ASSERT_LE(std::abs(answer(3).x - total), 0x1p-24L * std::abs(total) + 0x1p-44L * product) << "total " << i;
  }
}

/// What a view hands to shaders in pairs is what it is in double.
TEST(PairsOfView, KeepWhatFloatLoses) {
  const core::View view = *core::View::perspective(
      {{1.0e7 + 0.123, -2.0e6 + 0.456, 789.0}, {1.0e7 + 3.0, -2.0e6, 788.0}, {0, 0, 1}}, 0.8, 1.5, 0.1);
  const gpuprims::ViewBlock block = *gpuprims::make_view_block(view, 300, 200);
  const core::dmat4& eye_from_world = view.eye_from_world();
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r)
      EXPECT_NEAR(double(block.eye_from_world_parts[0][c][r]) + block.eye_from_world_parts[1][c][r],
                  eye_from_world[c][r], 0x1p-36);
  const core::dvec3 origins[] = {{1.0e7, -2.0e6, 800.0}, {1.0e7 + 1.0e4, -2.0e6 + 1.0e4, 0.0}};
  std::vector<glm::vec4> rows;
  gpuprims::eye_relative_origins(view, origins, rows);
  ASSERT_EQ(rows.size(), 4u);
  for (int i = 0; i < 2; ++i) {
    const core::dvec3 from_eye = core::dvec3(rows[2 * i]) + core::dvec3(rows[2 * i + 1]);
    const core::dvec3 expected(eye_from_world * core::dvec4(origins[i], 1.0));
    EXPECT_LE(glm::length(core::dmat3(eye_from_world) * from_eye - expected), 1e-11 * glm::length(expected)) << i;
  }
}

}  // namespace
}  // namespace sightline::render
