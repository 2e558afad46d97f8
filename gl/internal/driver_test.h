// The self-test of a driver.
#pragma once

#include <vector>

#include "sightline/gl/context.h"
#include "sightline/gl/functions.h"
#include "sightline/gl/internal/program.h"

namespace sightline::gl {

/// Draws and computes what the checks need and reads it back; waits for the GPU. A check that cannot be made, such as
/// without memory, is kNotRun. The context must be current; its state is changed, and no error is left pending.
DriverTest run_driver_test(const Functions& gl, const Capabilities& has);

/// All programs that it asks for.
std::vector<PipelineDescription> driver_test_programs();

}  // namespace sightline::gl
