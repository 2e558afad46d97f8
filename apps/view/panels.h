// The viewer's panels, drawn anew each frame by Dear ImGui.
#pragma once

#include "sightline/apps/view/workspace.h"

namespace sightline::apps {

/// Pixels that the panels take from the window's sides.
struct Margins {
  int left = 0, right = 0, top = 0, bottom = 0;
};
Margins margins(const Shown& shown);

void menu_bar(Workspace& work);
void toolbar(Workspace& work);
float toolbar_height();              ///< pixels
void context_menu(Workspace& work);  ///< of the right mouse button, once Shown::context says so
void tree_panel(Workspace& work);    ///< search and tree
void side_panel(Workspace& work);    ///< has the tabs
void splitters(Shown& shown);        ///< the panels' inner edges, which can be dragged
void properties_tab(Workspace& work);
void measure_tab(Workspace& work);
void mark_tab(Workspace& work);
void sections_tab(Workspace& work);
void views_tab(Workspace& work);
void culling_tab(Workspace& work);
void attributes_tab(Workspace& work);
void compare_tab(Workspace& work);  ///< while something is compared
void measure_overlay(Workspace& work, const Part& part);
void markup_overlay(Workspace& work, const Part& part);
void rectangle_overlay(const Workspace& work);  ///< that is being dragged to select
void section_overlay(Workspace& work, const Part& part);
void colour_legend(Workspace& work, const Part& part);
void triad_overlay(Workspace& work);
void slider_overlay(Workspace& work, const Part& part);  ///< the line, and the files' names
void status_bar(Workspace& work);
void start_page(Workspace& work, const Part& part);  ///< in place of the image while no model is open or read
void dialog_window(Workspace& work);
void loading_window(Opening& opening, const Messages& messages);  ///< progress, and a button that cancels
void taken_tip(const core::Scene& scene, const Taken& taken);     ///< what a click would take
/// The name of the item's node, or of the nearest one above it that has a name; without one the item's kind.
std::string item_name(const core::Scene& scene, core::ItemId item);

}  // namespace sightline::apps
