#include "sightline/render/image/image_metrics.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <glm/glm.hpp>

#include "sightline/core/internal/srgb.h"

namespace sightline::image {
namespace {

using glm::dmat3;
using glm::dvec3;

constexpr double kPi = std::numbers::pi;

/// One channel of an image.
struct Plane {
  int width = 0, height = 0;
  std::vector<float> values;

  Plane(int w, int h) : width(w), height(h), values(std::size_t(w) * std::size_t(h)) {}
  std::size_t at(int x, int y) const { return std::size_t(y) * std::size_t(width) + std::size_t(x); }
};

/// Weights for offsets -radius … radius.
using Kernel = std::vector<double>;

/// exp(-x² / (2 deviation²)) times weight(x), x being the offset in pixels.
template <class Weight>
Kernel gaussian(int radius, double deviation, const Weight& weight) {
  Kernel kernel;
  for (int x = -radius; x <= radius; ++x)
    kernel.push_back(weight(x) * std::exp(-double(x) * x / (2.0 * deviation * deviation)));
  return kernel;
}

double sum(const Kernel& kernel) {
  double total = 0.0;
  for (const double w : kernel) total += w;
  return total;
}

/// Scaled so that positive weights have sum 1 and negative ones -1.
Kernel balanced(Kernel kernel) {
  double positive = 0.0, negative = 0.0;
  for (const double w : kernel) (w > 0.0 ? positive : negative) += w;
  for (double& w : kernel) w /= w > 0.0 ? positive : -negative;
  return kernel;
}

/// to[i] += weight * from[i], i in [0, count).
void add_scaled(const float* from, double weight, int count, float* to) {
  const float w = float(weight);
  for (int i = 0; i < count; ++i) to[i] += w * from[i];
}

/// Convolves along rows, then along columns. Edge pixels repeat beyond the image's edges.
Plane convolve(const Plane& in, const Kernel& along_x, const Kernel& along_y) {
  const int rx = int(along_x.size() / 2), ry = int(along_y.size() / 2);
  Plane rows(in.width, in.height), result(in.width, in.height);
  std::vector<float> padded(std::size_t(in.width) + along_x.size() - 1);
  for (int y = 0; y < in.height; ++y) {
    const float* row = &in.values[in.at(0, y)];
    std::fill_n(padded.begin(), rx, row[0]);
    std::copy_n(row, in.width, padded.begin() + rx);
    std::fill(padded.begin() + rx + in.width, padded.end(), row[in.width - 1]);
    for (std::size_t k = 0; k < along_x.size(); ++k)
      add_scaled(&padded[k], along_x[k], in.width, &rows.values[in.at(0, y)]);
  }
  for (int y = 0; y < in.height; ++y)
    for (std::size_t k = 0; k < along_y.size(); ++k) {
      const int nearest = std::clamp(y + int(k) - ry, 0, in.height - 1);
      add_scaled(&rows.values[in.at(0, nearest)], along_y[k], in.width, &result.values[in.at(0, y)]);
    }
  return result;
}

// --- PSNR and SSIM ---------------------------------------------------------------------------------------------------

double psnr(const Image& a, const Image& b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const double d = double(a.pixels[i]) - double(b.pixels[i]);
    squares += d * d;
  }
  if (squares == 0.0) return std::numeric_limits<double>::infinity();
  return 10.0 * std::log10(255.0 * 255.0 * double(a.pixels.size()) / squares);
}

constexpr int kSsimRadius = 5;

/// Luma after ITU-R BT.601.
Plane luma(const Image& image) {
  Plane plane(image.width, image.height);
  for (std::size_t i = 0; i < plane.values.size(); ++i) {
    const std::uint8_t* p = &image.pixels[3 * i];
    plane.values[i] = float(0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2]);
  }
  return plane;
}

