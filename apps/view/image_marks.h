// Mark-ups, measurements and the colours' legend for images that are written: larger or smaller than the window's.
#pragma once

#include "sightline/apps/view/painting.h"
#include "sightline/apps/view/workspace.h"

namespace sightline::apps {

/// What is painted over images of the model as it is marked now; empty, so that it costs nothing, where that is
/// nothing. Text and lines are as large in proportion to the image's height as in the window, but not too small to be
/// read. While a model is open.
Painter image_marks(const Workspace& work);

}  // namespace sightline::apps
