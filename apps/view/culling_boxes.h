// Lines over an image that show, from elsewhere, what a frozen camera's culling does: the camera's view volume, and
// boxes by state. No window, no GL.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sightline/apps/view/frozen_camera.h"
#include "sightline/culling/occlusion/contribution.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {

/// What is drawn.
struct CullingSwitches {
  bool boxes = true;  ///< false: nothing at all
  /// The image has another colour for what is occluded or small, and boxes around all of that would hide it.
  std::array<bool, culling::kCullStateCount> states{true, true, true, false, false};
  friend bool operator==(const CullingSwitches&, const CullingSwitches&) = default;
};

/// In pixels from the image's upper left corner.
struct CullingLine {
  enum Ink : std::uint8_t { kVolume = culling::kCullStateCount, kVolumeCut, kSection, kInkCount };
  core::dvec2 from, to;
  std::uint8_t ink;  ///< a CullState or an Ink
  bool behind;       ///< hidden by what the image shows
};

class CullingBoxes {
 public:
  static constexpr std::size_t kMost = 2000;  ///< boxes; of more the largest are drawn

  /// Makes the lines anew. `depth`: of the image of `view`. `origin`: of the boxes. `reach`: where the view volume
  /// may end.
  void update(const core::View& view, const image::DepthImage& depth, const FrozenCamera& frozen,
              const core::dvec3& origin, const core::AabbD& reach, const CullingSwitches& switches);
  void clear();

  const std::vector<CullingLine>& lines() const { return lines_; }
  std::size_t drawn() const { return drawn_; }    ///< boxes
  std::size_t wanted() const { return wanted_; }  ///< boxes in the image of states that are switched on

 private:
  using SlotArea = culling::ContributionTest::SlotArea;
  std::vector<SlotArea> in_image(const core::View& view, const image::DepthImage& depth,
                                 const culling::CullStates& states, const CullingSwitches& switches) const;

  core::ItemBounds boxes_;     // those of the states, so that a culler finds and measures what an image shows
  std::uint64_t version_ = 0;  // of the camera that these are of
  std::vector<CullingLine> lines_;
  std::size_t drawn_ = 0, wanted_ = 0;
};

}  // namespace sightline::apps
