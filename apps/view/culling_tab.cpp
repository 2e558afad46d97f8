#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <string_view>

#include "sightline/apps/common/frame_words.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/plots.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {

namespace {

/// What the sliders cost, beside them.
void error_of_losses(Session& session) {
  const engine::EngineConfig& now = session.engine.config();
  const bool leaves_out = now.losses.budget_ms > 0.0 || now.losses.min_projected_area > 0.0f;
  if (!leaves_out && now.losses.lod_error <= 0.0) return;
  const auto loss = session.image.loss();
  if (!loss) return ImGui::TextDisabled("error: known when nothing moves");
  if (now.losses.lod_error > 0.0) {
    ImGui::TextWrapped("surfaces: within %.2f px; %s of %s triangles", loss->lod_error,
                       grouped(loss->triangles).c_str(), grouped(loss->full_triangles).c_str());
  }
  if (!leaves_out) return;
  const double share = 100.0 * loss->pixels / (double(session.image.size()[0]) * session.image.size()[1]);
  ImGui::TextWrapped("error: %s items, %s px, %.2f %%", grouped(loss->items).c_str(),
                     grouped(std::int64_t(std::ceil(loss->pixels))).c_str(), share);
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip(
        "left out of the image, and not known to be hidden;\n"
        "pixels that these would cover if none hid another");
}

/// What the engine leaves out or puts off while the view moves, and when its hybrid changes the path.
void settings_sliders(Workspace& work, Session& session) {
  const engine::EngineConfig& now = session.engine.config();
  const auto slide = [](const char* name, const char* tip, double value, double most,
                        const char* format) -> std::optional<float> {
    float shown = float(value);
    ImGui::SetNextItemWidth(std::min(9.0f * ImGui::GetFontSize(), 0.42f * ImGui::GetContentRegionAvail().x));
    const bool moved = ImGui::SliderFloat(name, &shown, 0.0f, float(most), format, ImGuiSliderFlags_AlwaysClamp);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tip);
    return moved && double(shown) != value ? std::optional(shown) : std::nullopt;
  };
  const auto slider = [&](const char* name, const char* tip, double value, double most, const char* format, auto set) {
    if (const auto shown = slide(name, tip, value, most, format))
      work.messages.tell_outcome(session.image.configure([&](engine::EngineConfig& config) { set(config, *shown); }));
  };
  slider("budget, ms", "what a frame may take while the view moves; 0: any time", now.losses.budget_ms, 200.0, "%.0f",
         [](auto& config, float ms) { config.losses.budget_ms = std::round(ms); });
  slider("min area, px", "items that cover fewer pixels are left out; 0: none", now.losses.min_projected_area, 16.0,
         "%.1f", [](auto& config, float pixels) { config.losses.min_projected_area = pixels; });
  if (session.image.has_levels())
    if (const auto pixels = slide("levels, px", "how far meshes may lie elsewhere while the view moves; 0: not at all",
                                  session.image.motion_error(), 16.0, "%.2f"))
      work.messages.tell_outcome(work.set_motion_error(double(*pixels)));
  error_of_losses(session);
  if (session.engine.plan().culler != engine::CullerChoice::kHybrid) return;
  const culling::ControllerConfig& hybrid = now.culling.controller;
  slider("margin, %", "the hybrid changes the path where the other one is cheaper by this share", 1e2 * hybrid.margin,
         50.0, "%.0f", [](auto& config, float share) { config.culling.controller.margin = 1e-2 * double(share); });
  slider("margin at first, %", "the same soon after a change", 1e2 * hybrid.dwell_margin, 100.0, "%.0f",
         [](auto& config, float share) { config.culling.controller.dwell_margin = 1e-2 * double(share); });
  slider("soon, frames", "what counts as soon after a change", hybrid.dwell_frames, 100.0, "%.0f",
         [](auto& config, float frames) { config.culling.controller.dwell_frames = std::uint32_t(frames + 0.5f); });
}

