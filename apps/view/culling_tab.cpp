#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "sightline/apps/common/frame_words.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {

namespace {

/// What the engine leaves out or puts off while the view moves, and when its hybrid changes the path.
void settings_sliders(Viewer& viewer, Session& session) {
  const engine::EngineConfig& now = session.engine().config();
  const auto slider = [&](const char* name, const char* tip, double value, double most, const char* format, auto set) {
    float shown = float(value);
    ImGui::SetNextItemWidth(9.0f * ImGui::GetFontSize());
    const bool moved = ImGui::SliderFloat(name, &shown, 0.0f, float(most), format, ImGuiSliderFlags_AlwaysClamp);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tip);
    if (!moved || double(shown) == value) return;
    const auto done = session.configure([&](engine::EngineConfig& config) { set(config, shown); });
    if (!done) viewer.tell(done.error().message, true);
  };
  slider("budget, ms", "what a frame may take while the view moves; 0: any time", now.budget_ms, 200.0, "%.0f",
         [](auto& config, float ms) { config.budget_ms = std::round(ms); });
  slider("least area, px", "items that cover fewer pixels are left out; 0: none", now.contribution, 16.0, "%.1f",
         [](auto& config, float pixels) { config.contribution = pixels; });
  if (session.engine().plan().culler != engine::CullerChoice::kHybrid) return;
  const culling::FrameCostConfig& hybrid = now.controller.frame_cost;
  slider("margin, %", "the hybrid changes the path where the other one is cheaper by this share", 1e2 * hybrid.margin,
         50.0, "%.0f", [](auto& config, float share) { config.controller.frame_cost.margin = 1e-2 * double(share); });
  slider("margin at first, %", "the same soon after a change", 1e2 * hybrid.dwell_margin, 100.0, "%.0f",
         [](auto& config, float share) { config.controller.frame_cost.dwell_margin = 1e-2 * double(share); });
  slider("soon, frames", "what counts as soon after a change", hybrid.dwell_frames, 100.0, "%.0f",
         [](auto& config, float frames) { config.controller.frame_cost.dwell_frames = std::uint32_t(frames + 0.5f); });
}

}  // namespace

void culling_tab(Viewer& viewer) {
  Session& session = *viewer.session();
  for (const Command& command : commands()) {
    if (!command.on || std::string_view(command.group ? command.group : "") != "Culling") continue;
    bool on = command.on(viewer);
    if (ImGui::Checkbox(command.title, &on)) run(viewer, command);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", command.help);
  }
  settings_sliders(viewer, session);
  const engine::FrameReport& report = session.report();
  const auto known = [](std::int64_t count) { return count < 0 ? std::string("known to the GPU") : grouped(count); };
  ImGui::Separator();
  if (begin_rows("counters")) {
    row("culled by", std::string(name_of(report.culler)));
    row("state", std::string(state_name(report)));
    row("items", grouped(std::int64_t(session.scene().item_count())));
    row("in the view", grouped(session.visible()));
    row("boxes tested", known(report.tested));
    row("with a sample", known(report.sampled));
    row("drawn", known(report.shown));
    row("too small", grouped(report.small));
    row("not yet drawn", grouped(report.pending));
    char text[60];
    std::snprintf(text, sizeof text, "%.3f ms", report.cull_ms);
    row("culling", text);
    std::snprintf(text, sizeof text, "%.1f ms", report.draw_ms);
    row("drawing", text);
    ImGui::EndTable();
  }
  const std::vector<double>& times = viewer.frame_times();
  if (times.empty()) return;
  const auto value = [](void* data, int i) {
    return float((*static_cast<const std::vector<double>*>(data))[std::size_t(i)]);
  };
  const double most = *std::max_element(times.begin(), times.end());
  char label[60];
  std::snprintf(label, sizeof label, "pictures, up to %.1f ms", most);
  ImGui::PlotLines("##times", value, const_cast<std::vector<double>*>(&times), int(times.size()), 0, label, 0.0f,
                   float(most), {-1.0f, 6.0f * ImGui::GetFontSize()});
  const engine::MemoryReport memory = session.engine().memory();
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