double ssim(const Image& image_a, const Image& image_b) {
  const Plane a = luma(image_a), b = luma(image_b);
  Kernel window = gaussian(kSsimRadius, 1.5, [](int) { return 1.0; });
  const double total = sum(window);
  for (double& w : window) w /= total;
  const auto mean_of = [&](const auto& value) {
    Plane plane(a.width, a.height);
    for (std::size_t i = 0; i < plane.values.size(); ++i) plane.values[i] = value(i);
    return convolve(plane, window, window);
  };
  const Plane mean_a = convolve(a, window, window), mean_b = convolve(b, window, window);
  const Plane aa = mean_of([&](std::size_t i) { return a.values[i] * a.values[i]; });
  const Plane bb = mean_of([&](std::size_t i) { return b.values[i] * b.values[i]; });
  const Plane ab = mean_of([&](std::size_t i) { return a.values[i] * b.values[i]; });
  constexpr double kC1 = 0.01 * 255.0 * 0.01 * 255.0, kC2 = 0.03 * 255.0 * 0.03 * 255.0;
  double similarity = 0.0;
  for (int y = kSsimRadius; y < a.height - kSsimRadius; ++y)
    for (int x = kSsimRadius; x < a.width - kSsimRadius; ++x) {
      const std::size_t i = a.at(x, y);
      const double ma = mean_a.values[i], mb = mean_b.values[i];
      const double va = aa.values[i] - ma * ma, vb = bb.values[i] - mb * mb, cov = ab.values[i] - ma * mb;
      similarity += (2.0 * ma * mb + kC1) * (2.0 * cov + kC2) /
                    ((ma * ma + mb * mb + kC1) * (va + vb + kC2));  // rounding below 0 is negligible beside kC2
    }
  return similarity / (double(a.width - 2 * kSsimRadius) * double(a.height - 2 * kSsimRadius));
}

// --- FLIP: colours ---------------------------------------------------------------------------------------------------

/// Linear sRGB to CIE XYZ. Transposed, since GLM stores columns.
const dmat3 kXyzFromRgb = glm::transpose(
    dmat3(0.41238656, 0.35759149, 0.18045049, 0.21263682, 0.71518298, 0.07218020, 0.01933062, 0.11919716, 0.95037259));
const dmat3 kRgbFromXyz = glm::inverse(kXyzFromRgb);
const dvec3 kWhite = kXyzFromRgb * dvec3(1.0);

/// The linear form of CIELAB in which the eye's contrast sensitivity is known: lightness, red-green, blue-yellow.
dvec3 opponent_from_rgb(const dvec3& rgb) {
  const dvec3 n = kXyzFromRgb * rgb / kWhite;
  return {116.0 * n.y - 16.0, 500.0 * (n.x - n.y), 200.0 * (n.y - n.z)};
}

dvec3 rgb_from_opponent(const dvec3& c) {
  const double y = (c.x + 16.0) / 116.0;
  return kRgbFromXyz * (kWhite * dvec3(y + c.y / 500.0, y, y - c.z / 200.0));
}

/// CIELAB with chroma that counts less in the dark (Hunt's effect).
dvec3 hunt_lab_from_rgb(const dvec3& rgb) {
  const auto f = [](double t) {
    constexpr double kLimit = 6.0 / 29.0;
    return t > kLimit * kLimit * kLimit ? std::cbrt(t) : t / (3.0 * kLimit * kLimit) + 4.0 / 29.0;
  };
  const dvec3 n = kXyzFromRgb * rgb / kWhite;
  const double lightness = 116.0 * f(n.y) - 16.0;
  return {lightness, 0.01 * lightness * 500.0 * (f(n.x) - f(n.y)), 0.01 * lightness * 200.0 * (f(n.y) - f(n.z))};
}

