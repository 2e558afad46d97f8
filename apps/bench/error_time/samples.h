// Samples of an image that a form shows, and their errors.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/apps/common/statistics.h"
#include "sightline/core/conventions.h"

namespace sightline::bench {

/// Rows run top to bottom.
struct SampleImage {
  int width = 0, height = 0;
  std::vector<double> depth;        ///< metres along the view axis, infinity where nothing is hit
  std::vector<core::vec3> normals;  ///< unit length, in eye space, towards the eye

  SampleImage(int w, int h);
  bool hit(std::size_t i) const;
};

struct SampleErrors {
  std::uint64_t hits = 0;                              ///< samples that the reference hits
  std::uint64_t false_hits = 0, false_misses = 0;      ///< samples
  apps::Summary depth;                                 ///< |z - z_ref| / z_ref where both hit
  apps::Summary normal;                                ///< degrees, where both hit
  double silhouette_mean = 0.0, silhouette_max = 0.0;  ///< pixels

  std::uint64_t wrong() const { return false_hits + false_misses; }
};

/// Upper limit of distances between silhouettes, pixels.
inline constexpr int kFarthestSilhouette = 40;

/// Errors of `image` against `reference`. Both have the same size, with `samples_per_pixel` >= 1 along each axis.
///
/// The silhouette of an image is the set of hit samples that have a miss among their four neighbours. The mean error
/// of two silhouettes averages, over all samples of both, the distance to the nearest sample of the other. The maximum
/// is the Hausdorff distance. A shift by less than a sample changes only some samples, so the mean resolves far less
/// than a sample.
SampleErrors compare_samples(const SampleImage& reference, const SampleImage& image, int samples_per_pixel);

}  // namespace sightline::bench
