// PSNR, SSIM and FLIP: values known by hand, and FLIP against a twin that follows the paper's two-dimensional sums.
#include "sightline/render/image/image_metrics.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace sightline::image::image_metrics_test {
namespace {

Image uniform(int width, int height, std::uint8_t r, std::uint8_t g, std::uint8_t b) {
  Image image{width, height, {}};
  for (int i = 0; i < width * height; ++i) image.pixels.insert(image.pixels.end(), {r, g, b});
  return image;
}

Image noise(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Image image{width, height, {}};
  for (int i = 0; i < 3 * width * height; ++i) image.pixels.push_back(std::uint8_t(random() >> 24));
  return image;
}

/// Something like a drawing: discs of one colour before another.
Image discs(int width, int height, double shift) {
  Image image{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double cell = std::hypot(std::fmod(x + shift, 24.0) - 12.0, std::fmod(double(y), 24.0) - 12.0);
      const bool in = cell < 8.0;
      image.pixels.insert(image.pixels.end(), {std::uint8_t(in ? 200 : 40), std::uint8_t(in ? 90 : 60 + x % 64),
                                               std::uint8_t(in ? 30 : 90)});
    }
  return image;
}

// --- FLIP as the paper writes it: two-dimensional kernels, one pixel at a time ---------------------------------------

struct Colour {
  double x = 0.0, y = 0.0, z = 0.0;
};

Colour xyz(const Colour& c) {
  return {0.41238656 * c.x + 0.35759149 * c.y + 0.18045049 * c.z,
          0.21263682 * c.x + 0.71518298 * c.y + 0.07218020 * c.z,
          0.01933062 * c.x + 0.11919716 * c.y + 0.95037259 * c.z};
}

Colour rgb(const Colour& c) {  // Cramer's rule, column by column
  const Colour r = xyz({1, 0, 0}), g = xyz({0, 1, 0}), b = xyz({0, 0, 1});
  const auto det = [](const Colour& p, const Colour& q, const Colour& s) {
    return p.x * (q.y * s.z - q.z * s.y) - p.y * (q.x * s.z - q.z * s.x) + p.z * (q.x * s.y - q.y * s.x);
  };
  const double d = det(r, g, b);
  return {det(c, g, b) / d, det(r, c, b) / d, det(r, g, c) / d};
}

Colour linear_at(const Image& image, int x, int y) {
  x = std::min(std::max(x, 0), image.width - 1);
  y = std::min(std::max(y, 0), image.height - 1);
  const auto decode = [&](int channel) {
    const double v = image.pixels[std::size_t(3 * (y * image.width + x) + channel)] / 255.0;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  };
  return {decode(0), decode(1), decode(2)};
}

Colour ycxcz(const Colour& linear) {
  const Colour w = xyz({1, 1, 1}), c = xyz(linear);
  return {116.0 * c.y / w.y - 16.0, 500.0 * (c.x / w.x - c.y / w.y), 200.0 * (c.y / w.y - c.z / w.z)};
}

Colour filtered(const Image& image, int px, int py, double ppd) {
  const int radius = int(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * std::numbers::pi * std::numbers::pi)) * ppd));
  double sums[3] = {0, 0, 0}, weights[3] = {0, 0, 0};
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x) {
      const double d2 = double(x * x + y * y) / (ppd * ppd);
      const auto g = [&](double a, double b) {
        return a * std::sqrt(std::numbers::pi / b) * std::exp(-std::numbers::pi * std::numbers::pi * d2 / b);
      };
      const double w[3] = {g(1.0, 0.0047), g(1.0, 0.0053), g(34.1, 0.04) + g(13.5, 0.025)};
      const Colour c = ycxcz(linear_at(image, px + x, py + y));
      const double v[3] = {c.x, c.y, c.z};
      for (int k = 0; k < 3; ++k) sums[k] += w[k] * v[k], weights[k] += w[k];
    }
  const double y = (sums[0] / weights[0] + 16.0) / 116.0;
  const Colour white = xyz({1, 1, 1});
  return rgb({white.x * (y + sums[1] / weights[1] / 500.0), white.y * y, white.z * (y - sums[2] / weights[2] / 200.0)});
}

