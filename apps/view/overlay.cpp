#include "sightline/apps/view/overlay.h"

#include <cfloat>
#include <utility>

namespace sightline::apps {

Canvas Canvas::in_window(const Part& part, double scale) {
  return {*ImGui::GetBackgroundDrawList(),
          {float(part.x), ImGui::GetIO().DisplaySize.y - float(part.y + part.height)},
          {float(part.width), float(part.height)},
          ImGui::GetFont(),
          ImGui::GetFontSize(),
          float(scale)};
}

ImVec2 Canvas::text_size(const std::string& words) const {
  return font->CalcTextSizeA(font_pixels, FLT_MAX, 0.0f, words.c_str());
}

/// The font may have a texture of its own.
void Canvas::text(const ImVec2& at, const ImVec4& colour, const std::string& words) const {
  list.PushTextureID(font->ContainerAtlas->TexID);
  list.AddText(font, font_pixels, at, ImGui::ColorConvertFloat4ToU32(colour), words.c_str());
  list.PopTextureID();
}

Overlay::Overlay(const core::View& view, const Canvas& canvas)
    : clip_from_world_(view.clip_from_world()), canvas_(canvas) {
  canvas_.list.PushClipRect(canvas_.corner, canvas_.end());
}

Overlay::~Overlay() {
  canvas_.list.PopClipRect();
}

ImVec2 Overlay::pixels(const core::dvec4& clip) const {
  const core::dvec2 at = core::dvec2(clip.x, clip.y) / clip.w;
  return {float(canvas_.corner.x + 0.5 * (at.x + 1.0) * canvas_.size.x),
          float(canvas_.corner.y + 0.5 * (1.0 - at.y) * canvas_.size.y)};
}

std::optional<ImVec2> Overlay::at(const core::dvec3& point) const {
  const core::dvec4 clip = clip_from_world_ * core::dvec4(point, 1.0);
  return clip.w > 0.0 ? std::optional(pixels(clip)) : std::nullopt;
}

void Overlay::line(const core::dvec3& a, const core::dvec3& b, ImU32 colour, float pixels_wide) {
  constexpr double kNearest = 1e-3;  // of the larger distance: nearer to the eye, pixels would be beyond all numbers
  core::dvec4 from = clip_from_world_ * core::dvec4(a, 1.0), to = clip_from_world_ * core::dvec4(b, 1.0);
  if (from.w > to.w) std::swap(from, to);
  if (!(to.w > 0.0)) return;
  if (const double least = kNearest * to.w; from.w < least) from += (to - from) * ((least - from.w) / (to.w - from.w));
  canvas_.list.AddLine(pixels(from), pixels(to), colour, pixels_wide);
}

}  // namespace sightline::apps
