// Images of what has changed: a group of equal changes in the colour of its change, and all else as a faint shell.
// Drawn by rays, so that no graphics driver is needed.
#pragma once

#include <functional>
#include <vector>

#include "sightline/apps/compare/reports.h"

namespace sightline::apps {

/// Images of the largest groups: at most kMostImages. Both scenes, which are those of the
/// comparison, must be committed. Some 30 ms each for 100,000 items. Fails in builds without ray tracing.
core::Expected<std::vector<GroupImage>> group_images(const Compared& compared, core::Scene& before, core::Scene& after,
                                                     const std::function<void(double)>& progress = {});

}  // namespace sightline::apps
