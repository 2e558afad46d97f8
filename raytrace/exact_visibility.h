// The exact visible set of a view, by rays: exact at its sample positions, and nothing more. An item that covers no
// sample is not reported, however near to one it comes.
#pragma once

#include <cstdint>
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

  /// The items that a picture of width x height pixels shows, in rising order. Layers and section planes are the
  /// view's; transparent items hide what is behind them; lines are not seen. `samples` per pixel lie where
  /// sample_position() has them. `threads`: 0: all that OpenMP offers; the answer does not depend on them. Fails as
  /// pixel_ray() does, and unless width, height and samples are above 0.
  core::Expected<std::vector<VisibleItem>> compute(const core::View& view, int width, int height, int samples = 1,
                                                   int threads = 0) const;

 private:
  const Tracer* tracer_;
};

/// Position of a sample within its pixel, 0 … 1 from the upper left corner: point `sample` of the Hammersley set of
/// `samples` points. The middle of the pixel for one sample; one in each row and column of a grid for a power of two.
SIGHTLINE_API core::dvec2 sample_position(int sample, int samples);

}  // namespace sightline::raytrace