Colour hunt(Colour c) {
  c = {std::min(std::max(c.x, 0.0), 1.0), std::min(std::max(c.y, 0.0), 1.0), std::min(std::max(c.z, 0.0), 1.0)};
  const Colour v = xyz(c), w = xyz({1, 1, 1});
  const auto f = [](double t) { return t > 216.0 / 24389.0 ? std::cbrt(t) : (24389.0 / 27.0 * t + 16.0) / 116.0; };
  const double l = 116.0 * f(v.y / w.y) - 16.0;
  return {l, 0.01 * l * 500.0 * (f(v.x / w.x) - f(v.y / w.y)), 0.01 * l * 200.0 * (f(v.y / w.y) - f(v.z / w.z))};
}

double hyab(const Colour& a, const Colour& b) {
  return std::abs(a.x - b.x) + std::sqrt((a.y - b.y) * (a.y - b.y) + (a.z - b.z) * (a.z - b.z));
}

/// First (order 1) or second derivatives of the lightness; their length.
double feature(const Image& image, int px, int py, double ppd, int order) {
  const double sigma = 0.5 * 0.082 * ppd;
  const int radius = int(std::ceil(3.0 * sigma));
  const auto weight = [&](int x, int y) {
    const double g = std::exp(-double(x * x + y * y) / (2.0 * sigma * sigma));
    return order == 1 ? -x * g : (x * x / (sigma * sigma) - 1.0) * g;
  };
  double positive = 0.0, negative = 0.0;
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x) (weight(x, y) > 0.0 ? positive : negative) += weight(x, y);
  double sums[2] = {0.0, 0.0};
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x) {
      const double lightness = (ycxcz(linear_at(image, px + x, py + y)).x + 16.0) / 116.0;
      const double wx = weight(x, y), wy = weight(y, x);
      sums[0] += lightness * wx / (wx > 0.0 ? positive : -negative);
      sums[1] += lightness * wy / (wy > 0.0 ? positive : -negative);
    }
  return std::sqrt(sums[0] * sums[0] + sums[1] * sums[1]);
}

double flip_at(const Image& a, const Image& b, int x, int y, double ppd) {
  const double most = std::pow(hyab(hunt({0, 1, 0}), hunt({0, 0, 1})), 0.7);
  const double d = std::pow(hyab(hunt(filtered(a, x, y, ppd)), hunt(filtered(b, x, y, ppd))), 0.7);
  const double colour = d < 0.4 * most ? 0.95 / (0.4 * most) * d : 0.95 + 0.05 * (d - 0.4 * most) / (0.6 * most);
  double difference = 0.0;
  for (const int order : {1, 2})
    difference = std::max(difference, std::abs(feature(a, x, y, ppd, order) - feature(b, x, y, ppd, order)));
  return std::pow(colour, 1.0 - std::pow(difference / std::sqrt(2.0), 0.5));
}

TEST(Flip, IsWhatThePaperSays) {
  const Image images[] = {noise(40, 30, 1), noise(40, 30, 2), discs(40, 30, 0.0), discs(40, 30, 3.0),
                          uniform(40, 30, 200, 10, 60)};
  for (const double ppd : {67.02, 31.0, 12.5})
    for (std::size_t i = 0; i + 1 < std::size(images); ++i) {
      SCOPED_TRACE(testing::Message() << "images " << i << " and " << i + 1 << ", " << ppd << " pixels per degree");
      const std::vector<float> map = flip(images[i], images[i + 1], ppd);
      for (const auto& [x, y] : {std::pair(0, 0), {39, 29}, {20, 14}, {7, 22}, {31, 3}})
        EXPECT_NEAR(map[std::size_t(y * 40 + x)], flip_at(images[i], images[i + 1], x, y, ppd), 2e-4) << x << ", " << y;
    }
}

TEST(Flip, EndsOfTheScale) {
  const Image image = discs(32, 32, 0.0);
  for (const float v : flip(image, image)) EXPECT_EQ(v, 0.0f);
  // The colours that lie farthest apart.
  for (const float v : flip(uniform(32, 32, 0, 255, 0), uniform(32, 32, 0, 0, 255))) EXPECT_NEAR(v, 1.0f, 1e-4f);
  for (const float v : flip(noise(32, 32, 3), noise(32, 32, 4))) EXPECT_TRUE(v > 0.0f && v <= 1.0f);
}

/// From afar the eye averages what from near it tells apart.
TEST(Flip, DistanceHidesFineDifferences) {
  const auto metrics = [](double ppd) { return image_metrics(noise(64, 64, 5), noise(64, 64, 6), ppd)->flip_mean; };
  EXPECT_GT(metrics(20.0), 1.2 * metrics(150.0));
}

