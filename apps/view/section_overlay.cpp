// Draws the handles of sections over the image.
#include <imgui.h>

#include "sightline/apps/view/overlay.h"
#include "sightline/apps/view/panels.h"

namespace sightline::apps {
namespace {

constexpr float kLinePixels = 2.5f, kRimPixels = 1.5f;
const ImVec4 kColour{1.0f, 0.62f, 0.1f, 1.0f}, kAimed{1.0f, 0.95f, 0.55f, 1.0f}, kRim{0.05f, 0.05f, 0.05f, 0.9f};
const ImVec4 kArea{1.0f, 0.62f, 0.1f, 0.14f}, kShade{0.0f, 0.0f, 0.0f, 0.75f}, kWhite{1.0f, 1.0f, 1.0f, 1.0f};

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
  const auto sides = session.sections().box();
  const auto view = session.view();
  if (!sides || !view) return;
  const std::array<core::dvec3, 8> corners = box_corners(session.sections(), *sides);
  Overlay overlay(*view, part);
  for (const bool rim : {true, false})
    for (std::size_t corner = 0; corner < corners.size(); ++corner)
      for (std::size_t axis = 1; axis < corners.size(); axis *= 2)
        if ((corner & axis) == 0)
          overlay.line(corners[corner], corners[corner | axis], ImGui::GetColorU32(rim ? kRim : kColour),
                       rim ? 3.5f : 1.5f);
}

}  // namespace

void section_overlay(Viewer& viewer, const apps::Part& part) {
  if (!viewer.shows_section_handles()) return;
  box_edges(*viewer.session(), part);
  const core::dvec2 corner(part.x, double(ImGui::GetIO().DisplaySize.y) - part.y - part.height);
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.PushClipRect({float(corner.x), float(corner.y)}, {float(corner.x + part.width), float(corner.y + part.height)});
  const auto target = viewer.section_target();
  for (const SectionHandles::Shown& one : SectionHandles::shown(*viewer.session(), viewer.gui().scale())) {
    const bool aimed = target && target->section == one.section;
    Pen(list, one.gizmo, corner, aimed ? std::optional(target->part) : std::nullopt).draw();
    if (!aimed || !viewer.section_handles().dragging()) continue;
    const std::string words = viewer.section_handles().words(viewer.lengths());
    const ImVec2 size = ImGui::CalcTextSize(words.c_str());
    const core::dvec2 beside = one.gizmo.middle() + corner + core::dvec2(1.5, 1.0) * double(ImGui::GetFontSize());
    const ImVec2 at(std::min(float(beside.x), float(corner.x + part.width) - size.x - 6.0f), float(beside.y));
    list.AddRectFilled({at.x - 4.0f, at.y - 3.0f}, {at.x + size.x + 4.0f, at.y + size.y + 3.0f},
                       ImGui::GetColorU32(kShade), 3.0f);
    list.AddText(at, ImGui::GetColorU32(kWhite), words.c_str());
  }
  list.PopClipRect();
}

}  // namespace sightline::apps
