// A frame, as drawing takes it, and what drawing tells of it. Internal to engine.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/hierarchy.h"
#include "sightline/culling/occlusion/sample_test.h"
#include "sightline/gl/external_target.h"

namespace sightline::raytrace {
class Tracer;
}

namespace sightline::engine {

/// A frame of one view: made once, and handed down as it is. Borrows everything.
struct Frame {
  const core::View& view;       ///< that the image shows
  const core::View& cull_view;  ///< that was culled for
  const core::Snapshot& snapshot;
  culling::SlotBits lines = {};  ///< slots that the contribution and occlusion tests keep always
  /// Hierarchy of the snapshot's bounds, or null. It makes tests of large sets fast.
  const culling::Hierarchy* hierarchy = nullptr;
  std::uint64_t number = 0;   ///< what is known of the frame later comes back with it
  double budget_began = 0.0;  ///< when the frame's budget began to run, seconds on the steady clock
  bool all = true;            ///< all visible items of `cull_view` are drawn
  bool overlaid = false;      ///< some items are drawn over the image, so that nothing more can be drawn to it
  /// Items that the image of `cull_view` would not show are drawn, in DrawingConfig::culled_colour.
  bool shows_unseen = false;
  const gl::ExternalTarget* target = nullptr;  ///< gets the image, too, and has its size
  bool at_rest = false;                        ///< as FrameInput has it
  std::optional<glm::vec2> blend_range = {};   ///< eye depths by which blended items are weighed
  /// Where the image reaches in that of which it is a part: 0 at its upper border, 1 at its lower.
  std::array<double, 2> rows{0.0, 1.0};
  const raytrace::Tracer* tracer = nullptr;  ///< of the snapshot, where moving images are to be traced; or null

  /// Whether the view is not the one that was culled for.
  bool aside() const { return !core::same_image(view, cull_view); }
};

/// Visible items that an image leaves out: a bit per slot, or no words where nothing is left out.
struct LeftOut {
  std::vector<std::uint64_t> small, occluded;
};

/// Number of items by what a frame did with them.
struct DrawCounts {
  std::int64_t sampled = 0, items_drawn = 0;  // items that may cover a sample, -1 with the occlusion test; items drawn
  std::int64_t below_min_area = 0;            // items below the minimum projected area that is asked for
  std::int64_t pending = 0;                   // items for which the budget did not suffice
  std::int64_t splats = 0;                    // of these and pending ones, items drawn as one splat each
  std::int64_t triangles = 0;                 // of meshes
  double coarseness = 1.0;                    // pixels of the image along either axis for one that is drawn
  double earlier = 0.0;                       // share of the pixels whose points earlier images have found
};

}  // namespace sightline::engine
