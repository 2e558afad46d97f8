#include "sightline/tests/shaders/library_programs.h"
#include "sightline/tests/shaders/listed_sources.h"

namespace sightline::tests {

std::vector<gl::PipelineDescription> listed_programs() {
  return library_programs();
}

}  // namespace sightline::tests
