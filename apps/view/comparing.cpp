#include "sightline/apps/view/comparing.h"

#include <filesystem>
#include <optional>
#include <utility>

#include "sightline/apps/common/arguments.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {
namespace {

using compare::State;
using Json = json::Value;

core::Expected<ChangeList*> changes_of(Viewer& viewer) {
  ChangeList* changes = viewer.session()->changes();
  return changes ? core::Expected<ChangeList*>(changes) : core::fail("compare with an older revision first");
}

core::Expected<void> step(Viewer& viewer, int by) {
  const auto changes = changes_of(viewer);
  if (!changes) return tl::unexpected(changes.error());
  const auto row = (*changes)->step(by);
  if (!row) return core::fail("there are no changes to go to");
  return viewer.session()->go_to_change(*row);
}

std::string summary(const ChangeList& changes) {
  const std::string file = std::filesystem::path(changes.file()).filename().string();
  if (changes.found().same()) return "nothing has changed since " + file;
  std::string text = "since " + file + ":";
  for (const State state : {State::kAdded, State::kRemoved, State::kMoved, State::kChanged})
    text += (state == State::kAdded ? " " : ", ") + grouped(std::int64_t(changes.found().count(state))) + " " +
            std::string(compare::name_of(state));
  return text;
}

}  // namespace

void Viewer::compare(const std::string& file) {
  ModelOptions older = options_.model;
  older.files = older_files(file, files_);
  older.import.recognise = recognised_;
  older.import.copies = importers::MeshCopies::kExact;  // similar copies may be moved by a little
  auto found = std::make_shared<compare::Comparison>();
  const auto work = [found, open = &session_->model()](Model& model, const std::function<bool(double)>& progress) {
    auto comparison = compare_models(model, *open, progress);
    if (!comparison) return core::Expected<void>(tl::unexpected(comparison.error()));
    *found = std::move(*comparison);
    return core::Expected<void>();
  };
  drop_loading();
  opening_ = {};
  opening_.enter(OpeningStep::kReading);
  engine_portions_ = 0;
  loader_ = std::make_unique<Loader>(older, &Window::wake, work);
  found_ = std::move(found);
  if (shown.dialog == Dialog::kCompare) shown.dialog = Dialog::kNone;
  tell("comparing with " + std::filesystem::path(file).filename().string());
}

/// What is open, and a former comparison, stay where the file cannot be read.
void Viewer::land_comparison(core::Expected<Model> before, const std::string& file) {
  auto found = std::exchange(found_, nullptr);
  if (!before) return tell(before.error().message, true);
  auto changes = std::make_unique<ChangeList>(file, std::move(*before), std::move(*found));
  if (auto done = session_->begin_comparison(std::move(changes)); !done) return tell(done.error().message, true);
  tell(summary(*session_->changes()));
}

core::Expected<void> compare_with(Viewer& viewer, const std::string& file) {
  if (file.empty())
    viewer.shown.dialog = Dialog::kCompare;
  else
    viewer.compare(file);
  return {};
}

core::Expected<void> end_comparison(Viewer& viewer, const std::string&) {
  if (auto free = viewer.scene_is_free(); !free) return free;
  if (const auto changes = changes_of(viewer); !changes) return tl::unexpected(changes.error());
  return viewer.session()->end_comparison();
}

core::Expected<void> toggle_changes(Viewer& viewer, const std::string& name) {
  const auto changes = changes_of(viewer);
  if (!changes) return tl::unexpected(changes.error());
  for (std::size_t i = 0; i < compare::kStateCount; ++i)
    if (compare::name_of(State(i)) == name)
      return viewer.session()->show_changes(State(i), !(*changes)->shown(State(i)));
  return core::fail("expected added, removed, moved, changed or unchanged, found \"" + name + "\"");
}

core::Expected<void> next_change(Viewer& viewer, const std::string&) {
  return step(viewer, 1);
}

core::Expected<void> previous_change(Viewer& viewer, const std::string&) {
  return step(viewer, -1);
}

core::Expected<void> set_slider(Viewer& viewer, const std::string& argument) {
  constexpr double kMiddle = 0.5;
  if (const auto changes = changes_of(viewer); !changes) return tl::unexpected(changes.error());
  Session& session = *viewer.session();
  std::optional<double> at;
  if (argument.empty()) {
    if (!session.slider()) at = kMiddle;
  } else if (argument != "off") {
    const auto number = parse_finite(argument);
    if (!number || *number < 0.0 || *number > 1.0)
      return core::fail("compare-slider: expected a number between 0 and 1, or off, found \"" + argument + "\"");
    at = *number;
  }
  if (at.has_value() != session.slider().has_value())
    if (auto free = viewer.scene_is_free(); !free) return free;
  return session.set_slider(at);
}

Json compare_json(const Session& session) {
  const ChangeList* changes = session.changes();
  if (!changes) return nullptr;
  const compare::Comparison& found = changes->found();
  Json json{{"file", changes->file()}};
  for (std::size_t i = 0; i < compare::kStateCount; ++i)
    json[std::string(compare::name_of(State(i)))] = found.counts[i];
  json.update({{"renamed", found.renamed},
               {"groups", found.nodes.size()},
               {"rows", changes->row_count()},
               {"current", changes->current() ? *changes->current() + 1 : 0},
               {"slider", session.slider() ? Json(*session.slider()) : Json()}});
  for (std::size_t i = 0; i < compare::kStateCount; ++i)
    json["shown"][std::string(compare::name_of(State(i)))] = changes->shown(State(i));
  return json;
}

}  // namespace sightline::apps
