#include "sightline/tests/shaders/library_programs.h"
#include "sightline/tests/shaders/listed_sources.h"

namespace sightline::tests {

std::vector<gl::PipelineDescription> listed_programs() {
  const std::vector<gl::PipelineDescription> plain = library_programs();
  std::vector<gl::PipelineDescription> all = plain;
  for (const auto& on : {std::vector{gl::Workaround::kPlainDepth}, std::vector{gl::Workaround::kAddBaseVertex},
                         std::vector{gl::Workaround::kPlainDepth, gl::Workaround::kAddBaseVertex}}) {
    gl::Workarounds workarounds;
    for (const gl::Workaround one : on) workarounds.set(one, true);
    for (const gl::PipelineDescription& pipeline : plain) all.push_back(worked_around(pipeline, workarounds));
  }
  return all;
}

}  // namespace sightline::tests
