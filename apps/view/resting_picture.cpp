#include "sightline/apps/view/resting_picture.h"

#include <algorithm>
#include <cassert>

#include "sightline/raytrace/exact_visibility.h"

namespace sightline::apps {

static_assert(RestingPicture::kSamples * 255 <= 0xffff);

core::dvec2 RestingPicture::shift() const {
  static const std::vector<core::dvec2> places = raytrace::sample_positions(kSamples);
  return places[std::size_t(count_ % kSamples)] - 0.5;
}

void RestingPicture::add(const image::Image& picture) {
  if (count_ == 0) {
    width_ = picture.width;
    height_ = picture.height;
    sums_.assign(picture.pixels.size(), 0);
  }
  assert(picture.pixels.size() == sums_.size());
  std::transform(sums_.begin(), sums_.end(), picture.pixels.begin(), sums_.begin(),
                 [](std::uint16_t sum, std::uint8_t value) { return std::uint16_t(sum + value); });
  ++count_;
}

image::Image RestingPicture::mean() const {
  assert(count_ > 0);
  image::Image picture{width_, height_, std::vector<std::uint8_t>(sums_.size())};
  std::transform(sums_.begin(), sums_.end(), picture.pixels.begin(),
                 [this](std::uint16_t sum) { return std::uint8_t((sum + count_ / 2) / count_); });
  return picture;
}

}  // namespace sightline::apps
