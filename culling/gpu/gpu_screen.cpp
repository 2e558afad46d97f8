#include "sightline/culling/gpu/internal/gpu_screen.h"

#include <cassert>
#include <cmath>

#include "sightline/culling/occlusion/detail/screen_view.h"

namespace sightline::culling {
namespace {

/// The error of a form's value, in units of the sum of the sizes of its four products. A coefficient is off by 2^-24, a
/// product and three sums by 2^-23 each; that the bands are rounded, too, takes less than the rest.
constexpr double kUnits = 0x1p-20;

}  // namespace

ScreenBlock make_screen_block(const core::View& view, const core::ItemBounds& bounds, const ImageSamples& samples) {
  assert(!samples.offsets.empty() && samples.offsets.size() <= std::size_t(kMaxSamples));
  const ScreenView screen = make_screen_view(view, bounds.origin, samples.width, samples.height, samples.snap);
  double sizes = 0.0;  // of all coordinates
  if (!bounds.extent().empty())
    for (int i = 0; i < 3; ++i)
      sizes += std::max(std::abs(double(bounds.extent().min[i])), std::abs(double(bounds.extent().max[i])));
  ScreenBlock block{};
  const LinearForm* const forms[] = {&screen.x, &screen.y, &screen.w, &screen.t};
  for (std::size_t i = 0; i < std::size(forms); ++i) {
    const LinearForm& f = *forms[i];
    const float coefficients[3] = {f.x, f.y, f.z};
    // Denormals that GLSL may flush to zero, at most 2^-126 each: of coordinates (times a coefficient), coefficients
    // (times a coordinate), the constant, products and sums, of the value and of its band.
    double flushed = 16.0 + sizes;
    for (int axis = 0; axis < 3; ++axis) {
      const double size = std::abs(double(coefficients[axis]));
      block.along[axis].of_form[i] = coefficients[axis];
      block.band[axis].of_form[i] = core::round_up(kUnits * size);
      flushed += size;
    }
    block.constant.of_form[i] = f.d;
    block.band_constant.of_form[i] =
        core::round_up(double(f.error) + kUnits * std::abs(double(f.d)) + 0x1p-125 * flushed);
  }
  block.last[0] = screen.last_x;
  block.last[1] = screen.last_y;
  block.largest = screen.largest;
  block.sample_count = std::int32_t(samples.offsets.size());
  block.snap = screen.snap;
  for (std::size_t i = 0; i < samples.offsets.size(); ++i) {
    block.samples[i][0] = samples.offsets[i][0];
    block.samples[i][1] = samples.offsets[i][1];
  }
  return block;
}

}  // namespace sightline::culling
