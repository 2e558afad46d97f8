#include "sightline/apps/view/small_image.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace sightline::apps {
namespace {

/// First and beyond the last of the pixels, of `from`, that become pixel `i` of `to`.
std::array<int, 2> pixels_of(int i, int from, int to) {
  const auto edge = [&](int at) { return int(std::int64_t(at) * from / to); };
  return {edge(i), std::max(edge(i) + 1, edge(i + 1))};
}

std::uint8_t mean(const image::Image& image, const std::array<int, 2>& across, const std::array<int, 2>& down,
                  int channel) {
  int sum = 0;
  for (int y = down[0]; y < down[1]; ++y)
    for (int x = across[0]; x < across[1]; ++x)
      sum += image.pixels[3 * (std::size_t(y) * std::size_t(image.width) + std::size_t(x)) + std::size_t(channel)];
  return std::uint8_t(sum / ((across[1] - across[0]) * (down[1] - down[0])));
}

}  // namespace

image::Image shrunk(const image::Image& image, int width) {
  if (image.width <= width) return image;
  const int height = std::max(1, int(std::int64_t(image.height) * width / image.width));
  image::Image small{width, height, {}};
  small.pixels.reserve(3 * std::size_t(width) * std::size_t(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int channel = 0; channel < 3; ++channel)
        small.pixels.push_back(
            mean(image, pixels_of(x, image.width, width), pixels_of(y, image.height, height), channel));
  return small;
}

}  // namespace sightline::apps
