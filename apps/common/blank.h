// Warns of images that show nothing.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "sightline/engine/engine.h"

namespace sightline::apps {

/// Prints a one-line warning on stderr if no pixel of the last frame's image shows any item. `visible`: items that were
/// found for it. `image` names the image. Reads the image back.
inline void warn_if_blank(engine::Engine& engine, std::int64_t visible, const std::string& image) {
  if (engine.covered().value_or(true)) return;
  if (visible > 0)
    std::fprintf(stderr, "warning: %s: no pixel shows any of the %lld visible items\n", image.c_str(),
                 (long long)visible);
  else
    std::fprintf(stderr, "warning: %s shows nothing: no item lies in the view\n", image.c_str());
}

}  // namespace sightline::apps
