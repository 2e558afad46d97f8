// engine/image_tiles.h: tiles that cover an image, each pixel once.
#include "sightline/engine/image_tiles.h"

#include <random>

#include <gtest/gtest.h>

namespace sightline::engine::image_tiles_test {
namespace {

constexpr unsigned kSeed = 20261123;

/// All that the header promises, of tiles for that image.
void check(int width, int height, int largest, int more_margin) {
  SCOPED_TRACE(testing::Message() << width << "x" << height << " by " << largest << ", margin + " << more_margin);
  const auto made = image_tiles(width, height, largest, more_margin);
  ASSERT_TRUE(made) << made.error().message;
  ASSERT_LE(std::max(made->width, made->height), largest);
  const int margin = kTileMargin + more_margin;
  std::vector<int> covered(std::size_t(width) * std::size_t(height), 0);
  for (const CroppedTile& tile : made->tiles) {
    const int x = int(tile.tile.x), y = int(tile.tile.y), right = x + made->width, bottom = y + made->height;
    ASSERT_EQ(tile.tile.width, width);
    ASSERT_EQ(tile.tile.height, height);
    ASSERT_TRUE(x >= 0 && y >= 0 && right <= width && bottom <= height) << x << " " << y;
    ASSERT_EQ(x % 4, 0);
    ASSERT_EQ((height - bottom) % 4, 0);
    ASSERT_TRUE(tile.x0 == 0 || tile.x0 - x >= margin);
    ASSERT_TRUE(tile.y0 == 0 || tile.y0 - y >= margin);
    ASSERT_TRUE(tile.x1 == width || right - tile.x1 >= margin);
    ASSERT_TRUE(tile.y1 == height || bottom - tile.y1 >= margin);
    ASSERT_TRUE(tile.x0 < tile.x1 && tile.y0 < tile.y1);
    for (int at = tile.y0; at < tile.y1; ++at)
      for (int column = tile.x0; column < tile.x1; ++column)
        ++covered[std::size_t(at) * std::size_t(width) + std::size_t(column)];
  }
  EXPECT_EQ(std::count(covered.begin(), covered.end(), 1), std::int64_t(covered.size()));
  for (std::size_t i = 1; i < made->tiles.size(); ++i) {
    const CroppedTile &before = made->tiles[i - 1], &tile = made->tiles[i];
    if (tile.x0 == 0)
      ASSERT_EQ(tile.y0, before.y1);
    else
      ASSERT_TRUE(tile.x0 == before.x1 && tile.y0 == before.y0 && tile.y1 == before.y1);
  }
}

TEST(ImageTiles, CoverAnyImageOnce) {
  std::mt19937 random(kSeed);
  const auto between = [&](int low, int high) { return std::uniform_int_distribution(low, high)(random); };
  for (int i = 0; i < 400 && !testing::Test::HasFailure(); ++i) {
    const int more = between(0, 3) == 0 ? between(1, 40) : 0;
    const int least = kLeastTileSide + 2 * ((kTileMargin + more + 3) / 4 * 4);
    check(between(1, 900), between(1, 900), between(least, least + 300), more);
  }
}

TEST(ImageTiles, AroundEdgeCases) {
  for (int length = 76; length < 180 && !testing::Test::HasFailure(); ++length) check(length, 300 - length, 80, 0);
}

TEST(ImageTiles, OneTileWhereTheImageIsSmall) {
  const auto made = image_tiles(640, 360, 640);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->tiles.size(), 1u);
  EXPECT_EQ(made->width, 640);
  EXPECT_EQ(made->height, 360);
}

TEST(ImageTiles, LittleIsDrawnTwice) {
  const auto made = image_tiles(16384, 16384, 2048);
  ASSERT_TRUE(made);
  const double drawn = double(made->width) * made->height * double(made->tiles.size());
  EXPECT_LT(drawn, 1.05 * 16384.0 * 16384.0);
}

TEST(ImageTiles, RefuseWhatMakesNoSense) {
  EXPECT_FALSE(image_tiles(0, 10, 100));
  EXPECT_FALSE(image_tiles(10, 0, 100));
  EXPECT_FALSE(image_tiles(10, -5, 100));
  EXPECT_FALSE(image_tiles(10, 10, 100, -1));
  EXPECT_FALSE(image_tiles(1000, 1000, 79));
  EXPECT_TRUE(image_tiles(1000, 1000, 80));
  EXPECT_FALSE(image_tiles(1000, 1000, 80, 1)) << "no room between the margins";
}

}  // namespace
}  // namespace sightline::engine::image_tiles_test
