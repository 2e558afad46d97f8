// PNG and PFM files, id colours and image comparison.
#include "sightline/render/image/image.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>

#include <gtest/gtest.h>

namespace sightline::image::image_test {
namespace {

std::string temporary(const std::string& name) {
  return testing::TempDir() + "sightline_image_" + name;
}

Image gradient(int width, int height) {
  Image image{width, height, {}};
  for (int i = 0; i < width * height * 3; ++i) image.pixels.push_back(std::uint8_t((i * 37) & 255));
  return image;
}

TEST(Image, PngComesBackBitForBit) {
  const Image image = gradient(37, 21);
  const std::string file = temporary("roundtrip.png");
  ASSERT_TRUE(write_png(image, file));
  const auto back = read_png(file);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->width, 37);
  EXPECT_EQ(back->height, 21);
  EXPECT_EQ(back->pixels, image.pixels);
}

TEST(Image, SmallPngsHoldTheSameImage) {
  const Image image = gradient(200, 100);
  const auto fast = encode_png(image), small = encode_png(image, PngSize::kSmall);
  ASSERT_TRUE(fast && small);
  EXPECT_LT(small->size(), fast->size());
  const std::string file = temporary("small.png");
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(small->data()), std::streamsize(small->size()));
  const auto back = read_png(file);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->pixels, image.pixels);
}

/// Any bytes are safe, also those that claim to be a large image.
TEST(Image, BytesAreDecodedUnlessTheyAreDamaged) {
  const Image image = gradient(200, 100);
  const std::vector<std::uint8_t> png = encode_png(image).value();
  const auto back = decode_png(png);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->width, 200);
  EXPECT_EQ(back->pixels, image.pixels);
  for (const std::size_t length : {0, 7, 8, 20, 40, 100})
    EXPECT_FALSE(decode_png(std::span(png).first(length))) << length;
  EXPECT_FALSE(decode_png(std::span(png).first(png.size() / 2)));
  std::vector<std::uint8_t> huge =
      encode_png({1 << 14, (1 << 12) + 1, std::vector<std::uint8_t>(3 * 16384 * 4097)}).value();
  EXPECT_EQ(decode_png(huge).error().message, "PNG: more pixels than are read");
}

std::string bytes_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(PngWriter, RowsMakeTheSameImage) {
  const Image image = gradient(37, 21);
  const std::string file = temporary("rows.png");
  for (const int rows : {1, 2, 5, 21}) {
    SCOPED_TRACE(rows);
    auto writer = PngWriter::create(file, image.width, image.height);
    ASSERT_TRUE(writer) << writer.error().message;
    for (int y = 0; y < image.height; y += rows) {
      const std::size_t row = std::size_t(3 * image.width), count = std::size_t(std::min(rows, image.height - y));
      ASSERT_TRUE(writer->write_rows(std::span(image.pixels).subspan(std::size_t(y) * row, count * row)));
    }
    ASSERT_TRUE(writer->finish());
    const auto back = read_png(file);
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->pixels, image.pixels);
  }
}

TEST(PngWriter, AFileThatIsNotFinishedStaysAsItWas) {
  const Image image = gradient(8, 4);
  const std::string file = temporary("unfinished.png");
  ASSERT_TRUE(write_png(image, file));
  const std::string before = bytes_of(file);
  {
    auto writer = PngWriter::create(file, 8, 400);
    ASSERT_TRUE(writer && writer->write_rows(image.pixels));
  }
  EXPECT_EQ(bytes_of(file), before);
  auto early = PngWriter::create(file, 8, 5);
  ASSERT_TRUE(early && early->write_rows(image.pixels));
  const auto missing = early->finish();
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().message, file + ": PNG: 1 rows are missing");
  EXPECT_EQ(bytes_of(file), before);
}

