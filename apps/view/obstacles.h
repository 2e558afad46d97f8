// Why commands have no effect now, in words for the user; null where they have one. A menu shows such commands grey.
#pragma once

namespace sightline::apps {

class Viewer;

const char* without_model(Viewer& viewer);
const char* without_selection(Viewer& viewer);
const char* without_two_items(Viewer& viewer);
const char* without_hidden(Viewer& viewer);  ///< nor faint ones
const char* without_undo(Viewer& viewer);
const char* without_redo(Viewer& viewer);
const char* without_found(Viewer& viewer);
const char* without_marks(Viewer& viewer);
const char* without_section(Viewer& viewer);  ///< selected
const char* without_face(Viewer& viewer);     ///< below the context menu
const char* without_sections(Viewer& viewer);
const char* without_comparison(Viewer& viewer);
const char* without_path(Viewer& viewer);

}  // namespace sightline::apps
