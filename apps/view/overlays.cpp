#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>

#include "sightline/apps/common/label_placement.h"
#include "sightline/apps/view/overlay.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"
#include "sightline/apps/view/window.h"
#include "sightline/core/view.h"

namespace sightline::apps {
namespace {

constexpr float kMarkRadius = 5.0f, kPadding = 3.0f, kWide = 2.0f;  // pixels of a screen of usual density

constexpr float kLinePixels = 2.5f, kRimPixels = 1.5f;
const ImVec4 kColour{1.0f, 0.62f, 0.1f, 1.0f}, kAimed{1.0f, 0.95f, 0.55f, 1.0f}, kRim{0.05f, 0.05f, 0.05f, 0.9f};
const ImVec4 kMarkColour{0.95f, 0.45f, 0.05f, 1.0f}, kArea{1.0f, 0.62f, 0.1f, 0.14f};

/// Draws one section's handles. Every part has a dark rim, so that it shows on any image.
class Pen {
 public:
  Pen(ImDrawList& list, const SectionGizmo& gizmo, const core::dvec2& corner, std::optional<SectionGizmo::Part> aimed)
      : list_(list), gizmo_(gizmo), corner_(corner), aimed_(aimed), scale_(float(gizmo.scale())) {}

  void draw() {
    if (gizmo_.whole()) square();
    const auto is_arrow = [](SectionGizmo::Part part) {
      return part == SectionGizmo::Part::kOut || part == SectionGizmo::Part::kIn;
    };
    for (const SectionGizmo::Handle& handle : gizmo_.handles())
      if (is_arrow(handle.part)) arrow(handle);
    for (const SectionGizmo::Handle& handle : gizmo_.handles())
      if (!is_arrow(handle.part)) disc(handle);
  }

 private:
  ImVec2 pixels(const core::dvec2& at) const { return {float(at.x + corner_.x), float(at.y + corner_.y)}; }
  ImU32 colour_of(SectionGizmo::Part part) const { return ImGui::GetColorU32(aimed_ == part ? kAimed : kColour); }

  void square() {
    std::array<ImVec2, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = pixels(gizmo_.outline()[i]);
    list_.AddConvexPolyFilled(corners.data(), 4, ImGui::GetColorU32(kArea));
    list_.AddPolyline(corners.data(), 4, rim_, ImDrawFlags_Closed, (1.5f + 2.0f * kRimPixels) * scale_);
    list_.AddPolyline(corners.data(), 4, ImGui::GetColorU32(kColour), ImDrawFlags_Closed, 1.5f * scale_);
  }

  void arrow(const SectionGizmo::Handle& handle) {
    const core::dvec2 along = glm::normalize(handle.at - gizmo_.middle()), aside(-along.y, along.x);
    const double radius = gizmo_.radius(handle.part), rim = double(kRimPixels * scale_);
    const auto head = [&](double grown, ImU32 colour) {
      const core::dvec2 tip = handle.at + (radius + 1.8 * grown) * along, foot = handle.at - (radius + grown) * along;
      const double half = 0.75 * radius + 1.5 * grown;
      list_.AddTriangleFilled(pixels(tip), pixels(foot - half * aside), pixels(foot + half * aside), colour);
    };
    const ImVec2 from = pixels(gizmo_.middle()), to = pixels(handle.at);
    list_.AddLine(from, to, rim_, (kLinePixels + 2.0f * kRimPixels) * scale_);
    head(rim, rim_);
    list_.AddLine(from, to, colour_of(handle.part), kLinePixels * scale_);
    head(0.0, colour_of(handle.part));
  }

  void disc(const SectionGizmo::Handle& handle) {
    const float radius = float(gizmo_.radius(handle.part));
    list_.AddCircleFilled(pixels(handle.at), radius + kRimPixels * scale_, rim_);
    list_.AddCircleFilled(pixels(handle.at), radius, colour_of(handle.part));
    if (handle.part == SectionGizmo::Part::kMiddle && gizmo_.whole())
      list_.AddCircleFilled(pixels(handle.at), 0.4f * radius, rim_);  // a click flips
  }

