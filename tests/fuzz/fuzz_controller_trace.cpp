// Traces of the hybrid culler's controller as CSV; what was read is run, written and read again.
#include <cmath>

#include "sightline/apps/common/controller_trace.h"
#include "sightline/tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  const auto trace = apps::parse_controller_trace(fuzz::text_of(data, size), "fuzz.csv");
  if (!trace) {
    fuzz::require(trace.error().message.find("fuzz.csv:") == 0, "an error that names file and line");
    return 0;
  }
  for (const bool rendering : {false, true}) {
    const apps::TraceResult result = apps::run_controller(*trace, rendering);
    fuzz::require(result.choice.size() == trace->size(), "a choice for each frame");
    fuzz::require(result.oracle_ms <= result.chosen_ms, "no choice cheaper than the oracle's");
  }
  const auto again = apps::parse_controller_trace(apps::controller_trace_csv(*trace), "again.csv");
  fuzz::require(again.has_value(), again ? "" : again.error().message);
  fuzz::require(again->size() == trace->size(), "as many frames after writing and reading");
  return 0;
}
