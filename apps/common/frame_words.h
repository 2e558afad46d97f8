// Words for what a frame reports.
#pragma once

#include <string_view>

#include "sightline/engine/engine.h"

namespace sightline::apps {

/// The state of the hybrid's controller in a frame; "fixed" without a hybrid.
inline std::string_view state_name(const engine::FrameReport& report) {
  return report.state ? name_of(*report.state) : "fixed";
}

}  // namespace sightline::apps
