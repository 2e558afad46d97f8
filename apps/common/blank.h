// Warns of images that show nothing although items are visible.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "sightline/engine/engine.h"

namespace sightline::apps {

/// Prints a one-line warning on stderr if `visible` items were found for the last frame but no pixel of the image
/// shows any. `image` names the image. Reads the image back.
inline void warn_if_blank(engine::Engine& engine, std::int64_t visible, const std::string& image) {
  if (visible > 0 && !engine.covered().value_or(true))
    std::fprintf(stderr, "warning: %s: no pixel shows any of the %lld visible items\n", image.c_str(),
                 (long long)visible);
}

}  // namespace sightline::apps
