// Smooth edges at rest: the mean of images that are shifted by parts of a pixel.
#pragma once

#include <vector>

#include "sightline/apps/common/mean_image.h"
#include "sightline/core/conventions.h"

namespace sightline::apps {

class RestingImage {
 public:
  static constexpr int kSamples = 8;
  /// Pixels by which the images are shifted, right and up; between -0.5 and 0.5.
  static const std::vector<core::dvec2>& shifts();

  int count() const { return sum_.count(); }
  bool complete() const { return count() == kSamples; }
  void clear() { sum_.clear(); }
  /// The shift of the next image.
  core::dvec2 shift() const { return shifts()[std::size_t(count() % kSamples)]; }
  /// All must have one size, from clear() on.
  void add(const image::Image& image) { sum_.add(image); }
  /// At least one image must have been added.
  image::Image mean() const { return sum_.mean(); }

 private:
  MeanImage sum_;
};

}  // namespace sightline::apps
