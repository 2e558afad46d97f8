// Draws a frozen camera's culling over the image.
#pragma once

#include <optional>

#include <imgui.h>

#include "sightline/apps/view/culling_boxes.h"

namespace sightline::apps {

class Session;
struct Part;

class CullingOverlay {
 public:
  CullingSwitches switches;

  /// After the image was drawn, whose part of the window this is. Costs nothing unless the camera is frozen.
  void draw(Session& session, const Part& part);
  const CullingBoxes& boxes() const { return boxes_; }
  /// The colour of a state's boxes: M. Okabe, K. Ito, "Color universal design", 2008.
  static ImVec4 colour(culling::CullState state);

 private:
  struct Made {
    std::uint64_t frame, version;
    CullingSwitches switches;
    friend bool operator==(const Made&, const Made&) = default;
  };
  CullingBoxes boxes_;
  std::optional<Made> made_;  // what the lines are of
};

}  // namespace sightline::apps
