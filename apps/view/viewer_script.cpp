// What scripts do, and the state that they and --json see.
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/report_json.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/view/commands.h"
#include "sightline/apps/view/comparing.h"
#include "sightline/apps/view/viewer.h"
#include "sightline/importers/json/internal/json.h"

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

/// Items by what a frozen camera's culling makes of them, and its boxes.
Json culling_json(Session& session, const CullingBoxes& boxes) {
  Json json = Json::object();
  if (const auto loss = session.loss())
    json["loss"] = {{"items", loss->items},
                    {"pixels", loss->pixels},
                    {"lod_error", loss->lod_error},
                    {"triangles", loss->triangles},
                    {"full_triangles", loss->full_triangles},
                    {"coarser_share", loss->coarser_share}};
  const culling::CullStates* states = session.frozen() ? session.frozen()->states() : nullptr;
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
Json opening_json(const OpeningSteps& opening, int portions) {
  Json json{{"step", opening.name()}, {"portions", portions}};
  for (std::size_t i = 1; i < kOpeningStepNames.size(); ++i)
    json[std::string(kOpeningStepNames[i]) + "_ms"] = 1e3 * opening.seconds(OpeningStep(i));
  return json;
}

Json views_json(const ViewList& views) {
  Json json{{"count", views.size()}, {"current", views.current_index() + 1}};
  if (const Viewpoint* view = views.current())
    json.update({{"name", view->name}, {"comment", view->comment}, {"guid", view->guid}});
  return json;
}

}  // namespace

core::Expected<void> Viewer::step_script() {
  const ScriptStep& step = script_[next_step_];
  const bool at_point = step.name == "wheel" || step.name == "drag";  // of the model, where picks do not wait
  if (at_point && session_ && session_->engine().preparing_picks()) return {};
  ++next_step_;
  if (auto done = carry_out(step); !done)
    return core::fail(options_.script + ":" + std::to_string(step.line) + ": " + done.error().message);
  redraws_ = kSettlingFrames;
  return {};
}

core::Expected<void> Viewer::carry_out(const ScriptStep& step) {
  auto events = events_of(step);
  if (!events) return tl::unexpected(events.error());
  if (!events->empty()) {
    if (step.name == "wheel") events->front().at = cursor_;
    gui_.push(std::move(*events));
    return {};
  }
  if (step.name == "expect") return expect(step.argument);
  if (step.name == "window-shot") {
    window_shot_ = step.argument;
    return {};
  }
  if (step.name == "resize") {
    const auto size = parse_size(step.argument);
    if (!size) return tl::unexpected(size.error());
    window_.resize(*size);
    wait_until_ = glfwGetTime() + 0.2;  // the window system answers later
    return {};
  }
  if (step.name == "hold") {
    const std::size_t space = step.argument.rfind(' ');
    const auto seconds = parse_finite(space == std::string::npos ? "" : step.argument.substr(space + 1));
    if (!seconds) return core::fail("hold: expected a key and seconds, found \"" + step.argument + "\"");
    auto pressed = events_of({step.line, "press", step.argument.substr(0, space)});
    if (!pressed) return tl::unexpected(pressed.error());
    release_ = pressed->back();
    gui_.push({pressed->front()});
    wait_until_ = glfwGetTime() + *seconds;
    return {};
  }
  if (step.name == "wait") {
    const auto seconds = parse_finite(step.argument);
    if (!seconds) return tl::unexpected(seconds.error());
    wait_until_ = glfwGetTime() + *seconds;
    return {};
  }
  const Command* command = find_command(step.name);
  if (!command) return core::fail("no command " + step.name);
  if (command->needs_model() && !session_) return core::fail(step.name + ": no model is open");
  auto done = command->run(*this, step.argument);
  tell_outcome(done);
  return done;
}

core::Expected<void> Viewer::expect(const std::string& argument) {
  const std::size_t space = argument.find(' ');
  const std::string pointer = argument.substr(0, space),
                    demand = space == std::string::npos ? "" : argument.substr(space + 1);
  const Json all = state();
  const Json* value = all.find_pointer(pointer);
  if (!value) return core::fail("expect: the state has no " + pointer);
  const auto good = fulfils(value->dump(), demand);
  if (!good) return tl::unexpected(good.error());
  if (!*good) return core::fail("expected " + argument + ", found " + value->dump());
  return {};
}

