#include "sightline/tests/shaders/listed_sources.h"

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include "sightline/render/internal/renderer.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests::listed_sources_test {
namespace {

TEST(ListedSources, AreFoundByTheWholeText) {
  const std::vector<gl::ShaderFile> table = {{"a.vert", "#include \"b.glsl\"\nvoid main() {}\n"}, {"b.glsl", "// b\n"}};
  gl::ProgramDescription description;
  description.stages = {{GL_VERTEX_SHADER, {"a.vert"}}, {GL_FRAGMENT_SHADER, {"b.glsl", "a.vert"}}};
  description.shaders.tables = {table};
  description.shaders.defines = {"COUNT 3"};
  const ListedSources listed({{description}});
  for (const gl::StageDescription& stage : description.stages) {
    const std::string text = gl::assemble_stage(description.shaders, stage.files)->text;
    EXPECT_TRUE(listed.has(text));
    EXPECT_FALSE(listed.has(text + " "));
    EXPECT_FALSE(listed.has(text.substr(0, text.find("#line"))));
  }
  for (const char* other : {"COUNT 2", "COUNT"}) {
    description.shaders.defines = {other};
    EXPECT_FALSE(listed.has(gl::assemble_stage(description.shaders, description.stages[0].files)->text)) << other;
  }
  EXPECT_FALSE(listed.has(""));
}

using ListedSourcesTest = GlTest;

TEST_F(ListedSourcesTest, AreAllThatTestsCompile) {
  const gpuscene::BatchKind kinds[] = {gpuscene::BatchKind::kBox, gpuscene::BatchKind::kMesh};
  ASSERT_TRUE(render::Renderer::create(*context, kinds, {.normals = true}));
  EXPECT_EQ(sources_looked_for(), 5) << "stages of proxies, boxes and meshes";

  static const gl::Functions* functions = &gl();
  static const auto compile = [](std::string_view vertex) {
    const std::vector<gl::ShaderFile> table = {{"a.vert", vertex}};
    gl::ProgramDescription description;
    description.stages = {{GL_VERTEX_SHADER, {"a.vert"}}};
    description.shaders.tables = {table};
    EXPECT_TRUE(gl::Program::create(*functions, description));
  };
  EXPECT_NONFATAL_FAILURE(compile("void main() {}\n"), "no all_programs() lists");
  compile(std::string(kTestShader) + "void main() {}\n");
}

}  // namespace
}  // namespace sightline::tests::listed_sources_test
