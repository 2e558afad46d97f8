// Pictures that show nothing although there is something to see.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "sightline/engine/engine.h"

namespace sightline::apps {

/// Says so, in one line on stderr, when `visible` items were found for the last frame and no pixel of the picture shows
/// any. `picture` names it. Reads the picture back.
inline void warn_if_blank(engine::Engine& engine, std::int64_t visible, const std::string& picture) {
  if (visible > 0 && !engine.covered().value_or(true))
    std::fprintf(stderr, "warning: %s: no pixel shows any of the %lld visible items\n", picture.c_str(),
                 (long long)visible);
}

}  // namespace sightline::apps
