// Every program that the library can ask for, compiled without a driver.
#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include "sightline/tests/shaders/library_programs.h"
#include "sightline/tests/support/effort.h"
#include "sightline/tests/support/glslang.h"

namespace sightline::tests::programs_test {
namespace {

TEST(Programs, AreValid) {
  expect_valid(library_programs());
}

/// A workaround changes many pipelines alike, so that one in six of them shows its mistakes. A long run compiles all.
TEST(Programs, AreValidWithAllWorkarounds) {
  gl::Workarounds all;
  for (const gl::WorkaroundFacts& facts : gl::workaround_facts()) all.set(facts.workaround, true);
  std::vector<gl::PipelineDescription> changed;
  for (const gl::PipelineDescription& pipeline : library_programs())
    if (asks_for(pipeline, all)) changed.push_back(worked_around(pipeline, all));
  std::shuffle(changed.begin(), changed.end(), std::mt19937(1));
  changed.resize(std::size_t(repeated(int(changed.size()), 6)));
  EXPECT_GT(changed.size(), 100u);
  expect_valid(changed);
}

/// What is said of a program with a vertex stage "a.vert" and a fragment stage "a.frag", both of which may include
/// "b.glsl".
std::string complaint(const std::string& vertex, const std::string& fragment, const std::string& included = "") {
  const std::vector<gl::ShaderFile> table = {{"a.vert", vertex}, {"a.frag", fragment}, {"b.glsl", included}};
  gl::ProgramDescription description;
  description.name = "tried";
  description.stages = {{GL_VERTEX_SHADER, {"a.vert"}}, {GL_FRAGMENT_SHADER, {"a.frag"}}};
  description.shaders.tables = {table};
  description.shaders.defines = {"COUNT 3"};
  return glslang_complaint({description});
}

const char* const kVertex =
    "layout(location = 0) out vec3 p;\nvoid main() { p = vec3(gl_VertexID); gl_Position = vec4(p, 1); }\n";
const char* const kFragment =
    "layout(location = 0) in vec3 p;\nlayout(location = 0) out vec4 pixel;\nvoid main() { pixel = vec4(p, 1); }\n";

TEST(Programs, AreRefusedWithFileAndLine) {
  const auto says = [](const std::string& all, const char* part) {
    EXPECT_NE(all.find(part), std::string::npos) << "expected '" << part << "' in: " << all;
  };
  EXPECT_EQ(complaint(kVertex, kFragment), "");

  const std::string wrong =
      complaint(kVertex, "#include \"b.glsl\"\nvoid main() {}\n", "\nfloat f() { return none; }\n");
  says(wrong, "ERROR: b.glsl:2: 'none' : undeclared identifier");
  says(complaint(kVertex, "#if COUNT == 3\n#error three\n#endif\nvoid main() {}\n"),
       "ERROR: a.frag:2: '#error' : three");
  says(complaint("#extension GL_none : enable\nvoid main() { gl_Position = vec4(0); }\n", kFragment),
       "WARNING: a.vert:1: '#extension' : extension not supported: GL_none");
  says(complaint("layout(location = 0) out vec4 p;\nvoid main() { p = gl_Position = vec4(0); }\n", kFragment),
       "Types must match");
  says(complaint("out vec3 p;\nvoid main() { p = gl_Position.xyz = vec3(0); }\n", kFragment),
       "ERROR: a.vert:1: 'location' : SPIR-V requires location for user input/output");
  says(
      complaint("layout(location = 0) uniform bool on;\nvoid main() { gl_Position = vec4(on); }\n", "void main() {}\n"),
      "OpTypeBool");
  says(complaint(kVertex, "#include \"none.glsl\"\n"), "no shader file is named 'none.glsl'");
}

/// A fragment stage with a mistake, of two pipelines that it shares with a vertex stage.
std::vector<gl::PipelineDescription> two_pipelines_with_a_mistake() {
  static constexpr gl::ShaderFile kFiles[] = {{"a.vert", "void main() { gl_Position = vec4(1.0); }\n"},
                                              {"a.frag", "void main() { none(); }\n"}};
  gl::ProgramDescription vertex, fragment;
  vertex.name = "first half";
  vertex.stages = {{GL_VERTEX_SHADER, {"a.vert"}}};
  fragment.name = "second half";
  fragment.stages = {{GL_FRAGMENT_SHADER, {"a.frag"}}};
  vertex.shaders.tables = fragment.shaders.tables = {kFiles};
  fragment.shaders.defines = {"COUNT 3", "MORE"};
  return {{vertex, fragment}, {fragment}};
}

TEST(Programs, WithTheSameMistakeAreNamedOnce) {
  EXPECT_NONFATAL_FAILURE(
      expect_valid(two_pipelines_with_a_mistake()),
      "2 pipelines, the first of them 'first half' () with 'second half' (COUNT 3, MORE):\nERROR: a.frag:1: 'none'");
}

}  // namespace
}  // namespace sightline::tests::programs_test