/// Legend, switches and counts of a frozen camera's items.
void frozen_states(Workspace& work, const FrozenCamera& frozen) {
  if (!frozen.states()) return;
  constexpr const char* kWords[] = {"inside", "across its border", "outside", "hidden by others", "too small"};
  CullingSwitches& switches = work.culling.switches;
  ImGui::Separator();
  ImGui::TextUnformatted("Items of the frozen camera");
  ImGui::BeginDisabled(!switches.boxes);
  for (int i = 0; i < culling::kCullStateCount; ++i) {
    ImGui::PushID(i);
    ImGui::Checkbox("##shown", &switches.states[std::size_t(i)]);
    ImGui::SameLine(0.0f, 0.4f * ImGui::GetFontSize());
    ImGui::AlignTextToFramePadding();
    colour_square(CullingOverlay::colour(culling::CullState(i)), ImGui::GetStyle().FramePadding.y);
    ImGui::TextUnformatted(kWords[i]);
    const std::string count = grouped(frozen.states()->items[std::size_t(i)]);
    ImGui::SameLine(std::max(0.0f, ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(count.c_str()).x));
    ImGui::TextUnformatted(count.c_str());
    ImGui::PopID();
  }
  ImGui::EndDisabled();
  const CullingBoxes& boxes = work.culling.boxes();
  if (switches.boxes)
    ImGui::Text("%s of %s boxes shown", grouped(std::int64_t(boxes.drawn())).c_str(),
                grouped(std::int64_t(boxes.wanted())).c_str());
}

template <int kDigits>
std::string milliseconds(double ms) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*f ms", kDigits, ms);
  return text;
}

/// Plots of the last images. Colours differ for all kinds of colour blindness.
void plots(const std::vector<FrameMeasurements>& frames) {
  const ImVec4 kFirst{0.0f, 0.62f, 0.45f, 1.0f}, kSecond{0.90f, 0.62f, 0.0f, 1.0f};
  constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
  const auto culled = [&](bool on_gpu) {
    return [&frames, on_gpu](std::size_t i) { return frames[i].on_gpu == on_gpu ? frames[i].cull_ms : kGap; };
  };
  plot("culling", milliseconds<3>, frames.size(), {{"CPU", kFirst, culled(false)}, {"GPU", kSecond, culled(true)}});
  plot("images", milliseconds<1>, frames.size(), {{"", kFirst, [&](std::size_t i) { return frames[i].image_ms; }}});
  plot("items", [](double most) { return grouped(std::int64_t(most)); }, frames.size(),
       {{"in view", kFirst, [&](std::size_t i) { return double(frames[i].visible); }},
        {"drawn", kSecond,
         [&](std::size_t i) { return frames[i].items_drawn < 0 ? kGap : double(frames[i].items_drawn); }}});
}

}  // namespace

void culling_tab(Workspace& work) {
  Session& session = *work.session;
  for (const Command& command : commands()) {
    if (!command.on || !std::string_view(command.menu ? command.menu : "").ends_with("/Diagnostics") ||
        command.name == std::string_view("diagnostics"))
      continue;
    bool on = command.on(work);
    if (ImGui::Checkbox(command.title, &on)) run(work, command);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", command.help);
  }
  settings_sliders(work, session);
  if (session.image.frozen()) frozen_states(work, *session.image.frozen());
  ImGui::Separator();
  plots(work.image.history());
  const engine::FrameReport& report = session.image.report();
  const auto known = [](std::int64_t count) { return count < 0 ? std::string("known to the GPU") : grouped(count); };
  ImGui::Separator();
  if (begin_rows("counters")) {
    row("culled by", std::string(name_of(report.culler)));
    row("state", std::string(state_name(report)));
    row("items", grouped(std::int64_t(session.scene().item_count())));
    row("in the view", grouped(session.image.visible()));
    row("boxes tested", known(report.tested));
    row("with a sample", known(report.sampled));
    row("drawn", known(report.items_drawn));
    row("triangles of meshes", known(report.triangles));
    row("too small", grouped(report.below_min_area));
    row("not yet drawn", grouped(report.pending));
    row("culling", milliseconds<3>(report.cull_ms));
    row("drawing", milliseconds<1>(report.draw_ms));
    ImGui::EndTable();
  }
  const engine::MemoryReport memory = session.engine.memory();
  if (begin_rows("memory")) {
    const auto mib = [](std::size_t bytes) {
      char text[40];
      std::snprintf(text, sizeof text, "%.1f MiB", double(bytes) / (1 << 20));
      return std::string(text);
    };
    row("scene", mib(memory.scene));
    row("snapshot", mib(memory.snapshot));
    row("hierarchy", mib(memory.bvh));
    row("GPU", mib(memory.gpu));
    row("tracer", mib(memory.tracer));
    ImGui::EndTable();
  }
}

}  // namespace sightline::apps
