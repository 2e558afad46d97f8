// Triangles painted over images.
#include "sightline/apps/view/painting.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace sightline::apps::painting_test {
namespace {

constexpr std::uint8_t kOpaque[] = {255}, kHalves[] = {0, 255};
constexpr int kWidth = 12, kHeight = 10;

image::Image grey() {
  return {kWidth, kHeight, std::vector<std::uint8_t>(3 * kWidth * kHeight, 100)};
}

/// A rectangle of two triangles.
Painting rectangle(float left, float top, float right, float bottom, std::uint8_t alpha) {
  Painting painting;
  for (const auto& [x, y] : {std::pair(left, top), {right, top}, {right, bottom}, {left, bottom}})
    painting.vertices.push_back({x, y, x > left ? 1.0f : 0.0f, y > top ? 1.0f : 0.0f, {200, 100, 0, alpha}});
  painting.indices = {0, 1, 2, 0, 2, 3};
  painting.batches = {{0, 6, 0.0f, 0.0f, float(kWidth), float(kHeight), {kOpaque, 1, 1}}};
  return painting;
}

int red(const image::Image& image, int x, int y) {
  return image.pixels[3 * std::size_t(y * kWidth + x)];
}

int painted(const image::Image& image) {
  int count = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) count += red(image, x, y) != 100;
  return count;
}

TEST(Painting, PaintsPixelsWhoseMiddlesAreInside) {
  image::Image image = grey();
  rectangle(2.0f, 3.0f, 7.0f, 5.0f, 255).paint(image);
  EXPECT_EQ(painted(image), 10);
  for (const auto& [x, y] : {std::pair(2, 3), {6, 3}, {2, 4}, {6, 4}}) EXPECT_EQ(red(image, x, y), 200);
  EXPECT_EQ(image.pixels[3 * (3 * kWidth + 2) + 2], 0) << "blue";
}

/// On the diagonal both triangles meet.
TEST(Painting, NoPixelIsPaintedTwice) {
  image::Image image = grey();
  rectangle(0.3f, 0.2f, 11.4f, 9.9f, 128).paint(image);
  for (std::size_t i = 0; i < image.pixels.size(); i += 3)
    EXPECT_TRUE(image.pixels[i] == 100 || image.pixels[i] == 150) << int(image.pixels[i]);
  EXPECT_EQ(painted(image), 11 * 10);
}

TEST(Painting, RowsMakeTheSameImage) {
  image::Image whole = grey(), parts = grey();
  const Painting painting = rectangle(1.2f, 0.7f, 10.6f, 9.1f, 90);
  painting.paint(whole);
  for (int first = 0; first < kHeight; first += 4)
    painting.paint(
        std::span(parts.pixels)
            .subspan(3 * std::size_t(first * kWidth), 3 * std::size_t(std::min(4, kHeight - first) * kWidth)),
        kWidth, first);
  EXPECT_EQ(parts.pixels, whole.pixels);
}

TEST(Painting, IsClippedAndMayLieOutside) {
  image::Image image = grey();
  Painting painting = rectangle(-50.0f, -50.0f, 500.0f, 500.0f, 255);
  painting.batches[0].right = 3.0f;
  painting.batches[0].top = 8.0f;
  painting.paint(image);
  EXPECT_EQ(painted(image), 3 * 2);
  image = grey();
  rectangle(-50.0f, 1.0f, -2.0f, 500.0f, 255).paint(image);
  rectangle(3.0f, 4.0f, 3.0f, 9.0f, 255).paint(image);
  EXPECT_EQ(painted(image), 0);
}

TEST(Painting, TexturesFade) {
  image::Image image = grey();
  Painting painting = rectangle(0.0f, 0.0f, 8.0f, 1.0f, 255);
  painting.batches[0].texture = {kHalves, 2, 1};
  painting.paint(image);
  EXPECT_EQ(red(image, 0, 0), 100);
  EXPECT_EQ(red(image, 7, 0), 200);
  for (int x = 1; x < 8; ++x) EXPECT_GE(red(image, x, 0), red(image, x - 1, 0)) << x;
  EXPECT_GT(red(image, 4, 0), 120);
  EXPECT_LT(red(image, 4, 0), 180);
}

}  // namespace
}  // namespace sightline::apps::painting_test
