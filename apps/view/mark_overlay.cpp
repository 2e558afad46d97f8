// Mark-ups over the image: red lines, and words on white, so that they show on any model.
#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include <imgui.h>

#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/marking.h"
#include "sightline/apps/view/overlay.h"
#include "sightline/apps/view/panels.h"

namespace sightline::apps {
namespace {

constexpr float kStrokePixels = 2.5f, kPaperPixels = 1.0f, kWordsPadding = 4.0f;
const ImVec4 kInk{0.85f, 0.07f, 0.12f, 1.0f}, kPaper{1.0f, 1.0f, 1.0f, 0.92f};

void draw_lines(Overlay& overlay, const Markup& markup, const core::dvec3& ahead) {
  const float scale = overlay.canvas().scale;
  const auto all = strokes(markup, ahead);
  for (const bool rim : {true, false})
    for (const auto& stroke : all)
      for (std::size_t i = 1; i < stroke.size(); ++i)
        overlay.line(stroke[i - 1], stroke[i], ImGui::ColorConvertFloat4ToU32(rim ? kPaper : kInk),
                     (kStrokePixels + (rim ? 2.0f * kPaperPixels : 0.0f)) * scale);
}

/// Where a label of a size begins whose middle is at a place; whole where that is in the image.
float begin_of(float middle, float size, float low, float high) {
  const float begin = middle - 0.5f * size;
  return middle < low || middle > high ? begin : std::max(low, std::min(begin, high - size));
}

void draw_words(Overlay& overlay, const Markup& markup) {
  const auto middle = overlay.at(words_place(markup));
  if (markup.words.empty() || !middle) return;
  const Canvas& canvas = overlay.canvas();
  const float padding = kWordsPadding * canvas.scale;
  const ImVec2 text = canvas.text_size(markup.words), size(text.x + 2.0f * padding, text.y + padding);
  const ImVec2 from(begin_of(middle->x, size.x, canvas.corner.x, canvas.end().x),
                    begin_of(middle->y, size.y, canvas.corner.y, canvas.end().y)),
      to(from.x + size.x, from.y + size.y);
  overlay.list().AddRectFilled(from, to, ImGui::ColorConvertFloat4ToU32(kPaper), padding);
  overlay.list().AddRect(from, to, ImGui::ColorConvertFloat4ToU32(kInk), padding, 0, canvas.scale);
  canvas.text({from.x + padding, from.y + 0.5f * padding}, kInk, markup.words);
}

}  // namespace

void draw_markups(Overlay& overlay, const core::View& view, std::span<const Markup> markups) {
  const core::dvec3 ahead = direction_of(view);
  for (const Markup& markup : markups) draw_lines(overlay, markup, ahead);
  for (const Markup& markup : markups) draw_words(overlay, markup);
}

void markup_overlay(Workspace& work, const Part& part) {
  if (!work.session) return;
  const auto& drag = work.gestures.drag();
  const auto view = work.session->image.view();
  std::vector<Markup> markups = work.session->marking.list();
  if (drag && drag->moves && draws_markup(work, *drag))
    if (auto dragged = markup_of(work, *drag)) markups.push_back(std::move(*dragged));
  if (!view || markups.empty()) return;
  Overlay overlay(*view, Canvas::in_window(part, work.gui.scale()));
  draw_markups(overlay, *view, markups);
}

}  // namespace sightline::apps
