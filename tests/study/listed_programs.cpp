#include "sightline/tests/shaders/library_programs.h"
#include "sightline/tests/shaders/listed_sources.h"
#include "sightline/tests/study/study_programs.h"

namespace sightline::tests {

std::vector<gl::PipelineDescription> listed_programs() {
  std::vector<gl::PipelineDescription> all = library_programs();
  for (gl::PipelineDescription& pipeline : study_programs()) all.push_back(std::move(pipeline));
  return all;
}

}  // namespace sightline::tests
