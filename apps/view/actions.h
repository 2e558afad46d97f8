// Declares what the viewer's commands, dialogs and panels do. Functions that take a session or the workspace are called
// while a model is open, unless they check for it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sightline/apps/view/workspace.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

// Parts of the model that are named.

/// Shows in the tree the parts that a text names; fails where it names none.
Done find_parts(const std::string& text, Session& session, Messages& messages);
/// Selects the items of the parts that the search names.
Done select_found(const std::string&, Session& session, Messages& messages);
/// The items of the parts that a text names, in rising order; fails where there are none.
core::Expected<std::vector<core::ItemId>> items_named(const std::string& text, Session& session, Messages& messages);
/// Selects the items of the parts that a text names, or for which its conditions hold.
Done select_named(const std::string& text, Session& session, Messages& messages);
/// Keeps a search as a set, or the text of the search field; or forgets one.
Done keep_set(const std::string& text, Session& session, Shown& shown, Messages& messages);
Done remove_set(const std::string& text, Shown& shown);
/// Colours items by an attribute. Without a key, shows the model's own colours again, or the attributes to choose from.
Done colour_by_or_ask(const std::string& key, Session& session, Shown& shown, Messages& messages);
/// What is known of the selection, as a table: into the clipboard, and into a CSV file; without a name into the next
/// free one.
Done copy_properties(Workspace& work, const std::string&);
Done save_properties(const std::string& file, Session& session, Messages& messages);
/// Hides the items of a part, or shows them if all are hidden. A text that ends in "?nth=…" or "?item=…" is a name as
/// views have it.
Done toggle_part(const std::string& text, Session& session, Messages& messages);

// Single sections. N: the number that the tab shows, from 1; without it the selected one.

/// The index of what a number from 1 on names in a list.
core::Expected<std::size_t> numbered(const char* what, const std::string& number, std::size_t count);
/// Cuts away what lies in front of a face. Fails where there is none, or no room for another section.
Done cut_at(const core::Expected<std::optional<engine::Pick>>& face, Session& session, Shown& shown);
/// Cuts the model in halves across an axis.
Done cut_middle(int axis, Session& session, Shown& shown);
Done select_section(const std::string& number, Session& session);  ///< 0: none
Done flip_section(const std::string& number, Session& session);
Done move_section(const std::string& number_and_metres, Session& session);
Done remove_section(const std::string& number, Session& session);

// The list of viewpoints. An empty name or number stands for the current view.

Done add_view(Workspace& work, const std::string& name);
Done show_view(const std::string& which, Session& session, ViewList& views, Messages& messages);
Done update_view(Workspace& work, const std::string&);
Done rename_view(const std::string& name, ViewList& views);
Done comment_view(const std::string& text, ViewList& views);
Done set_view_status(const std::string& text, ViewList& views);
Done set_view_type(const std::string& text, ViewList& views);
Done delete_view(const std::string& which, ViewList& views);
/// Without a name, these two ask for one.
Done save_views(const std::string& file, ViewList& views, Shown& shown, Messages& messages);
/// Adds the views of a file to the list, which stays as it is where that fails.
Done load_views(const std::string& file, ViewList& views, Shown& shown, Messages& messages);

/// Writes what is seen and shown to a file that --view of other tools reads; without a name, to the next free one.
Done save_view(const std::string& file, Session& session, Messages& messages);
/// Shows the view of a file, or adds its views to the list.
Done load_view(const std::string& file, Session& session, ViewList& views, Shown& shown, Messages& messages);

/// For example "screenshot-1.png", or the next number that no file has.
std::string free_name(const std::string& stem, const std::string& extension);

// The comparison with an older revision.

/// Without a name, asks for a file.
Done compare_with(Workspace& work, const std::string& file);
Done end_comparison(Workspace& work, const std::string&);
/// Shows or hides items that are "added", "removed", …
Done toggle_changes(const std::string& state, Session& session);
Done next_change(const std::string&, Session& session);
Done previous_change(const std::string&, Session& session);

/// Writes what has changed, as sightline-compare does: .html, .csv, .json, .bcfzip or .bcf.
Done save_comparison(const std::string& file, Session& session, Messages& messages);

/// "0.3", of the image's width, or "off"; without an argument the other of both. Fails while somebody reads the scene.
Done set_slider(Workspace& work, const std::string& argument);

/// For state_json(); null while nothing is compared.
json::Value compare_json(const Session& session);

/// Says in words what has changed.
std::string summary(const ChangeList& changes);

// Mark-ups.

/// Draws one: parse_markup(). Without an argument, takes the tool or puts it away.
Done mark(Workspace& work, const std::string& argument);
Done remove_markup(const std::string& number, Session& session);
/// Whether a drag draws a mark-up, instead of moving the camera.
bool draws_markup(const Workspace& work, const Gestures::Drag& drag);
/// The one that such a drag draws.
core::Expected<Markup> markup_of(const Workspace& work, const Gestures::Drag& drag);
/// Draws it, at the end of the drag.
void mark_dragged(Workspace& work, const Gestures::Drag& drag);
/// Places a text, or says how others are drawn.
void mark_clicked(Workspace& work, const core::dvec2& at);

// Images, camera paths and frames of videos.

/// "FILE [WxH]", both optional: in the window's size at once, or in any size in steps.
Done write_image(Workspace& work, const std::string& argument);
/// Writes the image at once, in the window's size; without a name the next free one.
Done write_screenshot(Workspace& work, const std::string& file);
/// "transparent", "white" or another colour as --background takes it, or "shown": for images that are written.
Done image_background(Workspace& work, const std::string& colours);
/// Begins to record a camera path, or ends that and writes it.
Done toggle_recording(Workspace& work, const std::string&);
/// "FILE", or nothing for the path that was played or recorded last.
Done play_path(const std::string& file, Session& session, PathPlayer& player, Gestures& gestures, Messages& messages);
Done set_path_speed(const std::string& factor, PathPlayer& player);
/// "FOLDER [FPS] [WxH]": frames of the path that was played or recorded last.
Done write_frames(Workspace& work, const std::string& argument);

/// The path that was played or recorded last, in the model's own frame. Without a name the dialog asks for one.
Done save_path(const std::string& file, Session& session, PathPlayer& player, Shown& shown, Messages& messages);

void image_options(Workspace& work);  ///< size of the image, and whether it has marks
/// In the sizes that dialogs have asked for.
Done write_sized_image(Workspace& work, const std::string& file);
Done write_sized_frames(Workspace& work, const std::string& folder);
void path_window(Workspace& work);        ///< plays a path, and writes its frames
void exporting_window(Exports& exports);  ///< progress, and a button that cancels

// What is open.

/// Keeps what is open and how it is seen in a file; without a name, asks for one.
Done save_session(Workspace& work, const std::string& file);
/// Opens a model beside those that are open, which are seen as before; without a name, asks for one.
Done append_model(Workspace& work, const std::string& file);
Done append_models(Workspace& work, const std::vector<std::string>& files);
/// Shows the session whose models have been opened as it was.
Done show_returning(Workspace& work);

// Export of the model and of the selection.

/// Without a name, asks for a file.
Done export_model(Workspace& work, const std::string& file);
Done export_selection(Workspace& work, const std::string& file);

/// These two say, below the file's name in their dialogs, what will be written.
void export_model_options(Workspace& work);
void export_selection_options(Workspace& work);
/// "plant" or "selection" in the format of what is open where that can be written.
std::string export_name(const Workspace& work, const char* stem);

}  // namespace sightline::apps
