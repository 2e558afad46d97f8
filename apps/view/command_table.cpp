// The table of commands, in the order of menus and toolbar, and what they do.

#include <vector>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/view/commands.h"
#include "sightline/apps/view/comparing.h"
#include "sightline/apps/view/exporting.h"
#include "sightline/apps/view/icons.h"
#include "sightline/apps/view/model_exporting.h"
#include "sightline/apps/view/obstacles.h"
#include "sightline/apps/view/section_commands.h"
#include "sightline/apps/view/views.h"

namespace sightline::apps {
namespace {

using engine::CullerChoice;
using Done = core::Expected<void>;

constexpr int kCtrl = GLFW_MOD_CONTROL, kShift = GLFW_MOD_SHIFT, kAlt = GLFW_MOD_ALT;

template <class Work>
Done move_camera(Viewer& viewer, const Work& work) {
  viewer.session()->remember();
  work(viewer.session()->camera());
  return {};
}

Done look_along(Viewer& viewer, const core::dvec3& direction) {
  Session& session = *viewer.session();
  session.remember();
  session.show_all(direction);
  return {};
}

Done focus(Viewer& viewer, const std::string&) {
  Session& session = *viewer.session();
  const auto selection = session.document().selection();
  if (selection.empty()) return session.remember(), session.show_all(), Done();
  const core::AabbD bounds = session.document().bounds(selection);
  return move_camera(viewer, [&](Camera& camera) { camera.fit(bounds, session.aspect()); });
}

template <int kNotches>
Done zoom(Viewer& viewer, const std::string&) {
  return move_camera(viewer, [](Camera& camera) { camera.zoom(kNotches, camera.pose().target); });
}

template <CullerChoice kChoice>
Done cull(Viewer& viewer, const std::string&) {
  return viewer.session()->set_culler(kChoice);
}

/// A function of the document that takes the parts that are named, or the selection, which must not be empty.
template <Done (Document::*kFunction)(std::span<const core::ItemId>)>
Done with_selection(Viewer& viewer, const std::string& part) {
  Document& document = viewer.session()->document();
  if (!part.empty()) {
    const auto named = viewer.items_named(part);
    return named ? (document.*kFunction)(*named) : Done(tl::unexpected(named.error()));
  }
  if (const char* why = without_selection(viewer)) return core::fail(why);
  const std::vector<core::ItemId> items(document.selection().begin(), document.selection().end());
  return (document.*kFunction)(items);
}

Done select_all(Viewer& viewer, const std::string&) {
  Document& document = viewer.session()->document();
  return document.select(document.items_below(viewer.session()->scene().root()));
}

Done measure_selected(Viewer& viewer, const std::string&) {
  Session& session = *viewer.session();
  const auto selection = session.document().selection();
  if (const char* why = without_two_items(viewer)) return core::fail(why);
  viewer.shown.tab = "Measure";
  return session.measuring().between(session.scene(), selection[0], selection[1]);
}

/// A switch of a dialog.
template <Dialog kDialog>
Done toggle(Viewer& viewer, const std::string&) {
  viewer.shown.dialog = viewer.shown.dialog == kDialog ? Dialog::kNone : kDialog;
  return {};
}
template <Dialog kDialog>
bool shows(Viewer& viewer) {
  return viewer.shown.dialog == kDialog;
}

template <Tool kTool>
Done take_tool(Viewer& viewer, const std::string&) {
  viewer.shown.tool = viewer.shown.tool == kTool ? Tool::kSelect : kTool;
  if (viewer.shown.tool == Tool::kMeasure) viewer.shown.tab = "Measure";
  if (viewer.shown.tool == Tool::kSection) viewer.tell("click on a face: what lies in front of it is cut away");
  return {};
}
template <Tool kTool>
bool has_tool(Viewer& viewer) {
  return viewer.shown.tool == kTool;
}

template <Units kUnits>
Done set_units(Viewer& viewer, const std::string&) {
  viewer.shown.units = kUnits;
  return {};
}
template <Units kUnits>
bool has_units(Viewer& viewer) {
  return viewer.shown.units == kUnits;
}

Done section_here(Viewer& viewer, const std::string&) {
  return cut_at(viewer, viewer.under_cursor());
}

template <int kAxis>
Done cut_across(Viewer& viewer, const std::string&) {
  return cut_middle(viewer, kAxis);
}

Done copy_measurements(Viewer& viewer, const std::string&) {
  const Session& session = *viewer.session();
  const std::vector<Measurement>& list = session.measuring().list();
  viewer.set_clipboard(measurement_table(list, session.offset(), viewer.lengths()));
  viewer.tell("copied: " + std::to_string(list.size()) + " measurements");
  return {};
}

Done remove_measurement(Viewer& viewer, const std::string& number) {
  Measuring& measuring = viewer.session()->measuring();
  for (std::size_t i = 0; i < measuring.list().size(); ++i)
    if (number == std::to_string(i + 1)) return measuring.remove(i), Done();
  return core::fail("there is no measurement " + number + ": there are " + std::to_string(measuring.list().size()));
}

Done select_finding(Viewer& viewer, const std::string& number) {
  const std::vector<Finding>& all = viewer.session()->findings();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (number == std::to_string(i + 1)) return viewer.session()->document().select(all[i].items);
  return core::fail("there is no finding " + number + ": there are " + std::to_string(all.size()));
}

Done section_at(Viewer& viewer, const std::string&) {
  return cut_at(viewer, viewer.context_face());
}

Done section_box(Viewer& viewer, const std::string&) {
  Session& session = *viewer.session();
  const auto selection = session.document().selection();
  const core::AabbD bounds = selection.empty() ? session.bounds().bounds : session.document().bounds(selection);
  if (!bounds.empty()) session.sections().box(bounds);
  viewer.shown.tab = "Sections";
  return {};
}

/// Toggles the boxes of all states, or of the one that is named.
Done toggle_boxes(Viewer& viewer, const std::string& state) {
  CullingSwitches& switches = viewer.culling().switches;
  if (state.empty()) return switches.boxes = !switches.boxes, Done();
  for (int i = 0; i < culling::kCullStateCount; ++i) {
    if (name_of(culling::CullState(i)) != state) continue;
    bool& on = switches.states[std::size_t(i)];
    return on = !on, Done();
  }
  return core::fail("boxes: expected inside, intersecting, outside, occluded or too_small, found \"" + state + "\"");
}

/// A setting of the engine, by a script.
Done set_number(Viewer& viewer, const std::string& text, void (*set)(engine::EngineConfig&, double)) {
  const auto number = parse_finite(text);
  if (!number) return tl::unexpected(number.error());
  return viewer.session()->configure([&](engine::EngineConfig& config) { set(config, *number); });
}

const Command kFile[] = {
    {"open", "File", "Open…", GLFW_KEY_O, kCtrl, "Ctrl+O", "open files, instead of what is open: FILE",
     [](Viewer& v, const std::string& file) -> Done {
       if (file.empty())
         v.shown.dialog = Dialog::kOpen;
       else
         v.open({file});
       return {};
     },
     nullptr, nullptr, icons::kOpen},
    {"recognise", "File", "Recognise primitives", 0, 0, "",
     "switch whether cylinders, boxes and their like are taken out of the meshes of files that are opened "
     "from now on",
     [](Viewer& v, const std::string&) -> Done { return v.shown.recognise = !v.shown.recognise, Done(); },
     [](Viewer& v) { return v.shown.recognise; }, nullptr},
    {"y-up", "File", "Y is up", 0, 0, "",
     "switch which axis points up in files that do not say (OBJ, PLY, STL, VTK), and read those that are open again",
     [](Viewer& v, const std::string&) -> Done { return v.toggle_up(), Done(); }, [](Viewer& v) { return v.y_is_up(); },
     nullptr},
    {"screenshot", "|File", "Save image", GLFW_KEY_F12, 0, "F12",
     "write the image that is shown, PNG: FILE [WxH], up to 16384x16384", write_image, nullptr, without_model,
     icons::kCamera},
    {"large-image", "File", "Save image as…", GLFW_KEY_F12, kShift, "Shift+F12",
     "ask for a size and a file, and write the image", toggle<Dialog::kImage>, shows<Dialog::kImage>},
    {"save-view", "|File", "Save view", GLFW_KEY_S, kCtrl, "Ctrl+S", "write what is seen and shown, JSON: FILE",
     [](Viewer& v, const std::string& file) { return v.save_view(file); }},
    {"load-view", nullptr, "", 0, 0, "", "see what a view file shows; or drop it on the window: FILE",
     [](Viewer& v, const std::string& file) { return v.load_view(file); }},
    {"export-model", "|File", "Export model…", 0, 0, "",
     "write all of the model, RVM, OBJ, glTF or a scene cache: FILE", export_model, shows<Dialog::kExportModel>},
    {"export-selection", "File", "Export selection…", 0, 0, "", "write what is selected, in the same formats: FILE",
     export_selection, shows<Dialog::kExportSelection>, without_selection},
    {"record", "|File/Camera path", "Record camera path", GLFW_KEY_R, 0, "R",
     "begin to record a camera path; end and write it",
     [](Viewer& v, const std::string&) { return v.toggle_recording(); }, [](Viewer& v) { return v.recording(); }},
    {"play-path", "File/Camera path", "Play camera path", 0, 0, "",
     "play a camera path, or that played or recorded last; or stop: FILE", play_path,
     [](Viewer& v) { return v.player().playing(); }, without_path},
    {"save-path", "File/Camera path", "Save camera path…", 0, 0, "",
     "write the camera path that was played or recorded last: FILE", save_path, nullptr, without_path},
    {"path-loop", nullptr, "", 0, 0, "", "play camera paths again and again, or once",
     [](Viewer& v, const std::string&) -> Done { return v.player().loop = !v.player().loop, Done(); }},
    {"path-speed", nullptr, "", 0, 0, "", "how fast camera paths play, times their own speed: FACTOR", set_path_speed},
    {"camera-path", "File/Camera path", "Camera path and video…", 0, 0, "",
     "ask for a camera path to play, and write its frames", toggle<Dialog::kPath>, shows<Dialog::kPath>},
    {"write-frames", nullptr, "", 0, 0, "",
     "write that path as images for a video, 25 a second unless told otherwise: FOLDER [FPS] [WxH]", write_frames},
    {"quit", "|File", "Quit", GLFW_KEY_Q, kCtrl, "Ctrl+Q", "end the program",
     [](Viewer& v, const std::string&) -> Done { return v.quit(), Done(); }, nullptr, nullptr},
    {"lose-context", nullptr, "", 0, 0, "", "make window and graphics context anew, as after a reset of the driver",
     [](Viewer& v, const std::string&) -> Done { return v.lose_context(), Done(); }, nullptr, nullptr},
};

const Command kEdit[] = {
    {"undo", "Edit", "Undo", GLFW_KEY_Z, kCtrl, "Ctrl+Z", "undo the last change of selection and visibility",
     [](Viewer& v, const std::string&) { return v.session()->document().undo(); }, nullptr, without_undo},
    {"redo", "Edit", "Redo", GLFW_KEY_Z, kCtrl | kShift, "Ctrl+Shift+Z", "do again what was undone",
     [](Viewer& v, const std::string&) { return v.session()->document().redo(); }, nullptr, without_redo},
    {"find", "|Edit", "Find", GLFW_KEY_F, kCtrl, "Ctrl+F", "show the parts that a text names: PART",
     [](Viewer& v, const std::string& text) -> Done {
       if (!text.empty()) return v.find(text);
       v.shown.find = v.shown.panels = true;  // what was searched for last stays, to be changed
       return {};
     }},
    {"select-found", "Edit", "Select what was found", 0, 0, "", "select what is below the parts that a search names",
     [](Viewer& v, const std::string&) { return v.select_found(); }, nullptr, without_found},
    {"select", "|Edit", "Select", 0, 0, "", "clicks select items again, and no longer measure or cut",
     [](Viewer& v, const std::string&) -> Done { return v.shown.tool = Tool::kSelect, Done(); },
     has_tool<Tool::kSelect>, without_model, icons::kCursor},
    {"select-all", "Edit", "Select all", GLFW_KEY_A, kCtrl, "Ctrl+A", "select all that is not hidden", select_all},
    {"select-part", "Edit", "Select the whole part", GLFW_KEY_UP, kCtrl, "Ctrl+Up",
     "select all of the part that the selection belongs to; again: of the one above",
     [](Viewer& v, const std::string&) { return v.session()->document().select_part(); }, nullptr, without_selection},
    {"select-none", "Edit", "Select nothing", 0, 0, "", "select nothing",
     [](Viewer& v, const std::string&) { return v.session()->document().select({}); }, nullptr, without_selection},
    {"escape", nullptr, "", GLFW_KEY_ESCAPE, 0, "Esc",
     "close the topmost menu or dialog; else end what clicks or keys do otherwise; else select nothing",
     [](Viewer& v, const std::string&) -> Done { return v.escape(), Done(); }, nullptr, nullptr},
    {"hide", "|Edit", "Hide", GLFW_KEY_H, 0, "H", "hide what is selected, or a part: PART",
     with_selection<&Document::hide>, nullptr, without_selection, icons::kEyeCrossed},
    {"isolate", "Edit", "Isolate", GLFW_KEY_I, 0, "I", "hide all but what is selected, or a part: PART",
     with_selection<&Document::isolate>, nullptr, without_selection, icons::kIsolate},
    {"ghost-others", "Edit", "Make the rest faint", GLFW_KEY_G, 0, "G",
     "make all but what is selected faint, or a part: PART", with_selection<&Document::ghost_others>, nullptr,
     without_selection},
    {"toggle-part", nullptr, "", 0, 0, "", "hide what lies below a part, or show it if it is hidden: PART",
     [](Viewer& v, const std::string& path) { return v.toggle_part(path); }},
    {"select-finding", nullptr, "", 0, 0, "", "select the items of what the tab Item says is odd about the model: N",
     select_finding},
    {"show-all", "Edit", "Show all", GLFW_KEY_U, 0, "U", "show what is hidden or faint",
     [](Viewer& v, const std::string&) { return v.session()->document().show_all(); }, nullptr, without_hidden,
     icons::kEye},
};

const Command kView[] = {
    {"fit", "View", "Fit all", GLFW_KEY_HOME, 0, "Home", "see the whole model from above",
     [](Viewer& v, const std::string&) { return look_along(v, core::kOverviewDirection); }, nullptr, without_model,
     icons::kFit},
    {"focus", "View", "Focus on selection", GLFW_KEY_F, 0, "F", "fit what is selected, or the whole model", focus,
     nullptr, without_model, icons::kFocus},
    {"front", "View/Look from", "Front", GLFW_KEY_1, 0, "1", "look north",
     [](Viewer& v, const std::string&) {
       return look_along(v, {0, 1, 0});
     },
     nullptr, without_model, icons::kFront},
    {"back", "View/Look from", "Back", GLFW_KEY_2, 0, "2", "look south",
     [](Viewer& v, const std::string&) {
       return look_along(v, {0, -1, 0});
     },
     nullptr, without_model, icons::kBack},
    {"left", "View/Look from", "Left", GLFW_KEY_3, 0, "3", "look east",
     [](Viewer& v, const std::string&) {
       return look_along(v, {1, 0, 0});
     },
     nullptr, without_model, icons::kLeft},
    {"right", "View/Look from", "Right", GLFW_KEY_4, 0, "4", "look west",
     [](Viewer& v, const std::string&) {
       return look_along(v, {-1, 0, 0});
     },
     nullptr, without_model, icons::kRight},
    {"top", "View/Look from", "Top", GLFW_KEY_5, 0, "5", "look down",
     [](Viewer& v, const std::string&) {
       return look_along(v, {0, 0, -1});
     },
     nullptr, without_model, icons::kTop},
    {"bottom", "View/Look from", "Bottom", GLFW_KEY_6, 0, "6", "look up",
     [](Viewer& v, const std::string&) {
       return look_along(v, {0, 0, 1});
     },
     nullptr, without_model, icons::kBottom},
    {"zoom-in", nullptr, "", GLFW_KEY_KP_ADD, 0, "Keypad +", "come nearer to the middle", zoom<1>},
    {"zoom-out", nullptr, "", GLFW_KEY_KP_SUBTRACT, 0, "Keypad -", "go away from it", zoom<-1>},
    {"camera-back", "View", "Camera back", GLFW_KEY_BACKSPACE, 0, "Backspace", "put the camera back to where it was",
     [](Viewer& v, const std::string&) -> Done { return v.session()->camera_back(), Done(); }},
    {"orthographic", "|View", "Parallel projection", GLFW_KEY_P, 0, "P",
     "switch between parallel and perspective projection",
     [](Viewer& v, const std::string&) {
       return move_camera(v, [](Camera& camera) { camera.set_orthographic(!camera.orthographic()); });
     },
     [](Viewer& v) { return v.session()->camera().orthographic(); }, without_model, icons::kPerspective},
    {"walk", "View", "Walk", GLFW_KEY_K, 0, "K", "walk on floors and up stairs, and be stopped by walls; or fly again",
     [](Viewer& v, const std::string&) -> Done { return v.set_walking(!v.walking()), Done(); },
     [](Viewer& v) { return v.walking(); }, without_model, icons::kWalk},
    {"view-add", "|View", "Add to the views", GLFW_KEY_V, 0, "V", "keep what is seen as a view of the list: NAME",
     add_view},
    {"view-show", nullptr, "", 0, 0, "", "show a view of the list: NAME or number", show_view},
    {"view-update", nullptr, "", 0, 0, "", "make the current view what is seen now", update_view},
    {"view-rename", nullptr, "", 0, 0, "", "name the current view: NAME", rename_view},
    {"view-comment", nullptr, "", 0, 0, "", "comment the current view: TEXT", comment_view},
    {"view-delete", nullptr, "", 0, 0, "", "take a view from the list: NAME or number, or the current one",
     delete_view},
    {"views-save", "View", "Save all views…", 0, 0, "", "write all views, BCF 2.1 (.bcfzip, .bcf) or JSON: FILE",
     save_views},
    {"views-load", "View", "Load views…", 0, 0, "", "add the views of a file, or drop it on the window: FILE",
     load_views},
    {"depth-shading", "|View/Shapes", "Depth shading and edge lines", GLFW_KEY_L, 0, "L",
     "switch the shading and the lines that make shapes of one colour legible on or off",
     [](Viewer& v, const std::string&) { return v.toggle_depth_shading(); },
     [](Viewer& v) { return v.shown.depth_shading; }, nullptr},
    {"smooth", "View/Shapes", "Smooth edges at rest", 0, 0, "",
     "switch smooth edges, which come when nothing moves, on or off",
     [](Viewer& v, const std::string&) -> Done { return v.shown.smooth = !v.shown.smooth, Done(); },
     [](Viewer& v) { return v.shown.smooth; }, nullptr},
    {"hatch", "View/Shapes", "Hatching of cut faces", 0, 0, "", "switch the lines across what sections cut on or off",
     [](Viewer& v, const std::string&) { return v.toggle_hatching(); }, [](Viewer& v) { return v.shown.hatching; },
     nullptr},
    {"lower-resolution", "View/Shapes", "Lower resolution in motion", 0, 0, "",
     "switch whether images have fewer pixels while the view moves and frames come late",
     [](Viewer& v, const std::string&) -> Done { return v.shown.lower = !v.shown.lower, Done(); },
     [](Viewer& v) { return v.shown.lower; }, nullptr},
    {"levels", "View/Shapes", "Coarser meshes in motion", 0, 0, "",
     "switch whether meshes are drawn by levels of detail while the view moves",
     [](Viewer& v, const std::string&) { return v.toggle_levels(); }, [](Viewer& v) { return v.shown.levels; },
     nullptr},
    {"lod-error", nullptr, "", 0, 0, "", "pixels by which meshes may lie elsewhere while the view moves: PX",
     [](Viewer& v, const std::string& text) -> Done {
       const auto pixels = parse_finite(text);
       if (!pixels) return tl::unexpected(pixels.error());
       return v.set_motion_error(*pixels);
     }},
    {"units-auto", "|View/Units", "As the model suggests", 0, 0, "",
     "lengths in millimetres, of plants without decimals", set_units<Units::kAutomatic>, has_units<Units::kAutomatic>,
     nullptr},
    {"units-mm", "View/Units", "Millimetres", 0, 0, "", "lengths in millimetres", set_units<Units::kMillimetres>,
     has_units<Units::kMillimetres>, nullptr},
    {"units-m", "View/Units", "Metres", 0, 0, "", "lengths in metres", set_units<Units::kMetres>,
     has_units<Units::kMetres>, nullptr},
    {"units-ft", "View/Units", "Feet", 0, 0, "", "lengths in feet", set_units<Units::kFeet>, has_units<Units::kFeet>,
     nullptr},
    {"theme", "View", "Light colours", 0, 0, "", "switch between light and dark",
     [](Viewer& v, const std::string&) -> Done {
       return v.gui().set_theme(v.gui().theme() == Theme::kDark ? Theme::kLight : Theme::kDark), Done();
     },
     [](Viewer& v) { return v.gui().theme() == Theme::kLight; }, nullptr},
    {"panels", "|View", "Panels", GLFW_KEY_TAB, 0, "Tab", "show or hide the panels",
     [](Viewer& v, const std::string&) -> Done { return v.shown.panels = !v.shown.panels, Done(); },
     [](Viewer& v) { return v.shown.panels; }, nullptr},
    {"triad", "View", "Axes", 0, 0, "", "show or hide the axes beside the panels; a click on an end looks from there",
     [](Viewer& v, const std::string&) -> Done { return v.shown.triad = !v.shown.triad, Done(); },
     [](Viewer& v) { return v.shown.triad; }, nullptr},
    {"diagnostics", "|View/Diagnostics", "Diagnostics", 0, 0, "", "show or hide the tab that says what the culler does",
     [](Viewer& v, const std::string&) -> Done {
       v.shown.diagnostics = !v.shown.diagnostics;
       if (v.shown.diagnostics) v.shown.tab = "Diagnostics";
       return {};
     },
     [](Viewer& v) { return v.shown.diagnostics; }, nullptr},
    {"freeze", "|View/Diagnostics", "Freeze the culling camera", GLFW_KEY_C, 0, "C",
     "cull for this view from now on, and look from elsewhere: what it sees nothing of is magenta",
     [](Viewer& v, const std::string&) -> Done { return v.session()->set_frozen(!v.session()->frozen()), Done(); },
     [](Viewer& v) { return v.session()->frozen() != nullptr; }},
    {"boxes", "View/Diagnostics", "Boxes of the frozen camera", GLFW_KEY_C, kShift, "Shift+C",
     "show or hide the frozen camera's view and boxes of what it culls: STATE", toggle_boxes,
     [](Viewer& v) { return v.culling().switches.boxes; }, nullptr},
    {"cull-auto", "|View/Diagnostics", "As the scene's size suggests", GLFW_KEY_0, kAlt, "Alt+0",
     "cull as the scene's size suggests", cull<CullerChoice::kAutomatic>},
    {"cull-cpu", "View/Diagnostics", "On the CPU", GLFW_KEY_1, kAlt, "Alt+1", "cull on the CPU",
     cull<CullerChoice::kCpu>, [](Viewer& v) { return v.session()->engine().plan().culler == CullerChoice::kCpu; }},
    {"cull-gpu", "View/Diagnostics", "On the GPU", GLFW_KEY_2, kAlt, "Alt+2", "cull on the GPU",
     cull<CullerChoice::kGpu>, [](Viewer& v) { return v.session()->engine().plan().culler == CullerChoice::kGpu; }},
    {"cull-hybrid", "View/Diagnostics", "Where it costs less", GLFW_KEY_3, kAlt, "Alt+3",
     "cull where it costs less (hybrid)", cull<CullerChoice::kHybrid>,
     [](Viewer& v) { return v.session()->engine().plan().culler == CullerChoice::kHybrid; }},
    {"budget", nullptr, "", 0, 0, "", "milliseconds that a frame may take while the view moves; 0: any: MS",
     [](Viewer& v, const std::string& text) {
       return set_number(v, text, [](engine::EngineConfig& c, double ms) { c.losses.budget_ms = ms; });
     }},
    {"min-projected-area", nullptr, "", 0, 0, "", "leave out what covers fewer pixels; 0: nothing: PX",
     [](Viewer& v, const std::string& text) {
       return set_number(v, text,
                         [](engine::EngineConfig& c, double pixels) { c.losses.min_projected_area = float(pixels); });
     }},
};

const Command kSection[] = {
    {"section-face", "Section", "Pick a face…", 0, 0, "",
     "cut away what lies in front of the face that is clicked on next (X: of the face under the cursor)",
     take_tool<Tool::kSection>, has_tool<Tool::kSection>, without_model, icons::kSection},
    {"section-at", nullptr, "Cut at this face", 0, 0, "",
     "cut away what lies in front of the face that was clicked on with the right button", section_at, nullptr,
     without_face},
    {"section-here", nullptr, "", GLFW_KEY_X, 0, "X", "cut away what lies in front of the face under the cursor",
     section_here},
    {"section-z", "Section/Through the middle", "Horizontal", 0, 0, "", "cut away the upper half of the model",
     cut_across<2>},
    {"section-x", "Section/Through the middle", "Across X", 0, 0, "",
     "cut away the eastern half of the model, where X is larger", cut_across<0>},
    {"section-y", "Section/Through the middle", "Across Y", 0, 0, "",
     "cut away the northern half of the model, where Y is larger", cut_across<1>},
    {"section-box", "Section", "Box around the selection", GLFW_KEY_B, 0, "B",
     "cut away what lies outside the box around what is selected, or around the model", section_box, nullptr,
     without_model, icons::kBox},
    {"section-flip", "|Section", "Flip the selected section", 0, 0, "",
     "keep the other side of a section: N, or the selected one", flip_section, nullptr, without_section},
    {"section-remove", "Section", "Remove the selected section", 0, 0, "",
     "take a section away: N, or the selected one", remove_section, nullptr, without_section},
    {"section-clear", "Section", "No sections", GLFW_KEY_X, kShift, "Shift+X", "take all sections away",
     [](Viewer& v, const std::string&) -> Done { return v.session()->sections().clear(), Done(); }, nullptr,
     without_sections},
    {"section-handles", "|Section", "Handles", 0, 0, "", "show or hide the handles of sections beside the panels",
     [](Viewer& v, const std::string&) -> Done { return v.shown.section_handles = !v.shown.section_handles, Done(); },
     [](Viewer& v) { return v.shown.section_handles; }, nullptr},
    {"section-select", nullptr, "", 0, 0, "", "show all handles of a section: N, 0: of none", select_section},
    {"section-move", nullptr, "", 0, 0, "", "move a section out of what it keeps: N METRES, or the selected one",
     move_section},
};

const Command kMeasure[] = {
    {"measure", "Measure", "Set marks", GLFW_KEY_M, 0, "M", "clicks set marks, which snap, and measure between them",
     take_tool<Tool::kMeasure>, has_tool<Tool::kMeasure>, without_model, icons::kMeasure},
    {"measure-selected", "Measure", "Distance of two selected items", 0, 0, "",
     "the shortest distance of two selected items", measure_selected, nullptr, without_two_items},
    {"measure-copy", "|Measure", "Copy the list", 0, 0, "",
     "copy all measurements, a line each, with columns that spreadsheets take apart", copy_measurements, nullptr,
     without_marks},
    {"measure-remove", nullptr, "", 0, 0, "", "take a measurement from the list: N", remove_measurement},
    {"measure-clear", "Measure", "Clear", 0, 0, "", "take marks and distances away",
     [](Viewer& v, const std::string&) -> Done { return v.session()->measuring().clear(), Done(); }, nullptr,
     without_marks},
};

const Command kCompare[] = {
    {"compare", "Compare", "Compare with…", 0, 0, "",
     "show what has changed since an older revision of what is open: FILE", compare_with},
    {"compare-next", "Compare", "Next change", GLFW_KEY_N, 0, "N",
     "select the next change since the older revision, and go there", next_change, nullptr, without_comparison},
    {"compare-previous", "Compare", "Previous change", GLFW_KEY_N, kShift, "Shift+N", "the change before",
     previous_change, nullptr, without_comparison},
    {"compare-slider", "Compare", "Slider", 0, 0, "",
     "split the image by a line that can be dragged: left of it the older revision as it was, right of it the newer "
     "one; or end that: 0…1 or off",
     set_slider, [](Viewer& v) { return v.session()->slider().has_value(); }, without_comparison},
    {"compare-end", "|Compare", "End the comparison", 0, 0, "", "show the model alone again", end_comparison, nullptr,
     without_comparison},
    {"compare-toggle", nullptr, "", 0, 0, "",
     "show or hide items that are added, removed, moved, changed or unchanged: WHICH", toggle_changes},
};

const Command kHelp[] = {
    {"help", "Help", "Keys and mouse", GLFW_KEY_F1, 0, "F1", "show keys and mouse", toggle<Dialog::kHelp>,
     shows<Dialog::kHelp>, nullptr},
    {"driver", "Help", "Graphics driver", 0, 0, "", "show what the graphics driver offers, to copy into a report",
     toggle<Dialog::kDriver>, shows<Dialog::kDriver>, nullptr},
};

}  // namespace

std::span<const Command> commands() {
  static const std::vector<Command> all = [] {
    std::vector<Command> menus;
    for (const std::span<const Command> menu :
         {std::span<const Command>(kFile), {kEdit}, {kView}, {kSection}, {kMeasure}, {kCompare}, {kHelp}})
      menus.insert(menus.end(), menu.begin(), menu.end());
    return menus;
  }();
  return all;
}

}  // namespace sightline::apps
