#include "sightline/tests/shaders/listed_sources.h"

#include <gtest/gtest.h>

#include "sightline/tests/support/gl_test.h"

namespace sightline::tests {
namespace {

PFNGLSHADERSOURCEPROC compile_real = nullptr;
int looked_for = 0;

/// What gl::Program calls in place of glShaderSource().
void APIENTRY look_for_source(GLuint shader, GLsizei count, const GLchar* const* texts, const GLint* lengths) {
  static const ListedSources listed(listed_programs());
  ASSERT_EQ(count, 1);
  const std::string_view text(texts[0], std::size_t(lengths[0]));
  if (text.find(kTestShader) == std::string_view::npos) {
    ++looked_for;
    EXPECT_TRUE(listed.has(text)) << "A shader is compiled that no all_programs() lists:\n" << text.substr(0, 1000);
  }
  compile_real(shader, count, texts, lengths);
}

const bool watching = [] {
  watch_functions = [](gl::Functions& gl) {
    compile_real = gl.ShaderSource;
    gl.ShaderSource = look_for_source;
  };
  return true;
}();

}  // namespace

ListedSources::ListedSources(std::vector<gl::PipelineDescription> pipelines) : pipelines_(std::move(pipelines)) {
  for (const gl::PipelineDescription& pipeline : pipelines_)
    for (const gl::ProgramDescription& program : pipeline)
      for (const gl::StageDescription& stage : program.stages)
        by_prolog_.emplace(gl::assemble_stage(program.shaders, {})->text, Stage{&program, &stage});
}

bool ListedSources::has(std::string_view text) const {
  const auto [first, last] = by_prolog_.equal_range(text.substr(0, text.find("#line")));
  for (auto at = first; at != last; ++at) {
    const auto source = gl::assemble_stage(at->second.first->shaders, at->second.second->files);
    if (source && source->text == text) return true;
  }
  return false;
}

int sources_looked_for() {
  return looked_for;
}

}  // namespace sightline::tests
