// Calls of the C API in any order, with any handles and numbers (tests/bindings/c/random_calls.h).
#include "sightline/tests/bindings/c/random_calls.h"
#include "sightline/tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string wrong = sightline::tests::make_random_calls(data, size);
  sightline::fuzz::require(wrong.empty(), wrong);
  return 0;
}
