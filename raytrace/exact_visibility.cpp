#include "sightline/raytrace/exact_visibility.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <mutex>
#include <optional>
#include <span>
#include <utility>

#include "sightline/core/image_rays.h"
#include "sightline/core/internal/openmp.h"

namespace sightline::raytrace {
namespace {

constexpr int kTile = 4;  // rows and columns of pixels that are traced together

struct Samples {
  const Tracer& tracer;
  const core::ImageRays& pixels;
  RayFilter filter;
  int width, height;                   // pixels
  std::vector<core::dvec2> positions;  // in each pixel
};

/// Counts the samples of kTile rows of pixels. Returns the first error.
std::optional<core::Error> count_rows(const Samples& samples, int top, std::vector<std::uint64_t>& counts) {
  const auto& [tracer, pixels, filter, width, height, positions] = samples;
  std::vector<core::Ray> rays;
  std::vector<FirstHit> hits;
  for (int left = 0; left < width; left += kTile) {
    rays.clear();
    for (const core::dvec2& at : positions)
      for (int row = top; row < std::min(top + kTile, height); ++row)
        for (int column = left; column < std::min(left + kTile, width); ++column)
          rays.push_back(pixels.through(column + at.x, row + at.y));
    hits.resize(rays.size());
    if (auto traced = tracer.nearest(rays, hits, filter); !traced) return traced.error();
    for (const FirstHit& hit : hits)
      if (hit.slot != core::kNone) ++counts[hit.slot];
  }
  return std::nullopt;
}

}  // namespace

std::vector<core::dvec2> sample_positions(int samples) {
  assert(samples > 0);
  const int n = int(std::lround(std::sqrt(samples)));
  if (n * n != samples) return core::rook_positions(samples);
  std::vector<core::dvec2> positions;
  for (int i = 0; i < samples; ++i) positions.emplace_back((i % n + 0.5) / n, (i / n + 0.5) / n);
  return positions;
}

core::Expected<std::vector<VisibleItem>> ExactVisibility::compute(const core::View& view, int width, int height,
                                                                  int samples, [[maybe_unused]] int threads,
                                                                  std::span<const std::uint64_t> without) const {
  if (width <= 0 || height <= 0 || samples <= 0)
    return core::fail("exact visibility: width, height and samples must be above 0");
  const auto pixels = core::ImageRays::create(view, width, height);
  if (!pixels) return tl::unexpected(pixels.error());
  const core::Snapshot& snapshot = tracer_->snapshot();
  RayFilter filter = filter_of(view);
  filter.without = without;
  const Samples wanted{*tracer_, *pixels, filter, width, height, sample_positions(samples)};
  std::vector<std::uint64_t> total(snapshot.size());
  std::optional<core::Error> failed;
  std::mutex mutex;  // guards both
#pragma omp parallel num_threads(core::team_of(threads))
  {
    std::vector<std::uint64_t> counts(snapshot.size());
    std::optional<core::Error> error;
#pragma omp for schedule(dynamic, 1)
    for (int row = 0; row < height; row += kTile)
      if (!error) error = count_rows(wanted, row, counts);
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
