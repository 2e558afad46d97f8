#include "sightline/apps/view/resting_picture.h"

#include "sightline/raytrace/exact_visibility.h"

namespace sightline::apps {

static_assert(RestingPicture::kSamples <= MeanPicture::kMost);

const std::vector<core::dvec2>& RestingPicture::shifts() {
  static const std::vector<core::dvec2> made = [] {
    std::vector<core::dvec2> places = raytrace::sample_positions(kSamples);
    for (core::dvec2& place : places) place -= 0.5;
    return places;
  }();
  return made;
}

}  // namespace sightline::apps
