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
void toolbar(Viewer& viewer);
float toolbar_height();             ///< pixels
void context_menu(Viewer& viewer);  ///< of the right mouse button, once Viewer::Shown::context says so
void tree_panel(Viewer& viewer);    ///< search and tree
void side_panel(Viewer& viewer);    ///< has the tabs
void splitters(Viewer& viewer);     ///< the panels' inner edges, which can be dragged
void properties_tab(Viewer& viewer);
void measure_tab(Viewer& viewer);
void sections_tab(Viewer& viewer);
void views_tab(Viewer& viewer);
void culling_tab(Viewer& viewer);
void compare_tab(Viewer& viewer);  ///< while something is compared
void measure_overlay(Viewer& viewer, const Part& part);
void section_overlay(Viewer& viewer, const Part& part);
void triad_overlay(Viewer& viewer);
void slider_overlay(Viewer& viewer, const Part& part);  ///< the line, and the files' names
void status_bar(Viewer& viewer);
void start_page(Viewer& viewer, const Part& part);  ///< in place of the image while no model is open or read
void dialog_window(Viewer& viewer);
void loading_window(Viewer& viewer);  ///< progress, and a button that cancels
void item_tip(Viewer& viewer, core::ItemId item);
/// The name of the item's node, or of the nearest one above it that has a name; without one the item's kind.
std::string item_name(const core::Scene& scene, core::ItemId item);

}  // namespace sightline::apps
