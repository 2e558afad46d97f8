#include "sightline/apps/view/model_exporting.h"

#include <utility>

#include <imgui.h>

#include "sightline/apps/common/write_model.h"
#include "sightline/apps/view/model_export.h"
#include "sightline/apps/view/widgets.h"
#include "sightline/importers/internal/extension.h"

namespace sightline::apps {
namespace {

using Done = core::Expected<void>;
using Job = core::Expected<ModelExport::Job>;

Done begin(Viewer& viewer, Job job) {
  if (!job) return tl::unexpected(job.error());
  if (auto free = viewer.scene_is_free(); !free) return free;
  viewer.begin_model_export(std::move(*job));
  return {};
}

void tell_of_export(const std::string& what) {
  wrapped_text(what);
  ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
  wrapped_text(
      ".rvm and .slc keep primitives and all layers; .obj, .glb and .gltf get triangles, without obstruction and "
      "insulation volumes.");
  ImGui::PopStyleColor();
}

}  // namespace

Done export_model(Viewer& viewer, const std::string& file) {
  if (file.empty()) return viewer.shown.dialog = Dialog::kExportModel, Done();
  return begin(viewer, ModelExport::model(*viewer.session(), viewer.files(), file));
}

Done export_selection(Viewer& viewer, const std::string& file) {
  if (const char* why = without_selection(viewer)) return core::fail(why);
  if (file.empty()) return viewer.shown.dialog = Dialog::kExportSelection, Done();
  return begin(viewer, ModelExport::selection(*viewer.session(), viewer.files(), file));
}

void export_model_options(Viewer&) {
  tell_of_export("All of the model is written, with what is hidden.");
}

void export_selection_options(Viewer& viewer) {
  const std::size_t count = viewer.session() ? viewer.session()->document().selection().size() : 0;
  tell_of_export(grouped(std::int64_t(count)) + (count == 1 ? " selected item is" : " selected items are") +
                 " written, with the groups above.");
}

std::string export_name(const Viewer& viewer, const char* stem) {
  const std::string extension = viewer.files().empty() ? "" : importers::lower_case_extension(viewer.files().front());
  return std::string(stem) + (check_output("x" + extension, {}) ? extension : ".glb");
}

}  // namespace sightline::apps
