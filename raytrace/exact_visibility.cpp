#include "sightline/raytrace/exact_visibility.h"

#include <algorithm>
#include <mutex>
#include <optional>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace sightline::raytrace {
namespace {

/// Counts the samples of a row of pixels. Returns the first error.
std::optional<core::Error> count_row(const Tracer& tracer, const core::View& view, const RayFilter& filter, int width,
                                     int height, int samples, int row, std::vector<std::uint64_t>& counts) {
  for (int column = 0; column < width; ++column)
    for (int sample = 0; sample < samples; ++sample) {
      const core::dvec2 at = sample_position(sample, samples);
      const auto ray = pixel_ray(view, width, height, column + at.x, row + at.y);
      if (!ray) return ray.error();
      const auto hit = tracer.nearest(*ray, filter);
      if (!hit) return hit.error();
      if (*hit) ++counts[(*hit)->slot];
    }
  return std::nullopt;
}

}  // namespace

core::dvec2 sample_position(int sample, int samples) {
  double y = 0.5 / samples, digit = 0.5;
  for (int rest = sample; rest > 0; rest /= 2, digit *= 0.5) y += rest % 2 * digit;
  return {(sample + 0.5) / samples, y < 1.0 ? y : y - 1.0};
}

core::Expected<std::vector<VisibleItem>> ExactVisibility::compute(const core::View& view, int width, int height,
                                                                  int samples, [[maybe_unused]] int threads) const {
  if (width <= 0 || height <= 0 || samples <= 0)
    return core::fail("exact visibility: width, height and samples must be above 0");
  const core::Snapshot& snapshot = tracer_->snapshot();
  const RayFilter filter = filter_of(view);
  std::vector<std::uint64_t> total(snapshot.size());
  std::optional<core::Error> failed;
  std::mutex mutex;  // guards both
#ifdef _OPENMP
  if (threads <= 0) threads = omp_get_max_threads();
#pragma omp parallel num_threads(threads)
#endif
  {
    std::vector<std::uint64_t> counts(snapshot.size());
    std::optional<core::Error> error;
#ifdef _OPENMP
#pragma omp for schedule(dynamic, 4)
#endif
    for (int row = 0; row < height; ++row)
      if (!error) error = count_row(*tracer_, view, filter, width, height, samples, row, counts);
    const std::lock_guard held(mutex);
    if (error) failed = error;
    for (std::size_t slot = 0; slot < counts.size(); ++slot) total[slot] += counts[slot];
  }
  if (failed) return tl::unexpected(*failed);
  std::vector<VisibleItem> items;
  for (std::size_t slot = 0; slot < total.size(); ++slot)
    if (total[slot] > 0) items.push_back({snapshot.item(core::Slot(slot)), total[slot]});
  std::sort(items.begin(), items.end(), [](const VisibleItem& a, const VisibleItem& b) { return a.item < b.item; });
  return items;
}

}  // namespace sightline::raytrace
