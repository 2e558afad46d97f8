// PLY files.
#include "sightline/importers/ply/internal/ply_reader.h"
#include "sightline/tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  fuzz::check_reader(importers::read_ply, "fuzz.ply", fuzz::bytes_of(data, size),
                     {importers::kPlyMemoryFactor, importers::kPlyMemoryConstant});
  return 0;
}
