// OBJ files, and behind the separator the MTL files that they name.
#include "sightline/importers/obj/internal/obj_reader.h"
#include "sightline/tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  fuzz::check_reader(importers::read_obj, "fuzz.obj", fuzz::bytes_of(data, size),
                     {importers::kObjMemoryFactor, importers::kObjMemoryConstant});
  return 0;
}
