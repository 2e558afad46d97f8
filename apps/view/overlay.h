// Points and lines of the model over the image, in pixels of the window.
#pragma once

#include <optional>

#include <imgui.h>

#include "sightline/apps/view/window.h"
#include "sightline/core/view.h"

namespace sightline::apps {

/// Draws below panels, menus and dialogs, and within the image.
class Overlay {
 public:
  /// `part`: where the image is. Until the destructor, drawing is clipped to it.
  Overlay(const core::View& view, const Part& part);
  ~Overlay();
  Overlay(const Overlay&) = delete;
  Overlay& operator=(const Overlay&) = delete;

  ImDrawList& list() { return list_; }
  /// None behind the eye.
  std::optional<ImVec2> at(const core::dvec3& point) const;
  /// The part of a line that lies before the eye.
  void line(const core::dvec3& a, const core::dvec3& b, ImU32 colour, float pixels);

 private:
  ImVec2 pixels(const core::dvec4& clip) const;

  core::dmat4 clip_from_world_;
  Part part_;
  double window_height_;
  ImDrawList& list_;
};

}  // namespace sightline::apps
