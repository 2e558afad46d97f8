#include <algorithm>
#include <cstdio>
#include <string_view>

#include "sightline/apps/common/frame_words.h"
#include "sightline/apps/view/panels.h"
#include "sightline/apps/view/widgets.h"

namespace sightline::apps {

void culling_tab(Viewer& viewer) {
  Session& session = *viewer.session();
  for (const Command& command : commands()) {
    if (!command.on || std::string_view(command.group ? command.group : "") != "Culling") continue;
    bool on = command.on(viewer);
    if (ImGui::Checkbox(command.title, &on)) run(viewer, command);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", command.help);
  }
  const engine::FrameReport& report = session.report();
  const auto known = [](std::int64_t count) { return count < 0 ? std::string("known to the GPU") : grouped(count); };
  ImGui::Separator();
  if (begin_rows("counters")) {
    row("culled by", std::string(name_of(report.culler)));
    row("state", std::string(state_name(report)));
    row("items", grouped(std::int64_t(session.engine().snapshot().size())));
    row("in the view", grouped(session.visible()));
    row("boxes tested", known(report.tested));
    row("with a sample", known(report.sampled));
    row("drawn", known(report.shown));
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