TEST(ImageMetrics, EqualImages) {
  const auto m = image_metrics(discs(64, 48, 0.0), discs(64, 48, 0.0));
  ASSERT_TRUE(m);
  EXPECT_TRUE(std::isinf(m->psnr));
  EXPECT_NEAR(m->ssim, 1.0, 1e-6);
  EXPECT_EQ(m->flip_mean, 0.0);
  EXPECT_EQ(m->flip_p99, 0.0);
}

/// Squares of bright values round coarsely, and variances of flat areas may come out below 0.
TEST(ImageMetrics, EqualBrightImagesHaveFullSsim) {
  for (int grey = 0; grey < 256; ++grey) {
    const auto level = std::uint8_t(grey);
    const Image image = uniform(16, 16, level, level, level);
    EXPECT_EQ(image_metrics(image, image)->ssim, 1.0) << grey;
  }
}

TEST(ImageMetrics, ValuesKnownByHand) {
  Image a = uniform(20, 20, 100, 100, 100), b = uniform(20, 20, 110, 110, 110);
  auto m = image_metrics(a, b);
  ASSERT_TRUE(m);
  EXPECT_NEAR(m->psnr, 20.0 * std::log10(25.5), 1e-9);
  const double c1 = 2.55 * 2.55;  // without variance only the means are compared
  EXPECT_NEAR(m->ssim, (2.0 * 100.0 * 110.0 + c1) / (100.0 * 100.0 + 110.0 * 110.0 + c1), 1e-5);
  a = noise(64, 64, 7);
  b = a;
  for (std::uint8_t& v : b.pixels) v = std::uint8_t(255 - v);
  m = image_metrics(a, b);
  ASSERT_TRUE(m);
  EXPECT_LT(m->ssim, -0.8) << "the negative of noise";
}

/// For images of one colour each, the means of the lightness alone count (ITU-R BT.601).
TEST(ImageMetrics, SsimWeighsRedGreenAndBlue) {
  const double weights[3] = {0.299, 0.587, 0.114}, c1 = 2.55 * 2.55;
  for (int channel = 0; channel < 3; ++channel) {
    const auto of = [&](std::uint8_t v) {
      std::uint8_t colour[3] = {0, 0, 0};
      colour[channel] = v;
      return uniform(16, 16, colour[0], colour[1], colour[2]);
    };
    const double a = weights[channel] * 200.0, b = weights[channel] * 100.0;
    const auto m = image_metrics(of(200), of(100));
    ASSERT_TRUE(m);
    EXPECT_NEAR(m->ssim, (2.0 * a * b + c1) / (a * a + b * b + c1), 1e-4) << "channel " << channel;
  }
}

/// One pixel in a hundred shows: the 99th percentile is about to notice.
TEST(ImageMetrics, PercentilesAndMeans) {
  Image b = uniform(100, 100, 0, 0, 0);
  const Image a = b;
  for (int y = 40; y < 60; ++y)
    for (int x = 0; x < 100; ++x) b.pixels[std::size_t(3 * (y * 100 + x) + 1)] = 255;
  const auto m = image_metrics(a, b);
  ASSERT_TRUE(m);
  EXPECT_GT(m->flip_p99, 0.8);
  EXPECT_GT(m->flip_mean, 0.15);
  EXPECT_LT(m->flip_mean, 0.35);
}

TEST(ImageMetrics, SizesMustFit) {
  EXPECT_FALSE(image_metrics(noise(20, 20, 1), noise(20, 21, 1)));
  const auto small = image_metrics(noise(10, 20, 1), noise(10, 20, 1));
  ASSERT_FALSE(small);
  EXPECT_NE(small.error().message.find("10x20"), std::string::npos);
}

TEST(WrongIds, AreCounted) {
  const IdImage a{3, 1, {0, 5, 7}};
  EXPECT_EQ(*wrong_ids(a, a), 0u);
  EXPECT_EQ(*wrong_ids(a, {3, 1, {1, 5, 0}}), 2u);
  EXPECT_FALSE(wrong_ids(a, {1, 3, {0, 5, 7}}));
}

/// Item 1 left of `edge`, item 2 from there on.
IdImage halves(int width, int height, int edge) {
  IdImage image{width, height, {}};
  for (int i = 0; i < width * height; ++i) image.ids.push_back(i % width < edge ? 1 : 2);
  return image;
}

