// The viewer's panels, drawn anew each frame by Dear ImGui.
#pragma once

#include "sightline/apps/view/viewer.h"

namespace sightline::apps {

/// Pixels that the panels take from the window's sides.
struct Margins {
  int left = 0, right = 0, top = 0, bottom = 0;
};
Margins margins(const Viewer& viewer);

void menu_bar(Viewer& viewer);
void tree_panel(Viewer& viewer);  ///< search and tree
void side_panel(Viewer& viewer);  ///< has the tabs
void splitters(Viewer& viewer);   ///< the panels' inner edges, which can be dragged
void properties_tab(Viewer& viewer);
void measure_tab(Viewer& viewer);
void sections_tab(Viewer& viewer);
void views_tab(Viewer& viewer);
void culling_tab(Viewer& viewer);
void compare_tab(Viewer& viewer);  ///< while something is compared
void measure_overlay(Viewer& viewer, const Part& part);
void section_overlay(Viewer& viewer, const Part& part);
void triad_overlay(Viewer& viewer);
void status_bar(Viewer& viewer);
void dialog_window(Viewer& viewer);
void loading_window(Viewer& viewer);  ///< progress, and a button that cancels
void item_tip(Viewer& viewer, core::ItemId item);

}  // namespace sightline::apps
