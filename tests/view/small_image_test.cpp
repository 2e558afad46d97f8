#include "sightline/apps/view/small_image.h"

#include <random>

#include <gtest/gtest.h>

namespace sightline::apps::small_image_test {
namespace {

image::Image noise(int width, int height) {
  std::mt19937 random(7);
  image::Image image{width, height, {}};
  for (int i = 0; i < 3 * width * height; ++i) image.pixels.push_back(std::uint8_t(random() % 256));
  return image;
}

TEST(SmallImage, HasTheWidthAndTheShape) {
  for (const int width : {1, 3, 100, 256}) {
    const image::Image small = shrunk(noise(301, 200), width);
    EXPECT_EQ(small.width, width);
    EXPECT_EQ(small.height, std::max(1, 200 * width / 301));
    EXPECT_EQ(small.pixels.size(), std::size_t(3 * small.width * small.height));
  }
  EXPECT_EQ(shrunk(noise(300, 1), 30).height, 1);
  const image::Image image = noise(20, 30);
  EXPECT_EQ(shrunk(image, 20).pixels, image.pixels);
  EXPECT_EQ(shrunk(image, 21).width, 20);
}

TEST(SmallImage, IsOfMeans) {
  const image::Image image = noise(40, 24), small = shrunk(image, 10);
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 10; ++x)
      for (int c = 0; c < 3; ++c) {
        int sum = 0;
        for (int i = 0; i < 16; ++i) sum += image.pixels[std::size_t(3 * ((4 * y + i / 4) * 40 + 4 * x + i % 4) + c)];
        EXPECT_EQ(small.pixels[std::size_t(3 * (10 * y + x) + c)], sum / 16);
      }
  const image::Image one{50, 30, std::vector<std::uint8_t>(3 * 50 * 30, 77)};
  for (const std::uint8_t value : shrunk(one, 33).pixels) EXPECT_EQ(value, 77);
}

}  // namespace
}  // namespace sightline::apps::small_image_test
