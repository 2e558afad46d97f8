// Points, lines and words over an image of the model.
#pragma once

#include <optional>
#include <span>
#include <string>

#include <imgui.h>

#include "sightline/analysis/query/colouring.h"
#include "sightline/apps/common/label_placement.h"
#include "sightline/apps/common/numbers.h"
#include "sightline/apps/view/window.h"
#include "sightline/apps/viewpoints/viewpoint.h"
#include "sightline/core/view.h"

namespace sightline::apps {

inline const ImVec4 kShade{0.0f, 0.0f, 0.0f, 0.75f}, kWhite{1.0f, 1.0f, 1.0f, 1.0f};  // of labels

/// Where an image lies in a list of what is drawn, and how large text and lines on it are.
struct Canvas {
  ImDrawList& list;
  ImVec2 corner, size;  ///< pixels; the upper left corner
  ImFont* font;         ///< of text
  float font_pixels;    ///< its height
  float scale;          ///< of lines: 1 on a screen of usual density

  /// Below panels, menus and dialogs.
  static Canvas in_window(const Part& part, double scale = 1.0);
  ImVec2 end() const { return {corner.x + size.x, corner.y + size.y}; }
  ImVec2 text_size(const std::string& words) const;
  void text(const ImVec2& at, const ImVec4& colour, const std::string& words) const;
};

/// Places of the world on a canvas. Until the destructor, drawing is clipped to the image.
class Overlay {
 public:
  Overlay(const core::View& view, const Canvas& canvas);
  Overlay(const core::View& view, const Part& part) : Overlay(view, Canvas::in_window(part)) {}
  ~Overlay();
  Overlay(const Overlay&) = delete;
  Overlay& operator=(const Overlay&) = delete;

  const Canvas& canvas() const { return canvas_; }
  ImDrawList& list() { return canvas_.list; }
  /// None behind the eye.
  std::optional<ImVec2> at(const core::dvec3& point) const;
  /// The part of a line that lies before the eye.
  void line(const core::dvec3& a, const core::dvec3& b, ImU32 colour, float pixels);

 private:
  ImVec2 pixels(const core::dvec4& clip) const;

  core::dmat4 clip_from_world_;
  Canvas canvas_;
};

/// Room for labels on an image.
LabelPlacement labels_on(const Canvas& canvas);

void draw_measurements(Overlay& overlay, std::span<const Measurement> list, const LengthFormat& lengths,
                       LabelPlacement& labels);
/// The colours' meaning, in the upper left corner; nothing without groups.
void draw_legend(const Canvas& canvas, const query::Colouring& colouring);
/// `view`: that of the overlay.
void draw_markups(Overlay& overlay, const core::View& view, std::span<const Markup> markups);

}  // namespace sightline::apps