TEST(PngWriter, RefusesWhatCannotBeWritten) {
  const Image image = gradient(8, 4);
  EXPECT_FALSE(PngWriter::create("/nonexistent/image.png", 8, 4));
  for (const auto& [width, height] : {std::pair(0, 4), {4, 0}, {-1, 4}, {2'000'000'000, 1}}) {
    const auto writer = PngWriter::create(temporary("size.png"), width, height);
    ASSERT_FALSE(writer) << width << "x" << height;
    EXPECT_NE(writer.error().message.find("size.png: "), std::string::npos) << writer.error().message;
  }
  auto writer = PngWriter::create(temporary("many.png"), 8, 3);
  ASSERT_TRUE(writer);
  EXPECT_FALSE(writer->write_rows(image.pixels)) << "a row too many";
  auto halves = PngWriter::create(temporary("halves.png"), 8, 3);
  ASSERT_TRUE(halves);
  EXPECT_FALSE(halves->write_rows(std::span(image.pixels).first(25))) << "no whole rows";
  auto full = PngWriter::create("/dev/full", 800, 400);
  ASSERT_TRUE(full) << full.error().message;
  const Image large = gradient(800, 400);
  core::Expected<void> done = full->write_rows(large.pixels);
  if (done) done = full->finish();
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("/dev/full"), std::string::npos) << done.error().message;
}

TEST(Image, ErrorsNameTheFile) {
  const auto missing = read_png("/nonexistent/image.png");
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("/nonexistent/image.png"), std::string::npos);
  const auto unwritable = write_png(gradient(2, 2), "/nonexistent/image.png");
  ASSERT_FALSE(unwritable);
  EXPECT_NE(unwritable.error().message.find("/nonexistent/image.png"), std::string::npos);
  const std::string file = temporary("broken.png");
  std::ofstream(file) << "no image";
  EXPECT_FALSE(read_png(file));
}

TEST(Image, PfmRowsRunBottomToTop) {
  const float inf = std::numeric_limits<float>::infinity();
  const DepthImage depth{2, 2, {1.0f, 2.0f, 3.0f, inf}};
  const std::string file = temporary("depth.pfm");
  ASSERT_TRUE(write_pfm(depth, file));
  std::ifstream in(file, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  const std::string header = "Pf\n2 2\n-1.0\n";
  ASSERT_EQ(bytes.size(), header.size() + 16);
  EXPECT_EQ(bytes.substr(0, header.size()), header);
  float values[4];
  std::memcpy(values, bytes.data() + header.size(), 16);
  EXPECT_EQ(values[0], 3.0f);
  EXPECT_EQ(values[1], inf);
  EXPECT_EQ(values[2], 1.0f);
  EXPECT_EQ(values[3], 2.0f);
}

TEST(Image, PfmReadsWhatItWrote) {
  const float inf = std::numeric_limits<float>::infinity();
  const DepthImage depth{3, 2, {1.0f, 2.0f, 3.0f, 4.0f, inf, 0.5f}};
  const std::string file = temporary("depth.pfm");
  ASSERT_TRUE(write_pfm(depth, file));
  const auto read = read_pfm(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->width, 3);
  EXPECT_EQ(read->height, 2);
  EXPECT_EQ(read->metres, depth.metres);
}

TEST(Image, PfmThatIsNoneIsAnError) {
  const std::string file = temporary("broken.pfm"), four(4, 'x');
  for (const std::string& bytes :
       {std::string(), std::string("no image"), "Pf\n1 1\n-1.0\n" + four + four, std::string("Pf\n1 1\n-1.0\nxxx"),
        "PF\n1 1\n-1.0\n" + four + four + four, "Pf\n1 1\n1.0\n" + four, "Pf\n0 1\n-1.0\n" + four,
        "Pf\n-1 -1\n-1.0\n" + four, "Pf\n60000 60000\n-1.0\n" + four, std::string("Pf\n1 1")}) {
    SCOPED_TRACE(bytes);
    std::ofstream(file, std::ios::binary) << bytes;
    const auto read = read_pfm(file);
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().message.find("broken.pfm"), std::string::npos) << read.error().message;
  }
  EXPECT_FALSE(read_pfm("/nonexistent/depth.pfm"));
}

TEST(Image, IdsAreColoursLowByteFirst) {
  const auto image = id_colours({2, 1, {0, 0x00030201u}});
  ASSERT_TRUE(image);
  EXPECT_EQ(image->pixels, (std::vector<std::uint8_t>{0, 0, 0, 1, 2, 3}));
  EXPECT_EQ(ids_of_colours(*image).ids, (std::vector<std::uint32_t>{0, 0x00030201u}));
  EXPECT_FALSE(id_colours({1, 1, {0x01000000u}}));
}

TEST(Image, ComparisonCountsWhatDiffers) {
  const Image a = gradient(8, 4);
  Image b = a;
  b.pixels[5] = std::uint8_t(b.pixels[5] + 12);
  const auto difference = compare(a, b);
  ASSERT_TRUE(difference);
  EXPECT_EQ(difference->max, 12);
  EXPECT_DOUBLE_EQ(difference->mean, 12.0 / 96.0);
  EXPECT_EQ(difference->pixels, 1u);
  EXPECT_EQ(difference_image(a, b).pixels[5], 48);
  EXPECT_FALSE(compare(a, gradient(4, 8)));
}

}  // namespace
}  // namespace sightline::image::image_test
