#include "sightline/apps/view/obstacles.h"

#include "sightline/apps/view/viewer.h"

namespace sightline::apps {
namespace {

const char* unless(Viewer& viewer, bool (*possible)(Viewer&), const char* why) {
  if (const char* first = without_model(viewer)) return first;
  return possible(viewer) ? nullptr : why;
}

Document& document(Viewer& viewer) {
  return viewer.session()->document();
}

}  // namespace

const char* without_model(Viewer& viewer) {
  return viewer.session() ? nullptr : "open a model first";
}

const char* without_selection(Viewer& viewer) {
  const auto possible = [](Viewer& v) { return !document(v).selection().empty(); };
  return unless(viewer, possible, "select something first: click on it");
}

const char* without_two_items(Viewer& viewer) {
  const auto possible = [](Viewer& v) { return document(v).selection().size() == 2; };
  return unless(viewer, possible, "select two items first, the second one with Ctrl");
}

const char* without_hidden(Viewer& viewer) {
  const auto possible = [](Viewer& v) { return document(v).hidden() > 0 || document(v).ghosts() > 0; };
  return unless(viewer, possible, "nothing is hidden or faint");
}

const char* without_undo(Viewer& viewer) {
  return unless(
      viewer, [](Viewer& v) { return document(v).undo_steps() > 0; }, "there is nothing to undo");
}

const char* without_redo(Viewer& viewer) {
  return unless(
      viewer, [](Viewer& v) { return document(v).redo_steps() > 0; }, "there is nothing to do again");
}

const char* without_found(Viewer& viewer) {
  const auto possible = [](Viewer& v) { return v.session()->tree().match_count() > 0; };
  return unless(viewer, possible, "find something first: Ctrl+F");
}

const char* without_marks(Viewer& viewer) {
  const auto possible = [](Viewer& v) {
    const Measuring& measuring = v.session()->measuring();
    return !measuring.marks().empty() || !measuring.list().empty();
  };
  return unless(viewer, possible, "nothing is measured");
}

const char* without_section(Viewer& viewer) {
  const auto possible = [](Viewer& v) { return v.session()->sections().selected().has_value(); };
  return unless(viewer, possible, "select a section first, in the tab Sections or by its handle");
}

const char* without_face(Viewer& viewer) {
  return unless(
      viewer, [](Viewer& v) { return v.context_face().has_value(); }, "there is no face there");
}

const char* without_sections(Viewer& viewer) {
  return unless(
      viewer, [](Viewer& v) { return !v.session()->sections().all().empty(); }, "there are no sections");
}

const char* without_comparison(Viewer& viewer) {
  return unless(
      viewer, [](Viewer& v) { return v.session()->changes() != nullptr; }, "compare with an older revision first");
}

const char* without_path(Viewer& viewer) {
  return unless(
      viewer, [](Viewer& v) { return v.player().path().has_value(); },
      "record a camera path first, or name a file of one");
}

}  // namespace sightline::apps
