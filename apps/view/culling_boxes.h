// Lines over a picture that show, from elsewhere, what a frozen camera's culling does: the camera's view volume, and
// boxes by state. No window, no GL.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sightline/apps/view/frozen_camera.h"
#include "sightline/image/image.h"

namespace sightline::apps {

/// What is drawn.
struct CullingSwitches {
  bool boxes = true;  ///< false: nothing at all
  /// The picture has another colour for what is occluded or small, and boxes around all of that would hide it.
  std::array<bool, culling::kCullStateCount> states{true, true, true, false, false};
  friend bool operator==(const CullingSwitches&, const CullingSwitches&) = default;
};

/// In pixels from the picture's upper left corner.
struct CullingLine {
  enum Ink : std::uint8_t { kVolume = culling::kCullStateCount, kVolumeCut, kSection, kInkCount };
  core::dvec2 from, to;
  std::uint8_t ink;  ///< a CullState or an Ink
  bool behind;       ///< hidden by what the picture shows
};

class CullingBoxes {
 public:
  static constexpr std::size_t kMost = 2000;  ///< boxes; of more the largest are drawn

  /// Makes the lines anew. `depth`: of the picture of `view`. `bounds`: of the items, whose slots the states have.
  /// `reach`: where the view volume may end.
  void update(const core::View& view, const image::DepthImage& depth, const FrozenCamera& frozen,
              const core::ItemBounds& bounds, const core::AabbD& reach, const CullingSwitches& switches);
  void clear();

  const std::vector<CullingLine>& lines() const { return lines_; }
  std::size_t drawn() const { return drawn_; }    ///< boxes
  std::size_t wanted() const { return wanted_; }  ///< boxes in the picture of states that are switched on

 private:
  std::vector<CullingLine> lines_;
  std::size_t drawn_ = 0, wanted_ = 0;
};

}  // namespace sightline::apps
