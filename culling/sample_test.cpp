#include "sightline/culling/sample_test.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "sightline/culling/internal/filter_slots.h"
#include "sightline/culling/internal/kernels.h"

namespace sightline::culling {
namespace {

LinearForm form_of(const core::dvec4& row, const core::dvec3& origin) {
  const core::dvec3 products = core::dvec3(row) * origin;
  const double d = products.x + products.y + products.z + row.w;
  const core::dvec3 sizes = glm::abs(products);
  const double lost = 0x1p-50 * (sizes.x + sizes.y + sizes.z + std::abs(row.w));
  return {float(row.x), float(row.y), float(row.z), float(d), float(lost)};
}

/// -1, which no coordinate's size is below, where the forms are not finite.
float largest_coordinate(std::initializer_list<LinearForm> forms) {
  constexpr float kMost = 1e36f;
  float greatest = 1.0f;
  for (const LinearForm& f : forms) {
    for (const float c : {f.x, f.y, f.z}) greatest = std::max(greatest, std::abs(c));
    if (!(std::abs(f.x) + std::abs(f.y) + std::abs(f.z) + std::abs(f.d) + f.error < kMost)) return -1.0f;
  }
  return kMost / greatest;
}

}  // namespace

ScreenView make_screen_view(const core::View& view, const core::dvec3& origin, int width, int height) {
  const core::dmat4 clip = glm::transpose(view.clip_from_world()), eye = glm::transpose(view.eye_from_world());
  // Pixel centres at integers: 0.5 size (ndc + 1) - 0.5.
  const auto place = [&](int axis, int size) { return 0.5 * size * clip[axis] + (0.5 * size - 0.5) * clip[3]; };
  ScreenView screen{};
  screen.x = form_of(place(0, width), origin);
  screen.y = form_of(place(1, height), origin);
  screen.w = form_of(clip[3], origin);
  screen.t = form_of(-eye[2], origin);
  screen.last_x = float(width - 1);
  screen.last_y = float(height - 1);
  screen.largest = largest_coordinate({screen.x, screen.y, screen.w, screen.t});
  return screen;
}

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
