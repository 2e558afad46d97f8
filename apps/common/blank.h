// Pictures that show nothing although there is something to see.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "sightline/engine/drawing.h"

namespace sightline::apps {

/// Says so, in one line on stderr, when `visible` items were found for the last frame and no pixel of the target, as
/// depth tells, shows any. `picture` names it. Reads the target back.
inline void warn_if_blank(const engine::Drawing& drawing, std::int64_t visible, const std::string& picture) {
  if (visible > 0 && !drawing.target().covered())
    std::fprintf(stderr, "warning: %s: no pixel shows any of the %lld visible items\n", picture.c_str(),
                 (long long)visible);
}

}  // namespace sightline::apps
