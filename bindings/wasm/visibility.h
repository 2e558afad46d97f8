// Finds what a view shows of boxes, of an application or of a scene's items: by the view volume, then by occlusion,
// then by size, each only where it is asked for.
#pragma once

#include "sightline/bindings/wasm/views.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/occlusion/depth_pyramid.h"

namespace sightline::wasm {

struct Limits {
  const culling::DepthPyramid* pyramid = nullptr;  ///< of the same view and its size, or null
  float least_area = 0.0f;                         ///< pixels that an item must be expected to cover; 0: any
};

/// Replaces `set`. `threads` may be null.
void find_visible(const core::ItemBounds& bounds, const culling::CpuCuller& culler, const ViewObject& view,
                  const Limits& limits, core::ThreadPool* threads, core::VisibleSet& set);

}  // namespace sightline::wasm