Json Viewer::state() const {
  Json json{{"model", files_},
            {"renderer", window_.context().renderer()},
            {"size", {part_.width, part_.height}},
            {"window", window_.size()},
            {"frames", frames_},
            {"message", message_},
            {"panels", shown.panels},
            {"dialog", name_of(shown.dialog)},
            {"browser", file_dialog_.state()},
            {"menu", gui_.has_popup()},
            {"tool", name_of(shown.tool)},
            {"tab", shown.tab},
            {"theme", gui_.theme() == Theme::kLight ? "light" : "dark"},
            {"recent", now_.recent},
            {"walk", walking()},
            {"triad", shown.triad},
            {"smooth", shown.smooth},
            {"depth_shading", shown.depth_shading},
            {"hatching", shown.hatching},
            {"lower", shown.lower},
            {"levels", shown.levels},
            {"units", kUnitsNames[int(shown.units)]},
            {"diagnostics", shown.diagnostics},
            {"recognise", shown.recognise},
            {"y_up", y_is_up()},
            {"image", {{"width", part_.width}, {"height", part_.height}}},
            {"response_ms", response_ms_},
            {"pause_ms", pause_ms_},
            {"opening", opening_json(opening_, engine_portions_)},
            {"recording", recording()},
            {"playing", player_.playing()},
            {"recovered", recovered_},
            {"views", views_json(views_)}};
  if (!session_) return json;
  const Document& document = session_->document();
  const core::Pose& pose = session_->camera().pose();
  const Sections& sections = session_->sections();
  json["section_list"] = sections_json(sections);
  if (shows_section_handles())
    for (const SectionHandles::Shown& one : SectionHandles::shown(*session_, gui_.scale()))
      for (const SectionGizmo::Handle& handle : one.gizmo.handles()) {
        const core::dvec2 at = handle.at - in_image({0.0, 0.0});
        json["section_list"][one.section]["handles"][SectionGizmo::name_of(handle.part)] = {at.x, at.y};
      }
  json["section_box"] = sections.box().has_value();
  json["section_selected"] = sections.selected() ? *sections.selected() + 1 : 0;
  json.update({{"items", session_->scene().item_count()},
               {"recognition", recognition_json(session_->model().report.recognition)},
               {"culler", name_of(session_->engine().plan().culler)},
               {"culled_by", name_of(session_->report().culler)},
               {"visible", session_->visible()},
               {"drawn", session_->report().items_drawn},
               {"triangles", session_->report().triangles},
               {"selection", {{"count", document.selection().size()}}},
               {"hidden", document.hidden()},
               {"ghosts", document.ghosts()},
               {"hovered", document.hovered() ? std::int64_t(*document.hovered()) : -1},
               {"cursor", cursor_point_ ? vector_json(*cursor_point_) : Json()},
               {"sections", session_->sections().planes().size()},
               {"measure", measure_json(session_->measuring())},
               {"findings", session_->findings().size()},
               {"found", session_->tree().match_count()},
               {"rows", session_->tree().rows().row_count()},
               {"undo_steps", document.undo_steps()},
               {"redo_steps", document.redo_steps()},
               {"frozen", session_->frozen() != nullptr},
               {"compare", compare_json(*session_)},
               {"culling", culling_json(*session_, culling_.boxes())},
               {"budget_ms", session_->engine().config().losses.budget_ms},
               {"min_projected_area", session_->engine().config().losses.min_projected_area},
               {"lod_error", session_->engine().config().losses.lod_error},
               {"camera",
                {{"eye", vector_json(pose.eye)},
                 {"target", vector_json(pose.target)},
                 {"orthographic", session_->camera().orthographic()}}},
               {"summary", {{"cull_ms", to_json(summarise(cull_ms_))}, {"frame_ms", to_json(summarise(frame_ms_))}}}});
  return json;
}

}  // namespace sightline::apps
