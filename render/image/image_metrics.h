// Measures of the difference of two images: PSNR (per pixel), SSIM (structure) and FLIP (what a viewer sees who flips
// between them).
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/render/image/image.h"

namespace sightline::image {

/// Pixels per degree of the visual field for a 0.7 m wide screen of 3,840 pixels seen from 0.7 m, as in FLIP's paper.
inline constexpr double kPixelsPerDegree = 67.02;

struct ImageMetrics {
  double psnr = 0.0;       ///< decibels over all channels, peak 255; infinity for equal images
  double ssim = 0.0;       ///< mean over all 11 × 11 windows, of luma; 1 for equal images
  double flip_mean = 0.0;  ///< 0: equal, 1: as different as can be
  double flip_p99 = 0.0;   ///< 99 % of all pixels have a smaller error
};

/// SSIM after Wang, Bovik, Sheikh and Simoncelli, "Image Quality Assessment: From Error Visibility to Structural
/// Similarity" (IEEE Transactions on Image Processing 13(4), 2004): Gaussian windows of deviation 1.5, K1 = 0.01, K2 =
/// 0.03. FLIP: see flip(). Fails when the sizes differ or are below 11 pixels. Some 0.3 seconds per megapixel.
SIGHTLINE_API core::Expected<ImageMetrics> image_metrics(const Image& reference, const Image& image,
                                                         double pixels_per_degree = kPixelsPerDegree);

/// The error map of FLIP for images of low dynamic range: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and
/// Fairchild, "FLIP: A Difference Evaluator for Alternating Images" (Proceedings of the ACM on Computer Graphics and
/// Interactive Techniques 3(2), 2020). Images are sRGB. Rows top to bottom, 0 … 1. Preconditions: equal sizes,
/// pixels_per_degree > 0.
SIGHTLINE_API std::vector<float> flip(const Image& reference, const Image& image,
                                      double pixels_per_degree = kPixelsPerDegree);

/// Number of pixels that show another item, or none in just one of the images. Fails when the sizes differ.
SIGHTLINE_API core::Expected<std::uint64_t> wrong_ids(const IdImage& reference, const IdImage& image);

/// Pixels that show another item than the reference. Renderers may round a silhouette to either side of a pixel's
/// centre, so those at silhouettes are counted apart: the reference shows another item, or none, in one of the eight
/// pixels around them.
struct IdDifference {
  std::uint64_t silhouettes = 0;
  std::uint64_t elsewhere = 0;
};
/// Fails when the sizes differ.
SIGHTLINE_API core::Expected<IdDifference> id_difference(const IdImage& reference, const IdImage& image);

/// An image's items with their depths.
struct ItemDepths {
  IdImage ids;
  DepthImage depth;
};

/// Differences of depth, over the pixels in which both images show the same item and no silhouette of the reference
/// is near.
struct DepthDifference {
  std::uint64_t pixels = 0;  ///< that were compared
  std::uint64_t beyond = 0;  ///< of these, beyond their bound
  double max = 0.0;          ///< metres
  double worst = 0.0;        ///< largest ratio of a difference and its bound
  /// Not among `pixels`: no silhouette is near, the items differ, and their depths do not. Faces touch in one plane,
  /// and either may show.
  std::uint64_t ties = 0;
};
/// `bound(id, metres)` is by how much two exact enough renderers may differ on that item at that depth, in metres. A
/// 64th of the largest step to the four pixels around is added: each renderer may place a pixel's centre a 128th of a
/// pixel aside (docs/reference/accuracy.md). Fails when the sizes differ.
SIGHTLINE_API core::Expected<DepthDifference> depth_difference(
    const ItemDepths& reference, const ItemDepths& image,
    const std::function<double(std::uint32_t id, double metres)>& bound);

}  // namespace sightline::image
