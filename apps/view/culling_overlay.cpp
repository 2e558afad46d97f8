#include "sightline/apps/view/culling_overlay.h"

#include <array>

#include "sightline/apps/view/session.h"
#include "sightline/apps/view/window.h"

namespace sightline::apps {
namespace {

constexpr float kBehind = 0.14f;  // alpha of what the image hides
const std::array<ImVec4, CullingLine::kInkCount> kInks{{
    {0.0f, 0.62f, 0.45f, 1.0f},   // inside: bluish green
    {0.90f, 0.62f, 0.0f, 1.0f},   // intersecting: orange
    {0.34f, 0.71f, 0.91f, 1.0f},  // outside: sky blue
    {0.80f, 0.47f, 0.65f, 1.0f},  // occluded: reddish purple
    {0.0f, 0.45f, 0.70f, 1.0f},   // small: blue
    {0.84f, 0.37f, 0.0f, 1.0f},   // view volume: vermilion
    {0.84f, 0.37f, 0.0f, 0.4f},   // what sections cut from it
    {0.95f, 0.90f, 0.25f, 1.0f},  // sections: yellow
}};

}  // namespace

ImVec4 CullingOverlay::colour(culling::CullState state) {
  return kInks[std::size_t(state)];
}

void CullingOverlay::draw(Session& session, const Part& part) {
  const FrozenCamera* frozen = session.image.frozen();
  if (!frozen || !frozen->states() || !switches.boxes || !session.image.drawn()) {
    boxes_ = {};
    made_.reset();
    return;
  }
  const Made now{session.image.report().frame, frozen->version(), switches};
  if (made_ != now) {
    const auto depth = session.engine.read_depth(*session.image.drawn());
    if (!depth) return;  // the context was lost: another frame follows
    boxes_.update(*session.image.drawn(), *depth, *frozen, session.engine.snapshot().bounds().origin,
                  session.bounds().bounds, switches);
    made_ = now;
  }
  const ImVec2 corner{float(part.x), ImGui::GetIO().DisplaySize.y - float(part.y + part.height)};
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  for (const bool behind : {true, false})
    for (const CullingLine& line : boxes_.lines()) {
      if (line.behind != behind) continue;
      ImVec4 ink = kInks[line.ink];
      if (behind) ink.w *= line.ink >= CullingLine::kVolume ? 2.0f * kBehind : kBehind;
      list.AddLine({corner.x + float(line.from.x), corner.y + float(line.from.y)},
                   {corner.x + float(line.to.x), corner.y + float(line.to.y)}, ImGui::ColorConvertFloat4ToU32(ink),
                   line.ink >= CullingLine::kVolume && !behind ? 2.0f : 1.0f);
    }
}

}  // namespace sightline::apps
