// STL files.
#include "sightline/importers/stl/internal/stl_reader.h"
#include "sightline/tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  fuzz::check_reader(importers::read_stl, "fuzz.stl", fuzz::bytes_of(data, size),
                     {importers::kStlMemoryFactor, importers::kStlMemoryConstant});
  return 0;
}
