#include "sightline/apps/bench/losses/surface_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "sightline/apps/bench/losses/triangle_distance.h"

namespace sightline::bench {
namespace {

using core::dvec3;

/// Finds the nearest point of the reference's surfaces. Lengths are pixels at the depth of the point asked for.
class Nearest {
 public:
  Nearest(const core::View& view, const image::ItemDepths& reference, int finer, int width, int height)
      : reference_(reference),
        finer_(finer),
        width_(width),
        height_(height),
        focal_(0.5 * width * view.clip_from_eye()[0][0]) {}

  /// The distance from what the pixel shows; infinite where nothing of the item is within `radius`.
  double from(int x, int y, std::uint32_t id, double depth, double radius) const {
    const dvec3 point = at(x + 0.5, y + 0.5, 1.0);
    double best = std::numeric_limits<double>::infinity();
    const int i0 = finer_ * x + (finer_ - 1) / 2, j0 = finer_ * y + (finer_ - 1) / 2;
    const int most = int(std::ceil(radius * finer_));
    for (int ring = 0; ring <= most && kNearer * (ring - 0.5) / finer_ < best; ++ring)
      for (int j = j0 - ring; j <= j0 + ring; ++j)
        for (int i = i0 - ring; i <= i0 + ring; i += std::abs(j - j0) == ring ? 1 : std::max(1, 2 * ring))
          best = std::min(best, to_cell(i, j, id, depth, point));
    return best <= radius ? best : std::numeric_limits<double>::infinity();
  }

 private:
  // The least distance in space, as a share of the distance in the image: rays at the image's corners lie aslant.
  static constexpr double kNearer = 0.5;

  dvec3 at(double x, double y, double depth) const {
    return depth * dvec3(x - 0.5 * width_, y - 0.5 * height_, focal_);
  }

  /// The distance to what four neighbouring samples show of the item.
  double to_cell(int i, int j, std::uint32_t id, double depth, const dvec3& point) const {
    const image::DepthImage& all = reference_.depth;
    if (i < 0 || j < 0 || i + 1 >= all.width || j + 1 >= all.height) return std::numeric_limits<double>::infinity();
    dvec3 corners[4];
    bool shows[4];
    double best = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 4; ++k) {
      const int u = i + (k & 1), v = j + (k >> 1);
      const std::size_t sample = std::size_t(v) * std::size_t(all.width) + std::size_t(u);
      shows[k] = reference_.ids.ids[sample] == id;
      if (!shows[k]) continue;
      corners[k] = at((u + 0.5) / finer_, (v + 0.5) / finer_, double(all.metres[sample]) / depth) - point;
      best = std::min(best, glm::length(corners[k]));
    }
    for (const auto [a, b, c] : {std::array{0, 1, 2}, std::array{1, 3, 2}})
      if (shows[a] && shows[b] && shows[c])
        best = std::min(best, distance_to_triangle(corners[a], corners[b], corners[c]));
    return best;
  }

  const image::ItemDepths& reference_;
  int finer_, width_, height_;
  double focal_;  // pixels
};

}  // namespace

std::vector<double> surface_errors(const core::View& view, const image::ItemDepths& reference, int finer,
                                   const image::ItemDepths& image, double radius) {
  const int width = image.ids.width, height = image.ids.height;
  const Nearest nearest(view, reference, finer, width, height);
  std::vector<double> errors;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t pixel = std::size_t(y) * std::size_t(width) + std::size_t(x);
      if (image.ids.ids[pixel] == 0) continue;
      const double error = nearest.from(x, y, image.ids.ids[pixel], double(image.depth.metres[pixel]), radius);
      if (std::isfinite(error)) errors.push_back(error);
    }
  return errors;
}

}  // namespace sightline::bench