double hyab(const dvec3& a, const dvec3& b) {
  return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

constexpr double kColourExponent = 0.7;

/// Spreads differences over the range so that small ones take most of it: 95 % goes to the first 40 % of the largest
/// difference possible.
double spread(double difference) {
  static const double kLargest =
      std::pow(hyab(hunt_lab_from_rgb({0, 1, 0}), hunt_lab_from_rgb({0, 0, 1})), kColourExponent);
  constexpr double kShare = 0.4, kRange = 0.95;
  const double limit = kShare * kLargest;
  if (difference < limit) return difference * kRange / limit;
  return kRange + (difference - limit) / (kLargest - limit) * (1.0 - kRange);
}

using Planes = std::array<Plane, 3>;

Planes opponent_planes(const Image& image) {
  Planes planes{Plane(image.width, image.height), Plane(image.width, image.height), Plane(image.width, image.height)};
  const std::array<double, 256> linear = core::linear_from_bytes();
  for (std::size_t i = 0; i < planes[0].values.size(); ++i) {
    const std::uint8_t* p = &image.pixels[3 * i];
    const dvec3 colour = opponent_from_rgb({linear[p[0]], linear[p[1]], linear[p[2]]});
    for (int k = 0; k < 3; ++k) planes[std::size_t(k)].values[i] = float(colour[k]);
  }
  return planes;
}

/// A sum of two Gaussians, a sqrt(pi / b) exp(-pi² x² / b) with x in degrees.
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr std::array<Sensitivity, 3> kSensitivity = {
    {{1.0, 0.0047, 0.0, 1e-5}, {1.0, 0.0053, 0.0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};

/// Blurred to what the eye still resolves.
Plane blurred(const Plane& plane, const Sensitivity& s, double pixels_per_degree) {
  const int radius = int(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * kPi * kPi)) * pixels_per_degree));
  Plane result(plane.width, plane.height);
  const double as[2] = {s.a1, s.a2}, bs[2] = {s.b1, s.b2};
  double weights[2] = {0.0, 0.0};
  Kernel kernels[2];
  for (int i = 0; i < 2; ++i) {
    if (as[i] == 0.0) continue;
    kernels[i] = gaussian(radius, pixels_per_degree * std::sqrt(bs[i] / 2.0) / kPi, [](int) { return 1.0; });
    const double total = sum(kernels[i]);
    for (double& w : kernels[i]) w /= total;
    weights[i] = as[i] * std::sqrt(kPi / bs[i]) * total * total;
  }
  for (int i = 0; i < 2; ++i) {
    if (as[i] == 0.0) continue;
    const float share = float(weights[i] / (weights[0] + weights[1]));
    const Plane part = convolve(plane, kernels[i], kernels[i]);
    for (std::size_t k = 0; k < result.values.size(); ++k) result.values[k] += share * part.values[k];
  }
  return result;
}

std::vector<dvec3> seen_colours(const Planes& planes, double pixels_per_degree) {
  std::array<Plane, 3> seen = {blurred(planes[0], kSensitivity[0], pixels_per_degree),
                               blurred(planes[1], kSensitivity[1], pixels_per_degree),
                               blurred(planes[2], kSensitivity[2], pixels_per_degree)};
  std::vector<dvec3> colours(seen[0].values.size());
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const dvec3 rgb = rgb_from_opponent({seen[0].values[i], seen[1].values[i], seen[2].values[i]});
    colours[i] = hunt_lab_from_rgb(glm::clamp(rgb, 0.0, 1.0));
  }
  return colours;
}

// --- FLIP: edges and points ------------------------------------------------------------------------------------------

struct Features {
  std::vector<float> edges, points;  ///< magnitudes
};

Features features(const Plane& lightness, double pixels_per_degree) {
  constexpr double kWidth = 0.082;  // degrees: width of the features that the eye's edge detectors respond to
  const double deviation = 0.5 * kWidth * pixels_per_degree;
  const int radius = int(std::ceil(3.0 * deviation));
  Kernel across = gaussian(radius, deviation, [](int) { return 1.0; });
  const double total = sum(across);
  for (double& w : across) w /= total;
  const Kernel first = balanced(gaussian(radius, deviation, [](int x) { return -double(x); }));
  const Kernel second =
      balanced(gaussian(radius, deviation, [&](int x) { return double(x) * x / (deviation * deviation) - 1.0; }));
  Plane normalised = lightness;
  for (float& v : normalised.values) v = (v + 16.0f) / 116.0f;
  const auto magnitude = [&](const Kernel& kernel) {
    const Plane x = convolve(normalised, kernel, across), y = convolve(normalised, across, kernel);
    std::vector<float> values(x.values.size());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::hypot(x.values[i], y.values[i]);
    return values;
  };
  return {magnitude(first), magnitude(second)};
}

bool same_size(const auto& a, const auto& b) {
  return a.width == b.width && a.height == b.height;
}

std::string size_text(const auto& image) {
  return std::to_string(image.width) + "x" + std::to_string(image.height);
}

std::size_t index(const auto& image, int x, int y) {
  return std::size_t(y) * std::size_t(image.width) + std::size_t(x);
}

/// Whether the image shows something else in one of the eight pixels around.
bool at_silhouette(const IdImage& image, int x, int y) {
  const std::uint32_t id = image.ids[index(image, x, y)];
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, image.height - 1); ++v)
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, image.width - 1); ++u)
      if (image.ids[index(image, u, v)] != id) return true;
  return false;
}

/// Largest difference to the depths of the pixels left, right, above and below. Metres.
double largest_step(const DepthImage& image, int x, int y) {
  const double here = double(image.metres[index(image, x, y)]);
  double largest = 0.0;
  const auto step_to = [&](int u, int v) {
    if (u < 0 || v < 0 || u >= image.width || v >= image.height) return;
    largest = std::max(largest, std::abs(double(image.metres[index(image, u, v)]) - here));
  };
  step_to(x - 1, y), step_to(x + 1, y), step_to(x, y - 1), step_to(x, y + 1);
  return largest;
}

}  // namespace

