// The clock that frames and measurements are timed with. Internal.
#pragma once

#include "sightline/core/api.h"

namespace sightline::core {

/// Seconds on the steady clock, or on that of use_clock().
SIGHTLINE_API double now_seconds();

/// Replaces the clock in the whole process; null: the steady clock again. For tests that simulate a device: whatever
/// the library decides by measured times is then decided by theirs.
SIGHTLINE_API void use_clock(double (*seconds)());

}  // namespace sightline::core
