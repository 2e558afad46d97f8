// The exact visible set of a view, by rays: exact at its sample positions, and nothing more. An item that covers no
// sample is not reported, however near to one it comes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/raytrace/tracer.h"

namespace sightline::raytrace {

struct VisibleItem {
  core::ItemId item;
  std::uint64_t samples;  ///< that show it; at least 1
  friend bool operator==(const VisibleItem&, const VisibleItem&) = default;
};

/// Borrows a tracer, which must outlive it. Several threads may compute at once.
class SIGHTLINE_API ExactVisibility {
 public:
  explicit ExactVisibility(const Tracer& tracer) : tracer_(&tracer) {}

  /// The items that an image of width x height pixels shows, in rising order. Layers and section planes are the
  /// view's; transparent items hide what is behind them; lines are not seen. `samples` per pixel lie where
  /// sample_positions() has them. `threads`: 0: all that OpenMP offers; the answer does not depend on them. Fails as
  /// core::image_ray() does, and unless width, height and samples are above 0. `without`: slots that hide nothing and
  /// are not seen, as RayFilter has them.
  core::Expected<std::vector<VisibleItem>> compute(const core::View& view, int width, int height, int samples = 1,
                                                   int threads = 0, std::span<const std::uint64_t> without = {}) const;

 private:
  const Tracer* tracer_;
};

/// Where the samples of a pixel lie, 0 … 1 from its upper left corner; their mean is the pixel's middle. In the cells
/// of a grid of n x n where `samples`, 1 or more, is n^2. Otherwise as core::rook_positions() has them.
SIGHTLINE_API std::vector<core::dvec2> sample_positions(int samples);

}  // namespace sightline::raytrace
