// Small images of large ones, for lists.
#pragma once

#include "sightline/render/image/image.h"

namespace sightline::apps {

/// As wide as that, of means of pixels; an image that is no wider stays as it is.
image::Image shrunk(const image::Image& image, int width);

}  // namespace sightline::apps
