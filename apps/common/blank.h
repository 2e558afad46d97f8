// Warns of images that show nothing.
#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>

#include "sightline/engine/engine.h"

namespace sightline::apps {

/// Prints a one-line warning on stderr that an image is blank. `visible`: items that were found for it; empty: some.
inline void warn_of_blank(std::optional<std::int64_t> visible, const std::string& image) {
  if (visible && *visible <= 0) {
    std::fprintf(stderr, "warning: %s shows nothing: no item lies in the view\n", image.c_str());
    return;
  }
  const std::string count = visible ? std::to_string(*visible) + " " : "";
  std::fprintf(stderr, "warning: %s: no pixel shows any of the %svisible items\n", image.c_str(), count.c_str());
}

/// Warns if no pixel of the last frame's image shows any item. `visible`: items that were
/// found for it. `image` names the image. Reads the image back.
inline void warn_if_blank(engine::Engine& engine, std::int64_t visible, const std::string& image) {
  if (!engine.covered().value_or(true)) warn_of_blank(visible, image);
}

}  // namespace sightline::apps