  ImDrawList& list_;
  const SectionGizmo& gizmo_;
  core::dvec2 corner_;
  std::optional<SectionGizmo::Part> aimed_;
  float scale_;
  ImU32 rim_ = ImGui::GetColorU32(kRim);
};

void box_edges(const Session& session, const Part& part) {
  const auto sides = session.sections.box();
  const auto view = session.image.view();
  if (!sides || !view) return;
  const std::array<core::dvec3, 8> corners = box_corners(session.sections, *sides);
  Overlay overlay(*view, part);
  for (const bool rim : {true, false})
    for (std::size_t corner = 0; corner < corners.size(); ++corner)
      for (std::size_t axis = 1; axis < corners.size(); axis *= 2)
        if ((corner & axis) == 0)
          overlay.line(corners[corner], corners[corner | axis], ImGui::GetColorU32(rim ? kRim : kColour),
                       rim ? 3.5f : 1.5f);
}

/// Words on a dark ground, where they cover nothing.
void label(Overlay& overlay, const ImVec2& at, const std::string& words, LabelPlacement& labels) {
  const Canvas& canvas = overlay.canvas();
  const float padding = kPadding * canvas.scale;
  const ImVec2 size = canvas.text_size(words);
  const Rectangle place =
      labels.place(double(at.x), double(at.y), double(size.x + 2.0f * padding), double(size.y + 2.0f * padding));
  const ImVec2 from(float(place.left), float(place.top)), to(float(place.right), float(place.bottom));
  overlay.list().AddRectFilled(from, to, ImGui::ColorConvertFloat4ToU32(kShade));
  canvas.text({from.x + padding, from.y + padding}, kWhite, words);
}

constexpr float kGripLines = 0.5f, kMarginLines = 0.5f, kLineLines = 0.2f;  // in lines of text

/// Which revision it is, in the upper corner of its half, and not beyond that.
void name(ImDrawList& list, const char* which, const std::string& file, const std::pair<float, float>& half, float top,
          bool at_end) {
  const auto [begin, end] = half;
  const float font = ImGui::GetFontSize(), margin = kMarginLines * font, padding = 0.3f * font;
  const float room = end - begin - 2.0f * margin - ImGui::CalcTextSize(which).x;
  const std::string text = which + shortened(file, std::max(0.0f, room));
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  const float x = at_end ? std::max(begin + margin, end - margin - size.x) : begin + margin, y = top + margin;
  list.PushClipRect({begin, top}, {end, y + size.y + margin}, true);
  list.AddRectFilled({x - padding, y - padding}, {x + size.x + padding, y + size.y + padding},
                     ImGui::GetColorU32(kShade), padding);
  list.AddText({x, y}, ImGui::GetColorU32(kWhite), text.c_str());
  list.PopClipRect();
}

constexpr const char* kLetters[] = {"X", "Y", "Z"};
constexpr float kLetterPixels = 14.0f, kAxisPixels = 2.5f, kFarther = 0.85f;
constexpr core::vec3 kColours[] = {{0.93f, 0.33f, 0.28f}, {0.45f, 0.75f, 0.2f}, {0.35f, 0.6f, 1.0f}};

ImVec2 pixels(const core::dvec2& at) {
  return {float(at.x), float(at.y)};
}

ImU32 colour_of(const AxisTriad::End& end, float brightness, float alpha) {
  const core::vec3 c = kColours[end.axis] * brightness;
  return ImGui::GetColorU32({c.r, c.g, c.b, alpha});
}

}  // namespace

LabelPlacement labels_on(const Canvas& canvas) {
  return LabelPlacement(
      {double(canvas.corner.x), double(canvas.corner.y), double(canvas.end().x), double(canvas.end().y)});
}

void draw_measurements(Overlay& overlay, std::span<const Measurement> list, const LengthFormat& lengths,
                       LabelPlacement& labels) {
  for (const Measurement& one : list) {
    const auto from = overlay.at(one.from), to = overlay.at(one.to);
    overlay.line(one.from, one.to, ImGui::ColorConvertFloat4ToU32(kMarkColour), kWide * overlay.canvas().scale);
    if (from && to)
      label(overlay, {0.5f * (from->x + to->x), 0.5f * (from->y + to->y)}, lengths.text(one.distance()), labels);
  }
}

void measure_overlay(Workspace& work, const Part& part) {
  Session* session = work.session.get();
  if (!session || (work.shown.tool != Tool::kMeasure && session->measuring.list().empty())) return;
  const auto view = session->image.view();
  if (!view) return;
  Overlay overlay(*view, Canvas::in_window(part, work.gui.scale()));
  const float scale = overlay.canvas().scale, radius = scale * kMarkRadius;
  const ImU32 colour = ImGui::ColorConvertFloat4ToU32(kMarkColour);
  LabelPlacement labels = labels_on(overlay.canvas());  // not over the panels
  const auto mark = [&](const ImVec2& at) {
    labels.add_mark({double(at.x - radius), double(at.y - radius), double(at.x + radius), double(at.y + radius)});
  };
  for (const Measuring::Mark& one : session->measuring.marks())
    if (const auto at = overlay.at(one.snap.point)) {
      overlay.list().AddCircle(*at, radius, colour, 0, scale * kWide);
      mark(*at);
    }
  const auto aimed = work.shown.tool == Tool::kMeasure && work.gestures.aimed()
                         ? overlay.at(work.gestures.aimed()->point)
                         : std::optional<ImVec2>();
  if (aimed) {
    overlay.list().AddCircleFilled(*aimed, radius, colour);
    mark(*aimed);
  }
  draw_measurements(overlay, session->measuring.list(), work.lengths(), labels);
  if (aimed) label(overlay, *aimed, work.gestures.aimed()->words, labels);
}

void rectangle_overlay(const Workspace& work) {
  const auto& drag = work.gestures.drag();
  if (!drag || !drag->moves || drag->button != GLFW_MOUSE_BUTTON_LEFT || (drag->mods & GLFW_MOD_CONTROL) == 0) return;
  const ImVec2 a(float(drag->from.x), float(drag->from.y)), b(float(drag->last.x), float(drag->last.y));
  ImGui::GetForegroundDrawList()->AddRect(a, b, ImGui::GetColorU32({1.0f, 0.6f, 0.1f, 1.0f}), 0.0f, 0, 2.0f);
}

void section_overlay(Workspace& work, const Part& part) {
  if (!work.gestures.shows_section_handles()) return;
  box_edges(*work.session, part);
  const core::dvec2 corner(part.x, double(ImGui::GetIO().DisplaySize.y) - part.y - part.height);
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.PushClipRect({float(corner.x), float(corner.y)}, {float(corner.x + part.width), float(corner.y + part.height)});
  const auto target = work.gestures.section_target();
  for (const SectionHandles::Shown& one : SectionHandles::shown(*work.session, work.gui.scale())) {
    const bool aimed = target && target->section == one.section;
    Pen(list, one.gizmo, corner, aimed ? std::optional(target->part) : std::nullopt).draw();
    if (!aimed || !work.gestures.section_handles().dragging()) continue;
    const std::string words = work.gestures.section_handles().words(work.lengths());
    const ImVec2 size = ImGui::CalcTextSize(words.c_str());
    const core::dvec2 beside = one.gizmo.middle() + corner + core::dvec2(1.5, 1.0) * double(ImGui::GetFontSize());
    const ImVec2 at(std::min(float(beside.x), float(corner.x + part.width) - size.x - 6.0f), float(beside.y));
    list.AddRectFilled({at.x - 4.0f, at.y - 3.0f}, {at.x + size.x + 4.0f, at.y + size.y + 3.0f},
                       ImGui::GetColorU32(kShade), 3.0f);
    list.AddText(at, ImGui::GetColorU32(kWhite), words.c_str());
  }
  list.PopClipRect();
}

void slider_overlay(Workspace& work, const Part& part) {
  const Session* session = work.session.get();
  if (!session || !session->slider.at()) return;
  const auto view = session->image.view();
  if (!view) return;
  Overlay overlay(*view, part);
  ImDrawList& list = overlay.list();
  const int drawn = session->image.drawn_size()[0];
  const float font = ImGui::GetFontSize(), left = float(part.x), right = float(part.x + part.width),
              top = ImGui::GetIO().DisplaySize.y - float(part.y + part.height),
              x = left + float(session->slider.parts(drawn).front().end) / float(drawn) * float(part.width),
              middle = top + 0.5f * float(part.height), grip = kGripLines * font;
  const bool held = work.gestures.over_slider();
  const ImU32 shade = ImGui::GetColorU32({0, 0, 0, 0.6f}),
              colour = held ? ImGui::GetColorU32({1.0f, 0.6f, 0.1f, 1.0f}) : ImGui::GetColorU32(kWhite);
  const float wide = std::max(1.0f, kLineLines * font);
  list.AddLine({x, top}, {x, top + float(part.height)}, shade, wide + 2.0f);
  list.AddLine({x, top}, {x, top + float(part.height)}, colour, wide);
  for (const float side : {-1.0f, 1.0f}) {  // arrows to both sides
    const ImVec2 a(x + side * 0.6f * grip, middle - grip), b(x + side * 0.6f * grip, middle + grip),
        tip(x + side * 1.8f * grip, middle);
    list.AddTriangleFilled(a, b, tip, colour);
    list.AddTriangle(a, b, tip, shade);
  }
  if (held) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  const auto [older, newer] = names_apart(session->changes()->file(), work.files());
  name(list, "older: ", older, {left, x}, top, false);
  name(list, "newer: ", newer, {x, right}, top, true);
}

void triad_overlay(Workspace& work) {
  const auto triad = work.gestures.triad();
  if (!triad) return;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float scale = float(triad->scale()), radius = float(triad->end_radius());
  const bool dark = !work.shown.light;
  const ImU32 ink = ImGui::GetColorU32({0.04f, 0.04f, 0.04f, 1.0f});
  const ImU32 ground = ImGui::GetColorU32(dark ? ImVec4{0.1f, 0.1f, 0.11f, 0.6f} : ImVec4{1.0f, 1.0f, 1.0f, 0.65f});
  list.AddCircleFilled(pixels(triad->centre()), float(AxisTriad::reach(triad->scale())), ground);
  const auto aimed = work.gestures.triad_end();
  for (const AxisTriad::End& end : triad->ends()) {
    const ImVec2 at = pixels(end.at);
    const float brightness = end.depth < 0.0 ? kFarther : 1.0f;
    if (end.positive) {
      list.AddLine(pixels(triad->centre()), at, colour_of(end, brightness, 1.0f), kAxisPixels * scale);
      list.AddCircleFilled(at, radius, colour_of(end, brightness, 1.0f));
      const float size = kLetterPixels * scale;
      const ImVec2 text = ImGui::GetFont()->CalcTextSizeA(size, FLT_MAX, 0.0f, kLetters[end.axis]);
      list.AddText(ImGui::GetFont(), size, {at.x - 0.5f * text.x, at.y - 0.5f * text.y}, ink, kLetters[end.axis]);
    } else {
      list.AddCircleFilled(at, 0.75f * radius, colour_of(end, 0.5f * brightness, 0.8f));
      list.AddCircle(at, 0.75f * radius, colour_of(end, brightness, 1.0f), 0, 1.5f * scale);
    }
    if (aimed && aimed->axis == end.axis && aimed->positive == end.positive)
      list.AddCircle(at, radius + scale, ImGui::GetColorU32(ImGuiCol_Text), 0, 2.0f * scale);
  }
}

}  // namespace sightline::apps
