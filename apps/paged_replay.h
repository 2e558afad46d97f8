// sightline-replay --memory: flies through a scene that is drawn page by page.
#pragma once

#include <string>

#include "sightline/apps/common/model.h"

namespace sightline::apps {

struct PagedReplayOptions {
  ModelOptions model;
  std::string memory, path, save_path, size, json_file, images;
  int frames = 300, every = 30;
  double lod_error = 0.0;  ///< pixels
  double budget_ms = 0.0;
  bool settle = false;  ///< each frame waits until its image is complete
  gl::ContextPlatform platform = {};
};

/// Prints a table, writes figures and images, and says how much memory the process has had.
core::Expected<int> replay_paged(const PagedReplayOptions& options);

}  // namespace sightline::apps
