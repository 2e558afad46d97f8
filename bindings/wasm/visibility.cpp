#include "sightline/bindings/wasm/visibility.h"

#include "sightline/core/internal/scratch.h"
#include "sightline/culling/occlusion/contribution.h"
#include "sightline/culling/occlusion/occlusion_test.h"

namespace sightline::wasm {
namespace {

struct Leaves {
  core::VisibleSet set;
  std::size_t memory_bytes() const { return core::bytes_of(set); }
};

}  // namespace

void find_visible(const core::ItemBounds& bounds, const culling::CpuCuller& culler, const ViewObject& view,
                  const Limits& limits, core::ThreadPool* threads, core::VisibleSet& set) {
  culler.cull(view.view, set);
  if (limits.pyramid != nullptr && limits.pyramid->level_count() > 0) {
    const culling::OcclusionTest test(view.view, bounds.origin, limits.pyramid->width(), limits.pyramid->height(),
                                      *limits.pyramid);
    test.filter(bounds, set, set, {}, threads, &culler.hierarchy());
  }
  if (limits.least_area > 0.0f) {
    const culling::ContributionTest test(view.view, bounds.origin, view.width, view.height);
    const core::Scratch<Leaves> scratch;
    test.filter_leaves(culler.hierarchy(), set, limits.least_area, scratch->set);
    test.filter(bounds, scratch->set, limits.least_area, set);
  }
}

}  // namespace sightline::wasm
