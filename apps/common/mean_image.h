// The mean of images, for smooth edges.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <vector>

#include "sightline/render/image/image.h"

namespace sightline::apps {

class MeanImage {
 public:
  static constexpr int kMost = 0xffff / 255;  ///< images

  int count() const { return count_; }
  void clear() { count_ = 0; }
  /// All must have one size, from clear() on.
  void add(const image::Image& image) {
    if (count_ == 0) {
      width_ = image.width;
      height_ = image.height;
      sums_.assign(image.pixels.size(), 0);
    }
    assert(image.pixels.size() == sums_.size() && count_ < kMost);
    std::transform(sums_.begin(), sums_.end(), image.pixels.begin(), sums_.begin(),
                   [](std::uint16_t sum, std::uint8_t value) { return std::uint16_t(sum + value); });
    ++count_;
  }
  /// The mean of sRGB values, as multisampling has it. At least one image must have been added.
  image::Image mean() const {
    assert(count_ > 0);
    image::Image image{width_, height_, std::vector<std::uint8_t>(sums_.size())};
    std::transform(sums_.begin(), sums_.end(), image.pixels.begin(),
                   [this](std::uint16_t sum) { return std::uint8_t((sum + count_ / 2) / count_); });
    return image;
  }

 private:
  int count_ = 0, width_ = 0, height_ = 0;
  std::vector<std::uint16_t> sums_;
};

}  // namespace sightline::apps
