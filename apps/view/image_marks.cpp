#include "sightline/apps/view/image_marks.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <imgui.h>

#include "sightline/apps/view/overlay.h"
#include "sightline/apps/view/panels.h"

namespace sightline::apps {
namespace {

constexpr double kLeastScale = 0.75;  // letters of eleven pixels
constexpr float kMostPixels = 72.0f;  // of letters in the texture; larger ones are stretched

/// A font of about that height, and its texture. The last one is kept: frames of a video need the same.
ImFont* font_of(float pixels) {
  static std::unique_ptr<ImFontAtlas> atlas;
  static float has = 0.0f;
  if (std::exchange(has, pixels) == pixels && atlas) return atlas->Fonts[0];
  atlas = std::make_unique<ImFontAtlas>();
  ImFont* font = add_font(*atlas, pixels);
  atlas->Build();
  atlas->SetTexID(atlas.get());
  return font;
}

Painting::Texture texture_of(ImFontAtlas& atlas) {
  unsigned char* alpha = nullptr;
  Painting::Texture texture;
  atlas.GetTexDataAsAlpha8(&alpha, &texture.width, &texture.height);
  texture.alpha = alpha;
  return texture;
}

/// `font`: the texture of commands that name it; others name that of the window's font.
Painting painting_of(const ImDrawList& list, ImFontAtlas& font) {
  Painting painting;
  const Painting::Texture own = texture_of(font), windows = texture_of(*ImGui::GetIO().Fonts);
  for (const ImDrawVert& vertex : list.VtxBuffer) {
    painting.vertices.push_back({vertex.pos.x, vertex.pos.y, vertex.uv.x, vertex.uv.y, {}});
    std::memcpy(painting.vertices.back().colour.data(), &vertex.col, sizeof vertex.col);
  }
  for (const ImDrawCmd& command : list.CmdBuffer) {
    const ImVec4& clip = command.ClipRect;
    painting.batches.push_back({painting.indices.size(), command.ElemCount, clip.x, clip.y, clip.z, clip.w,
                                command.TextureId == font.TexID ? own : windows});
    for (unsigned i = 0; i < command.ElemCount; ++i)
      painting.indices.push_back(list.IdxBuffer[int(command.IdxOffset + i)] + command.VtxOffset);
  }
  return painting;
}

/// All that is drawn, as it was when the image was asked for.
struct Marks {
  std::vector<Measurement> measurements;
  std::vector<Markup> markups;
  query::Colouring colouring;
  LengthFormat lengths;
  double scale_per_row = 0.0;  // of the image

  Painting paint(const core::View& view, const std::array<int, 2>& size) const {
    const float scale = float(std::max(kLeastScale, scale_per_row * size[1])), pixels = std::round(kFontPixels * scale);
    ImFont* font = font_of(std::min(pixels, kMostPixels));
    ImDrawList list(ImGui::GetDrawListSharedData());
    list._ResetForNewFrame();
    // Lines would need the texture of the window's font, where the texture is that of this one.
    list.Flags = ImDrawListFlags_AntiAliasedLines | ImDrawListFlags_AntiAliasedFill | ImDrawListFlags_AllowVtxOffset;
    list.PushTextureID(ImGui::GetIO().Fonts->TexID);
    const Canvas canvas{list, {0.0f, 0.0f}, {float(size[0]), float(size[1])}, font, pixels, scale};
    {
      Overlay overlay(view, canvas);  // clips
      draw_legend(canvas, colouring);
      LabelPlacement labels = labels_on(canvas);
      draw_measurements(overlay, measurements, lengths, labels);
      draw_markups(overlay, view, markups);
    }
    return painting_of(list, *font->ContainerAtlas);
  }
};

}  // namespace

Painter image_marks(const Workspace& work) {
  const Session& session = *work.session;
  if (!work.shown.image_marks ||
      (session.measuring.list().empty() && session.marking.list().empty() && session.colouring.groups.empty()))
    return {};
  query::Colouring colouring{session.colouring.key, session.colouring.groups, {}};
  return [marks = Marks{session.measuring.list(), session.marking.list(), std::move(colouring), work.lengths(),
                        work.gui.scale() / std::max(1, session.image.size()[1])}](
             const core::View& view, const std::array<int, 2>& size) { return marks.paint(view, size); };
}

}  // namespace sightline::apps
