// Images on HTML pages, in builds that have images.
#pragma once

#include <string>

#include "sightline/apps/common/html_page.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {

struct LabelledImage {
  std::string label;
  image::Image image;
};

}  // namespace sightline::apps
