#include "sightline/apps/bench/error_time/samples.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace sightline::bench {
namespace {

/// Computed from the chord: precise for small angles, unlike the cosine.
double degrees_between(const core::vec3& a, const core::vec3& b) {
  const double half = 0.5 * glm::length(core::dvec3(a) - core::dvec3(b));
  return glm::degrees(2.0 * std::asin(std::min(1.0, half)));
}

class Silhouette {
 public:
  explicit Silhouette(const SampleImage& image) : width_(image.width), height_(image.height), on_(image.depth.size()) {
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const std::size_t i = index(x, y);
        if (!image.hit(i)) continue;
        const bool inner = x > 0 && y > 0 && x + 1 < width_ && y + 1 < height_ && image.hit(i - 1) &&
                           image.hit(i + 1) && image.hit(index(x, y - 1)) && image.hit(index(x, y + 1));
        if (inner) continue;
        on_[i] = true;
        points_.push_back({x, y});
      }
  }

  /// Adds the distances of these points to the other's nearest points, in samples and at most `farthest`.
  void distances_to(const Silhouette& other, int farthest, double& sum, double& most) const {
    for (const auto& [x, y] : points_) {
      const double distance = other.distance(x, y, farthest);
      sum += distance;
      most = std::max(most, distance);
    }
  }
  std::size_t size() const { return points_.size(); }

 private:
  std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(width_) + std::size_t(x); }
  bool on(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_ && on_[index(x, y)]; }

  /// Searches square by square outwards, until no square can hold a nearer point.
  double distance(int x, int y, int farthest) const {
    if (on(x, y)) return 0.0;
    int best = farthest * farthest;
    for (int k = 1; k * k < best; ++k)
      for (int i = -k; i <= k; ++i)
        if (on(x + i, y - k) || on(x + i, y + k) || on(x - k, y + i) || on(x + k, y + i))
          best = std::min(best, k * k + i * i);
    return std::sqrt(double(best));
  }

  int width_, height_;
  std::vector<bool> on_;
  struct Point {
    int x, y;
  };
  std::vector<Point> points_;
};

}  // namespace

SampleImage::SampleImage(int w, int h)
    : width(w),
      height(h),
      depth(std::size_t(w) * std::size_t(h), std::numeric_limits<double>::infinity()),
      normals(depth.size(), core::vec3(0.0f)) {}

bool SampleImage::hit(std::size_t i) const {
  return depth[i] < std::numeric_limits<double>::infinity();
}

SampleErrors compare_samples(const SampleImage& reference, const SampleImage& image, int samples_per_pixel) {
  assert(reference.width == image.width && reference.height == image.height && samples_per_pixel >= 1);
  SampleErrors errors;
  std::vector<double> depths, normals;
  for (std::size_t i = 0; i < reference.depth.size(); ++i) {
    const bool wanted = reference.hit(i), found = image.hit(i);
    errors.hits += wanted;
    errors.false_hits += found && !wanted;
    errors.false_misses += wanted && !found;
    if (!wanted || !found) continue;
    depths.push_back(std::abs(image.depth[i] - reference.depth[i]) / reference.depth[i]);
    normals.push_back(degrees_between(reference.normals[i], image.normals[i]));
  }
  errors.depth = apps::summarise(std::move(depths));
  errors.normal = apps::summarise(std::move(normals));

  const Silhouette wanted(reference), found(image);
  const int farthest = kFarthestSilhouette * samples_per_pixel;
  wanted.distances_to(found, farthest, errors.silhouette_mean, errors.silhouette_max);
  found.distances_to(wanted, farthest, errors.silhouette_mean, errors.silhouette_max);
  if (const std::size_t points = wanted.size() + found.size(); points > 0) errors.silhouette_mean /= double(points);
  errors.silhouette_mean /= samples_per_pixel;
  errors.silhouette_max /= samples_per_pixel;
  return errors;
}

}  // namespace sightline::bench
