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
  float coordinates[6][kLanes] = {};
  const float* arrays[6];
  for (int axis = 0; axis < 6; ++axis) {
    coordinates[axis][0] = axis < 3 ? box.min[axis] : box.max[axis - 3];
    arrays[axis] = coordinates[axis];
  }
  return (kernels().covering(view(), arrays) & 1u) != 0;
}

void SampleTest::filter(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& out,
                        SlotBits exempt) const {
  const Kernels& kernel = kernels();
  const ScreenView screen = view();
  thread_local SlotCollector kept;
  for_each_group(bounds, in, [&](const SlotGroup& group, unsigned used, bool of_range) {
    unsigned bits = kernel.covering(screen, group.coordinates);
    if (!exempt.empty()) bits |= bits_of(exempt, group);
    kept.add(group, bits & used, of_range);
  });
  kept.finish(out);
  out.generation = in.generation;
  out.counters = in.counters;
}

}  // namespace sightline::culling
