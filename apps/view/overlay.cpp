#include "sightline/apps/view/overlay.h"

#include <utility>

namespace sightline::apps {

Overlay::Overlay(const core::View& view, const Part& part)
    : clip_from_world_(view.clip_from_world()),
      part_(part),
      window_height_(double(ImGui::GetIO().DisplaySize.y)),
      list_(*ImGui::GetBackgroundDrawList()) {
  const float top = float(window_height_ - part.y - part.height);
  list_.PushClipRect({float(part.x), top}, {float(part.x + part.width), top + float(part.height)});
}

Overlay::~Overlay() {
  list_.PopClipRect();
}

ImVec2 Overlay::pixels(const core::dvec4& clip) const {
  const core::dvec2 at = core::dvec2(clip.x, clip.y) / clip.w;
  return {float(part_.x + 0.5 * (at.x + 1.0) * part_.width),
          float(window_height_ - part_.y - 0.5 * (at.y + 1.0) * part_.height)};
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
  list_.AddLine(pixels(from), pixels(to), colour, pixels_wide);
}

}  // namespace sightline::apps
