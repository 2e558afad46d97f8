// The scene of a moving image: one snapshot, or several, each with a tracer of its own, and boxes in place of items
// that are in none. Internal to raytrace and engine.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/image_rays.h"
#include "sightline/core/view.h"
#include "sightline/raytrace/internal/item_boxes.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::raytrace {

struct TracedPart {
  const Tracer* tracer;
  std::span<const std::uint64_t> without = {};  ///< as RayFilter has it
  std::atomic<std::uint32_t>* hits = nullptr;   ///< counts the pixels whose rays hit it; null: nobody asks
};

/// Boxes of groups of items, each of which is in one part, or in none and shows its box.
struct TracedBoxes {
  const ItemBoxes* boxes = nullptr;             ///< null: there are none, and one part has all items
  std::span<const std::uint32_t> part_of = {};  ///< by slot: in TracedScene::parts, or core::kNone
  std::span<const std::uint64_t> without = {};  ///< a bit for each slot that is in a part
  std::span<const std::uint32_t> colours = {};  ///< by slot: red in the lowest byte, then g, b
  std::uint32_t first_id = 0;                   ///< in an image slot i has the id first_id + i
};

/// Borrows everything.
struct TracedScene {
  std::span<const TracedPart> parts;
  TracedBoxes boxes = {};
};

/// A rectangle of pixels; rows are counted from the bottom up.
struct PixelRange {
  int left, bottom, right, top;  ///< the last column and row are not in it
};

/// A scene as the rays of an image meet it.
class SceneRays {
 public:
  static constexpr std::size_t kMostRays = 256;

  /// Both must outlive it. `height`: of the image.
  SceneRays(const TracedScene& scene, const core::View& view, const core::ImageRays& rays, int height);

  /// A hit, and the snapshot that it is in: null where it is a box, or where the slot says that there is none.
  struct PartHit {
    Hit hit;
    const core::Snapshot* snapshot = nullptr;
  };
  /// Replaces `hits` by those of rays through some pixels, at most kMostRays.
  void nearest(std::span<const core::Ray> rays, const PixelRange& pixels, std::span<PartHit> hits) const;
  /// Replaces a hit by the first one for which shows(hit) is true, or a box before it.
  template <class Shows>
  void first_that(const core::Ray& ray, PartHit& hit, const Shows& shows) const {
    hit = {};
    std::vector<Hit> all;
    for (const std::uint32_t part : parts_along(ray)) {
      const Tracer& tracer = *scene_.parts[part].tracer;
      if (!tracer.all(ray, all, filters_[part])) continue;
      for (const Hit& one : all) {
        if (hit.snapshot && one.t >= hit.hit.t) break;
        if (shows(PartHit{one, &tracer.snapshot()})) hit = {one, &tracer.snapshot()};
      }
    }
    enter_boxes({&ray, 1}, {&hit, 1});
  }
  const TracedBoxes& boxes() const { return scene_.boxes; }
  bool all_opaque() const { return all_opaque_; }  ///< whether no material of the parts lets anything through

 private:
  Beam beam_of(const PixelRange& pixels) const;
  void enter_boxes(std::span<const core::Ray> rays, std::span<PartHit> hits) const;
  void nearest_alone(std::span<const core::Ray> rays, std::span<PartHit> hits) const;
  void nearest_of(std::uint32_t part, std::span<const core::Ray> rays, std::span<PartHit> hits) const;
  std::vector<std::uint32_t> parts_along(const core::Ray& ray) const;
  void nearer_of(std::uint32_t part, double first, std::span<const core::Ray> rays, std::span<PartHit> hits) const;

  const TracedScene& scene_;
  const core::ImageRays& rays_;
  int height_;
  std::vector<RayFilter> filters_;  // by part
  RayFilter box_filter_;
  bool all_opaque_ = true;
};

}  // namespace sightline::raytrace
