// Smooth edges at rest: the mean of pictures that are shifted by parts of a pixel.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/core/conventions.h"
#include "sightline/image/image.h"

namespace sightline::apps {

class RestingPicture {
 public:
  static constexpr int kSamples = 8;

  int count() const { return count_; }
  bool complete() const { return count_ == kSamples; }
  void clear() { count_ = 0; }
  /// Pixels by which the next picture should be shifted, right and up; between -0.5 and 0.5.
  core::dvec2 shift() const;
  /// All must have one size, from clear() on.
  void add(const image::Image& picture);
  /// Of sRGB values, as multisampling has it. At least one picture must have been added.
  image::Image mean() const;

 private:
  int count_ = 0, width_ = 0, height_ = 0;
  std::vector<std::uint16_t> sums_;
};

}  // namespace sightline::apps
