// Primitives recognised in meshes: solids, whole and damaged, and raw triangles (tests/importers/random_recognition.h).
#include "sightline/importers/recognise/internal/recognise.h"
#include "sightline/tests/fuzz/allocated_memory.h"
#include "sightline/tests/fuzz/fuzz_target.h"
#include "sightline/tests/importers/random_recognition.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  const tests::RecognitionInput input = tests::recognition_input(data, size);
  {
    const fuzz::PeakMemory peak;
    (void)importers::recognise(input.mesh, input.tolerance);
    const std::size_t used = peak.bytes();
    const std::size_t triangles = std::max(input.mesh.indices.size(), input.mesh.positions.size()) / 3;
    fuzz::require(used <= (1u << 16) + 600 * triangles, "memory within the bound, found " + std::to_string(used) +
                                                            " bytes for " + std::to_string(triangles) + " triangles");
  }
  for (const std::string& wrong : {tests::check_mesh(input), tests::check_items(input)})
    fuzz::require(wrong.empty(), wrong);
  return 0;
}
