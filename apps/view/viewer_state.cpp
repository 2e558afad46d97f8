// What scripts and --json see of the viewer.
#include "sightline/apps/common/legend.h"
#include "sightline/apps/common/report_json.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/script_runner.h"
#include "sightline/apps/view/workspace.h"

namespace sightline::apps {
namespace {

using Json = json::Value;

Json vector_json(const core::dvec3& v) {
  return Json::array({v.x, v.y, v.z});
}

Json measure_json(const Measuring& measuring) {
  Json json{{"marks", measuring.marks().size()}, {"list", measuring.list().size()}, {"rows", Json::object()}};
  for (const auto& [what, value] : measuring.rows()) json["rows"][what] = value;
  if (measuring.distance()) json["distance"] = measuring.distance()->distance;
  return json;
}

Json markups_json(const Marking& marking) {
  Json json{{"count", marking.list().size()}};
  if (!marking.list().empty()) json["last"] = to_json(marking.list().back());
  return json;
}

/// Items by what a frozen camera's culling makes of them, and its boxes.
Json culling_json(Session& session, const CullingBoxes& boxes) {
  Json json = Json::object();
  if (const auto loss = session.image.loss())
    json["loss"] = {{"items", loss->items},
                    {"pixels", loss->pixels},
                    {"lod_error", loss->lod_error},
                    {"triangles", loss->triangles},
                    {"full_triangles", loss->full_triangles},
                    {"coarser_share", loss->coarser_share}};
  const culling::CullStates* states = session.image.frozen() ? session.image.frozen()->states() : nullptr;
  if (!states) return json;
  for (int i = 0; i < culling::kCullStateCount; ++i)
    json[std::string(name_of(culling::CullState(i)))] = states->items[std::size_t(i)];
  json.update({{"boxes", boxes.wanted()}, {"drawn", boxes.drawn()}});
  return json;
}

Json sections_json(const Sections& sections) {
  Json json = Json::array();
  for (const Sections::Section& section : sections.all())
    json.push_back({{"on", section.on},
                    {"at", vector_json(section.place())},
                    {"normal", vector_json(section.normal)},
                    {"moved", section.offset}});
  return json;
}

/// Milliseconds of each step in which the last model was opened or compared, and in how many portions it was brought
/// into the window.
Json opening_json(const Opening& opening) {
  const OpeningSteps& steps = opening.steps();
  Json json{{"step", steps.name()}, {"portions", opening.portions()}};
  for (std::size_t i = 1; i < kOpeningStepNames.size(); ++i)
    json[std::string(kOpeningStepNames[i]) + "_ms"] = 1e3 * steps.seconds(OpeningStep(i));
  return json;
}

Json views_json(const ViewList& views) {
  Json json{{"count", views.size()}, {"current", views.current_index() + 1}};
  if (const Viewpoint* view = views.current())
    json.update({{"name", view->name},
                 {"comment", view->comment},
                 {"status", view->status},
                 {"type", view->type},
                 {"guid", view->guid}});
  return json;
}

/// What there is without a model, too.
Json window_json(const Workspace& work) {
  const Part& part = work.image.part();
  return {{"model", work.files()},
          {"renderer", work.window.context().renderer()},
          {"size", {part.width, part.height}},
          {"window", work.window.size()},
          {"frames", work.image.frames()},
          {"message", work.messages.text()},
          {"panels", work.shown.panels},
          {"dialog", name_of(work.shown.dialog)},
          {"browser", work.file_dialog.state()},
          {"menu", work.gui.has_popup()},
          {"tool", name_of(work.shown.tool)},
          {"tab", work.shown.tab},
          {"level", name_of(work.shown.level)},
          {"theme", work.shown.light ? "light" : "dark"},
          {"recent", work.shown.recent},
          {"damaged", work.damaged.files},
          {"sets", work.shown.sets},
          {"walk", work.gestures.walking()},
          {"triad", work.shown.triad},
          {"smooth", work.shown.smooth},
          {"finer_meshes", work.finer.count()},
          {"depth_shading", work.shown.depth_shading},
          {"hatching", work.shown.hatching},
          {"edges", work.shown.edges},
          {"lower", work.shown.lower},
          {"levels", work.shown.levels},
          {"units", kUnitsNames[int(work.shown.units)]},
          {"diagnostics", work.shown.diagnostics},
          {"recognise", work.shown.recognise},
          {"y_up", work.opening.y_is_up(work.session.get())},
          {"image", {{"width", part.width}, {"height", part.height}}},
          {"response_ms", work.pace.response_ms},
          {"pause_ms", work.pace.pause_ms},
          {"opening", opening_json(work.opening)},
          {"recording", work.recorder.has_value()},
          {"playing", work.player.playing()},
          {"recovered", work.pace.recovered},
          {"views", views_json(work.views)}};
}

Json session_json(Session& session) {
  const core::Pose& pose = session.camera.pose();
  const std::optional<Taken>& hovered = session.document.hovered;
  return {{"items", session.scene().item_count()},
          {"recognition", recognition_json(session.model().report.recognition)},
          {"culler", name_of(session.engine.plan().culler)},
          {"culled_by", name_of(session.image.report().culler)},
          {"visible", session.image.visible()},
          {"drawn", session.image.report().items_drawn},
          {"triangles", session.image.report().triangles},
          {"selection", {{"count", session.document.selection().size()}}},
          {"hidden", session.document.hidden()},
          {"ghosts", session.document.ghosts()},
          {"hovered", hovered ? std::int64_t(hovered->item) : -1},
          {"hovered_items", hovered ? hovered->items.size() : 0},
          {"sections", session.sections.planes().size()},
          {"measure", measure_json(session.measuring)},
          {"markups", markups_json(session.marking)},
          {"findings", session.findings().size()},
          {"found", session.tree.match_count()},
          {"colours", legend_json(session.colouring)},
          {"rows", session.tree.rows().row_count()},
          {"undo_steps", session.document.undo_steps()},
          {"redo_steps", session.document.redo_steps()},
          {"frozen", session.image.frozen() != nullptr},
          {"compare", compare_json(session)},
          {"budget_ms", session.engine.config().losses.budget_ms},
          {"min_projected_area", session.engine.config().losses.min_projected_area},
          {"lod_error", session.engine.config().losses.lod_error},
          {"camera",
           {{"eye", vector_json(pose.eye)},
            {"target", vector_json(pose.target)},
            {"orthographic", session.camera.orthographic()}}}};
}

/// The sections, with the places of their handles where these show.
Json section_list_json(const Workspace& work) {
  Json json = sections_json(work.session->sections);
  if (work.gestures.shows_section_handles())
    for (const SectionHandles::Shown& one : SectionHandles::shown(*work.session, work.gui.scale()))
      for (const SectionGizmo::Handle& handle : one.gizmo.handles()) {
        const core::dvec2 at = handle.at - work.image.in_image({0.0, 0.0});
        json[one.section]["handles"][SectionGizmo::name_of(handle.part)] = {at.x, at.y};
      }
  return json;
}

}  // namespace

Json state_json(const Workspace& work) {
  Json json = window_json(work);
  if (!work.session) return json;
  const Sections& sections = work.session->sections;
  const std::optional<core::dvec3>& cursor = work.gestures.cursor_point();
  json.update(session_json(*work.session));
  json.update({{"section_list", section_list_json(work)},
               {"section_box", sections.box().has_value()},
               {"section_selected", sections.selected() ? *sections.selected() + 1 : 0},
               {"cursor", cursor ? vector_json(*cursor) : Json()},
               {"culling", culling_json(*work.session, work.culling.boxes())},
               {"summary",
                {{"cull_ms", to_json(summarise(work.image.cull_ms()))},
                 {"frame_ms", to_json(summarise(work.image.frame_ms()))}}}});
  return json;
}

}  // namespace sightline::apps
