// What commands need to have an effect, and what the user reads where that is missing. A menu shows such commands grey.
#pragma once

#include <vector>

#include "sightline/apps/view/workspace.h"

namespace sightline::apps {

struct Need {
  bool (*met)(Workspace& work);  ///< called while a model is open
  const char* missing;
};

/// What the user lacks; null where nothing is missing. All needs include an open model.
inline const char* missing(const Need& need, Workspace& work) {
  if (!work.session) return "open a model first";
  return need.met(work) ? nullptr : need.missing;
}

/// Groups the selection as clicks took it, up to the third group; as single items where these are two.
inline std::vector<Taken> parts_of_selection(const Workspace& work) {
  const auto selection = work.session->document.selection();
  const auto level = selection.size() == 2 ? SelectionLevel::kItem : work.shown.level;
  return groups_of(work.session->scene(), selection, level, 3);
}

namespace needs {

inline constexpr Need kModel{[](Workspace&) { return true; }, ""};
inline constexpr Need kSelection{[](Workspace& w) { return !w.session->document.selection().empty(); },
                                 "select something first: click on it"};
inline constexpr Need kTwoParts{[](Workspace& w) { return parts_of_selection(w).size() == 2; },
                                "select two parts or items first, the second one with Ctrl"};
inline constexpr Need kHidden{
    [](Workspace& w) { return w.session->document.hidden() > 0 || w.session->document.ghosts() > 0; },
    "nothing is hidden or faint"};
inline constexpr Need kUndo{[](Workspace& w) { return w.session->document.undo_steps() > 0; },
                            "there is nothing to undo"};
inline constexpr Need kRedo{[](Workspace& w) { return w.session->document.redo_steps() > 0; },
                            "there is nothing to do again"};
inline constexpr Need kFound{[](Workspace& w) { return w.session->tree.match_count() > 0; },
                             "find something first: Ctrl+F"};
inline constexpr Need kMarks{
    [](Workspace& w) { return !w.session->measuring.marks().empty() || !w.session->measuring.list().empty(); },
    "nothing is measured"};
inline constexpr Need kMarkups{[](Workspace& w) { return !w.session->marking.list().empty(); }, "nothing is marked up"};
inline constexpr Need kSection{[](Workspace& w) { return w.session->sections.selected().has_value(); },
                               "select a section first, in the tab Sections or by its handle"};
inline constexpr Need kFace{[](Workspace& w) { return w.gestures.context_face().has_value(); },
                            "there is no face there"};
inline constexpr Need kSections{[](Workspace& w) { return !w.session->sections.all().empty(); },
                                "there are no sections"};
inline constexpr Need kComparison{[](Workspace& w) { return w.session->changes() != nullptr; },
                                  "compare with an older revision first"};
inline constexpr Need kPath{[](Workspace& w) { return w.player.path().has_value(); },
                            "record a camera path first, or name a file of one"};

}  // namespace needs
}  // namespace sightline::apps
