// The calendar. Internal.
#pragma once

#include <ctime>

#include "sightline/core/api.h"

namespace sightline::core::platform {

/// False where the time is none of the calendar.
SIGHTLINE_API bool utc_of(std::time_t time, std::tm& utc);

}  // namespace sightline::core::platform
