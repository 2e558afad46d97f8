#include "sightline/apps/view/resting_image.h"

#include "sightline/raytrace/exact_visibility.h"

namespace sightline::apps {

static_assert(RestingImage::kSamples <= MeanImage::kMost);

const std::vector<core::dvec2>& RestingImage::shifts() {
  static const std::vector<core::dvec2> made = [] {
    std::vector<core::dvec2> places = raytrace::sample_positions(kSamples);
    for (core::dvec2& place : places) place -= 0.5;
    return places;
  }();
  return made;
}

}  // namespace sightline::apps