TEST(IdDifferenceTest, TellsSilhouettesFromTheRest) {
  const IdImage reference = halves(8, 5, 4);
  const auto counts = [&](const IdImage& image) {
    const auto difference = id_difference(reference, image).value();
    return std::array{difference.silhouettes, difference.elsewhere};
  };
  using Counts = std::array<std::uint64_t, 2>;
  EXPECT_EQ(counts(reference), (Counts{0, 0}));
  EXPECT_EQ(counts(halves(8, 5, 5)), (Counts{5, 0})) << "a column beside the edge";
  EXPECT_EQ(counts(halves(8, 5, 2)), (Counts{5, 5})) << "one more column away";
  IdImage corner = reference;
  corner.ids[0] = 0;
  EXPECT_EQ(counts(corner), (Counts{0, 1})) << "the image's own border is no silhouette";
  EXPECT_FALSE(id_difference(reference, halves(5, 8, 4)));
}

TEST(DepthDifferenceTest, LeavesOutSilhouettesAndOtherItems) {
  const ItemDepths reference{halves(8, 5, 4), {8, 5, std::vector<float>(40, 2.0f)}};
  const auto difference = [&](const ItemDepths& image, double bound) {
    return depth_difference(reference, image, [&](std::uint32_t, double) { return bound; }).value();
  };
  EXPECT_EQ(difference(reference, 1.0).pixels, 30u) << "all but the two columns at the edge";
  EXPECT_EQ(difference(reference, 1.0).max, 0.0);
  ItemDepths image = reference;
  image.depth.metres[3] = 9.0f;  // at the silhouette
  image.ids.ids[0] = 3;          // shows something else
  image.depth.metres[0] = 9.0f;
  image.depth.metres[9] = 2.5f;
  const DepthDifference found = difference(image, 0.25);
  EXPECT_EQ(found.pixels, 29u);
  EXPECT_EQ(found.ties, 0u) << "the other item is elsewhere";
  EXPECT_EQ(found.beyond, 1u);
  EXPECT_EQ(found.max, 0.5);
  EXPECT_EQ(found.worst, 2.0);
  EXPECT_EQ(difference(image, 0.5).beyond, 0u);
  image.depth.metres[9] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(difference(image, 1e9).beyond, 1u);
}

TEST(DepthDifferenceTest, OtherItemsAtTheSameDepthAreTies) {
  const ItemDepths reference{IdImage{3, 3, std::vector<std::uint32_t>(9, 7)}, {3, 3, std::vector<float>(9, 5.0f)}};
  ItemDepths image = reference;
  for (const std::size_t i : {0u, 4u, 5u}) image.ids.ids[i] = 8;
  image.depth.metres[5] = 6.0f;
  image.ids.ids[8] = 0;
  const auto difference = depth_difference(reference, image, [](std::uint32_t, double) { return 0.5; });
  EXPECT_EQ(difference->ties, 2u);
  EXPECT_EQ(difference->pixels, 5u);
}

TEST(DepthDifferenceTest, SteepSurfacesMayDifferByA64thOfAStep) {
  ItemDepths reference{IdImage{3, 1, {1, 1, 1}}, {3, 1, {1.0f, 2.0f, 4.0f}}};
  ItemDepths image = reference;
  image.depth.metres[1] += 2.0f / 64.0f;
  const auto beyond = [&] {
    return depth_difference(reference, image, [](std::uint32_t, double) { return 0.0; }).value().beyond;
  };
  EXPECT_EQ(beyond(), 0u);
  image.depth.metres[1] += 0.001f;
  EXPECT_EQ(beyond(), 1u);
}

TEST(DepthDifferenceTest, BoundsMayDependOnItemAndDepth) {
  ItemDepths reference{IdImage{3, 3, std::vector<std::uint32_t>(9, 7)}, {3, 3, std::vector<float>(9, 5.0f)}};
  std::size_t calls = 0;
  const auto bound = [&](std::uint32_t id, double metres) {
    EXPECT_EQ(id, 7u);
    EXPECT_EQ(metres, 5.0);
    ++calls;
    return 1.0;
  };
  EXPECT_EQ(depth_difference(reference, reference, bound)->pixels, 9u);
  EXPECT_EQ(calls, 9u);
  ItemDepths other = reference;
  other.depth = {9, 1, reference.depth.metres};
  EXPECT_FALSE(depth_difference(reference, other, bound));
}

}  // namespace
}  // namespace sightline::image::image_metrics_test
