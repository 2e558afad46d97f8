#include <filesystem>
#include <optional>
#include <span>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/needs.h"
#include "sightline/core/internal/ascii_case.h"
#include "sightline/core/internal/atomic_file.h"
#include "sightline/core/internal/platform/files.h"

namespace sightline::apps {
namespace {

namespace fs = std::filesystem;
using compare::State;
using Json = json::Value;

core::Expected<ChangeList*> changes_of(Session& session) {
  ChangeList* changes = session.changes();
  return changes ? core::Expected<ChangeList*>(changes) : core::fail(needs::kComparison.missing);
}

Done step(Session& session, int by) {
  const auto changes = changes_of(session);
  if (!changes) return tl::unexpected(changes.error());
  const auto row = (*changes)->step(by);
  if (!row) return core::fail("there are no changes to go to");
  return go_to_change(session, *row);
}

}  // namespace

std::string summary(const ChangeList& changes) {
  const std::string file = std::filesystem::path(changes.file()).filename().string();
  const std::string but = changes.found().with_attributes ? "" : "; attributes are not compared: one revision has none";
  if (changes.found().same()) return "nothing has changed since " + file + but;
  std::string text = "since " + file + ":";
  for (const State state : {State::kAdded, State::kRemoved, State::kMoved, State::kChanged})
    text += (state == State::kAdded ? " " : ", ") + grouped(std::int64_t(changes.found().count(state))) + " " +
            std::string(compare::name_of(state));
  return text + but;
}

Done compare_with(Workspace& work, const std::string& file) {
  if (file.empty()) return work.shown.dialog = Dialog::kCompare, Done();
  if (auto done = work.show_own_meshes(); !done) return done;
  work.opening.compare(file, *work.session);
  if (work.shown.dialog == Dialog::kCompare) work.shown.dialog = Dialog::kNone;
  work.messages.tell("comparing with " + std::filesystem::path(file).filename().string());
  return {};
}

Done end_comparison(Workspace& work, const std::string&) {
  if (auto free = work.scene_is_free(); !free) return free;
  if (const auto changes = changes_of(*work.session); !changes) return tl::unexpected(changes.error());
  return work.session->end_comparison().map([&] { work.messages.tell("the comparison has ended"); });
}

Done toggle_changes(const std::string& name, Session& session) {
  const auto changes = changes_of(session);
  if (!changes) return tl::unexpected(changes.error());
  for (std::size_t i = 0; i < compare::kStateCount; ++i)
    if (compare::name_of(State(i)) == name) return session.show_changes(State(i), !(*changes)->shown(State(i)));
  return core::fail("expected added, removed, moved, changed or unchanged, found \"" + name + "\"");
}

Done next_change(const std::string&, Session& session) {
  return step(session, 1);
}

Done previous_change(const std::string&, Session& session) {
  return step(session, -1);
}

Done save_comparison(const std::string& file, Session& session, Messages& messages) {
  const auto changes = changes_of(session);
  if (!changes) return tl::unexpected(changes.error());
  const std::string name = file.empty() ? free_name("changes", ".html") : file;
  const fs::path path = core::platform::path_of(name);
  const auto report = (*changes)->report(core::lower_case(path.extension().string()), *session.model().scene);
  if (!report) return core::fail(name + ": " + report.error().message);
  if (auto done = core::write_file(path, {std::as_bytes(std::span(*report))}); !done) return done;
  messages.tell("comparison: " + name);
  return {};
}

Done set_slider(Workspace& work, const std::string& argument) {
  constexpr double kMiddle = 0.5;
  Session& session = *work.session;
  if (const auto changes = changes_of(session); !changes) return tl::unexpected(changes.error());
  std::optional<double> at;
  if (argument.empty()) {
    if (!session.slider.at()) at = kMiddle;
  } else if (argument != "off") {
    const auto number = parse_finite(argument);
    if (!number || *number < 0.0 || *number > 1.0)
      return core::fail("compare-slider: expected a number between 0 and 1, or off, found \"" + argument + "\"");
    at = *number;
  }
  if (at.has_value() != session.slider.at().has_value())
    if (auto free = work.scene_is_free(); !free) return free;
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
               {"slider", session.slider.at() ? Json(*session.slider.at()) : Json()}});
  for (std::size_t i = 0; i < compare::kStateCount; ++i)
    json["shown"][std::string(compare::name_of(State(i)))] = changes->shown(State(i));
  return json;
}

}  // namespace sightline::apps
