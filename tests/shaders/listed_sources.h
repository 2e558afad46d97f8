// A test program that links listed_sources.cpp fails every GlTest that compiles a text which listed_programs() does not
// have: so the list, which glslang compiles without a driver, has all that drivers are asked for. Programs that come
// from a ProgramCache are not compiled; they were looked for when they were.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/gl/internal/program.h"

namespace sightline::tests {

/// The list that texts are compared with. The test program defines it.
std::vector<gl::PipelineDescription> listed_programs();

/// In the text of a test's own shader: it is in no list.
inline constexpr std::string_view kTestShader = "// A test's own shader.\n";

/// The texts of a list's stages. A text is only assembled once another is looked for that begins alike.
class ListedSources {
 public:
  explicit ListedSources(std::vector<gl::PipelineDescription> pipelines);
  bool has(std::string_view text) const;

 private:
  using Stage = std::pair<const gl::ProgramDescription*, const gl::StageDescription*>;
  std::vector<gl::PipelineDescription> pipelines_;
  std::multimap<std::string, Stage, std::less<>> by_prolog_;
};

/// Number of texts that tests of this process have compiled and that were looked for.
int sources_looked_for();

}  // namespace sightline::tests
