#include "sightline/apps/view/resting_image.h"

#include "sightline/apps/common/tiled_image.h"

namespace sightline::apps {

static_assert(RestingImage::kSamples <= MeanImage::kMost);

const std::vector<core::dvec2>& RestingImage::shifts() {
  static const std::vector<core::dvec2> made = sample_shifts(kSamples);
  return made;
}

}  // namespace sightline::apps
