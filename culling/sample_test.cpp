#include "sightline/culling/sample_test.h"

#include <cassert>
#include <utility>

#include "sightline/culling/internal/filter_slots.h"
#include "sightline/culling/internal/kernels.h"

namespace sightline::culling {

SampleTest::SampleTest(const core::View& view, const core::dvec3& origin, PictureSamples samples)
    : samples_(std::move(samples)), view_(make_screen_view(view, origin, samples_.width, samples_.height)) {
  assert(samples_.width > 0 && samples_.height > 0 && !samples_.offsets.empty());
}

ScreenView SampleTest::view() const {
  static_assert(sizeof(samples_.offsets[0]) == sizeof(float[2]));
  ScreenView view = view_;
  view.samples = reinterpret_cast<const float(*)[2]>(samples_.offsets.data());
  view.sample_count = int(samples_.offsets.size());
  return view;
}

bool SampleTest::covers(const core::Aabb& box) const {
  return of_one_box(box, [&](const auto& boxes) { return kernels().covering(view(), boxes); });
}

void SampleTest::filter(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& out,
                        SlotBits exempt) const {
  const auto covering = kernels().covering;
  const ScreenView screen = view();
  filter_slots(bounds, in, out, exempt, [&](const auto& boxes) { return covering(screen, boxes); });
}

}  // namespace sightline::culling