std::vector<float> flip(const Image& reference, const Image& image, double pixels_per_degree) {
  assert(same_size(reference, image) && pixels_per_degree > 0.0);
  const Planes planes_a = opponent_planes(reference), planes_b = opponent_planes(image);
  const std::vector<dvec3> a = seen_colours(planes_a, pixels_per_degree), b = seen_colours(planes_b, pixels_per_degree);
  const Features fa = features(planes_a[0], pixels_per_degree), fb = features(planes_b[0], pixels_per_degree);
  std::vector<float> error(a.size());
  for (std::size_t i = 0; i < error.size(); ++i) {
    const double colour = spread(std::pow(hyab(a[i], b[i]), kColourExponent));
    const double feature = std::max(std::abs(double(fa.edges[i]) - double(fb.edges[i])),
                                    std::abs(double(fa.points[i]) - double(fb.points[i])));
    error[i] = float(std::pow(colour, 1.0 - std::sqrt(feature / std::numbers::sqrt2)));
  }
  return error;
}

core::Expected<ImageMetrics> image_metrics(const Image& reference, const Image& image, double pixels_per_degree) {
  if (!same_size(reference, image))
    return core::fail("images of different sizes, " + size_text(reference) + " and " + size_text(image));
  constexpr int kLeast = 2 * kSsimRadius + 1;
  if (image.width < kLeast || image.height < kLeast)
    return core::fail("an image of " + size_text(image) + ", and SSIM wants 11x11 at least");
  ImageMetrics metrics;
  metrics.psnr = psnr(reference, image);
  metrics.ssim = ssim(reference, image);
  std::vector<float> map = flip(reference, image, pixels_per_degree);
  double total = 0.0;
  for (const float v : map) total += double(v);
  metrics.flip_mean = total / double(map.size());
  const auto p99 = map.begin() + std::ptrdiff_t(0.99 * double(map.size() - 1));
  std::nth_element(map.begin(), p99, map.end());
  metrics.flip_p99 = double(*p99);
  return metrics;
}

core::Expected<std::uint64_t> wrong_ids(const IdImage& reference, const IdImage& image) {
  if (!same_size(reference, image))
    return core::fail("id images of different sizes, " + size_text(reference) + " and " + size_text(image));
  std::uint64_t wrong = 0;
  for (std::size_t i = 0; i < image.ids.size(); ++i) wrong += reference.ids[i] != image.ids[i];
  return wrong;
}

core::Expected<IdDifference> id_difference(const IdImage& reference, const IdImage& image) {
  if (!same_size(reference, image))
    return core::fail("id images of different sizes, " + size_text(reference) + " and " + size_text(image));
  IdDifference difference;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::size_t i = index(image, x, y);
      if (reference.ids[i] != image.ids[i])
        ++(at_silhouette(reference, x, y) ? difference.silhouettes : difference.elsewhere);
    }
  return difference;
}

core::Expected<DepthDifference> depth_difference(const ItemDepths& reference, const ItemDepths& image,
                                                 const std::function<double(std::uint32_t id, double metres)>& bound) {
  const auto fits = [&](const auto& other) { return same_size(reference.ids, other); };
  if (!fits(reference.depth) || !fits(image.ids) || !fits(image.depth))
    return core::fail("depth images of different sizes, " + size_text(reference.depth) + " and " +
                      size_text(image.depth));
  DepthDifference difference;
  for (int y = 0; y < image.ids.height; ++y)
    for (int x = 0; x < image.ids.width; ++x) {
      const std::size_t i = index(image.ids, x, y);
      const std::uint32_t id = reference.ids.ids[i], other_id = image.ids.ids[i];
      if (id == 0 || other_id == 0 || at_silhouette(reference.ids, x, y)) continue;
      const double metres = double(reference.depth.metres[i]), other = double(image.depth.metres[i]);
      const double error = std::abs(other - metres);
      const double allowed = bound(id, metres) + largest_step(reference.depth, x, y) / 64.0;
      if (other_id != id) {
        difference.ties += error <= allowed;
        continue;
      }
      ++difference.pixels;
      difference.beyond += !(error <= allowed);  // what is no number is beyond
      difference.max = std::max(difference.max, error);
      difference.worst = std::max(difference.worst, error / allowed);
    }
  return difference;
}

}  // namespace sightline::image
