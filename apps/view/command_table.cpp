// The table of commands, in the order of menus and toolbar, and what they do.

#include <type_traits>
#include <vector>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/tree_walk.h"
#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/commands.h"
#include "sightline/apps/view/icons.h"

namespace sightline::apps {
namespace {

using engine::CullerChoice;

template <class Move>
Done move_camera(Session& session, const Move& move) {
  session.camera.remember();
  move(session.camera);
  return {};
}

/// Looks along a direction at the whole model.
template <int kX, int kY, int kZ>
Done look(const std::string&, Session& session) {
  session.camera.remember();
  session.show_all(core::dvec3(kX, kY, kZ));
  return {};
}

Done fit(const std::string&, Session& session) {
  session.camera.remember();
  session.show_all(core::kOverviewDirection);
  return {};
}

Done focus(const std::string&, Session& session) {
  const auto selection = session.document.selection();
  if (selection.empty()) return session.camera.remember(), session.show_all(), Done();
  const core::AabbD bounds = session.document.bounds(selection);
  return move_camera(session, [&](Camera& camera) { camera.fit(bounds, session.image.aspect()); });
}

template <int kNotches>
Done zoom(const std::string&, Session& session) {
  return move_camera(session, [](Camera& camera) { camera.zoom(kNotches, camera.pose().target); });
}

template <CullerChoice kChoice>
Done cull(const std::string&, Session& session) {
  return session.set_culler(kChoice);
}
template <CullerChoice kChoice>
bool culls(Workspace& work) {
  return work.session->engine.plan().culler == kChoice;
}

template <Done (Document::*kFunction)()>
Done of_document(const std::string&, Session& session) {
  return (session.document.*kFunction)();
}

/// A function of the document that takes the parts that are named, or the selection, which must not be empty.
template <Done (Document::*kFunction)(std::span<const core::ItemId>)>
Done with_selection(Workspace& work, const std::string& part) {
  Document& document = work.session->document;
  if (!part.empty()) {
    const auto named = items_named(part, *work.session, work.messages);
    return named ? (document.*kFunction)(*named) : Done(tl::unexpected(named.error()));
  }
  if (const char* why = missing(needs::kSelection, work)) return core::fail(why);
  const std::vector<core::ItemId> items(document.selection().begin(), document.selection().end());
  return (document.*kFunction)(items);
}

Done select_all(const std::string&, Session& session) {
  return session.document.select(items_below(session.scene(), session.scene().root()));
}

Done select_none(const std::string&, Session& session) {
  return session.document.select({});
}

Done measure_selected(Workspace& work, const std::string&) {
  Session& session = *work.session;
  if (const char* why = missing(needs::kTwoParts, work)) return core::fail(why);
  const auto two = parts_of_selection(work);
  work.shown.tab = "Measure";
  return session.measuring.between(session.scene(), two[0].items, two[1].items);
}

/// A switch of a dialog.
template <Dialog kDialog>
Done toggle(const std::string&, Shown& shown) {
  shown.dialog = shown.dialog == kDialog ? Dialog::kNone : kDialog;
  return {};
}
template <Dialog kDialog>
bool shows(Workspace& work) {
  return work.shown.dialog == kDialog;
}

/// A switch of panels or images.
template <auto kSwitch>
Done flip(const std::string&, Shown& shown) {
  shown.*kSwitch = !(shown.*kSwitch);
  return {};
}
template <auto kSwitch>
bool is_on(Workspace& work) {
  return work.shown.*kSwitch;
}
template <auto kSwitch>
Done flip_style(Workspace& work, const std::string& none) {
  return flip<kSwitch>(none, work.shown), work.apply_styles();
}

template <Tool kTool>
Done take_tool(const std::string&, Shown& shown, Messages& messages) {
  shown.tool = shown.tool == kTool ? Tool::kSelect : kTool;
  if (shown.tool == Tool::kMeasure) shown.tab = "Measure";
  if (shown.tool == Tool::kSection) messages.tell("click on a face: what lies in front of it is cut away");
  return {};
}
/// Takes the tool that sets marks, for distances or for angles, or puts it away.
template <bool kAngles>
Done set_marks(const std::string& none, Session& session, Shown& shown, Messages& messages) {
  if (shown.tool == Tool::kMeasure && session.measuring.angles() != kAngles) shown.tool = Tool::kSelect;
  session.measuring.set_angles(kAngles);
  return take_tool<Tool::kMeasure>(none, shown, messages);
}
template <bool kAngles>
bool sets_marks(Workspace& work) {
  return work.shown.tool == Tool::kMeasure && work.session && work.session->measuring.angles() == kAngles;
}

/// Weighs what is selected. A number is the density from then on.
Done weigh(Workspace& work, const std::string& density) {
  if (const char* why = missing(needs::kSelection, work)) return core::fail(why);
  if (!density.empty()) {
    const auto number = parse_finite(density);
    if (!number || !(*number > 0.0) || *number > Settings::kLargestDensity)
      return core::fail("weigh: expected kilograms a cubic metre, found \"" + density + "\"");
    work.shown.density = *number;
  }
  work.shown.tab = "Measure";
  Session& session = *work.session;
  return session.measuring.weigh(session.scene(), session.document.selection(), work.shown.density);
}

template <Tool kTool>
bool has_tool(Workspace& work) {
  return work.shown.tool == kTool;
}

template <SelectionLevel kLevel>
Done set_level(const std::string&, Shown& shown) {
  shown.level = kLevel;
  shown.tool = Tool::kSelect;
  return {};
}
template <SelectionLevel kLevel>
bool has_level(Workspace& work) {
  return work.shown.level == kLevel;
}

template <Units kUnits>
Done set_units(const std::string&, Shown& shown) {
  shown.units = kUnits;
  return {};
}
template <Units kUnits>
bool has_units(Workspace& work) {
  return work.shown.units == kUnits;
}

Done section_here(const std::string&, Session& session, Shown& shown, Gestures& gestures) {
  return cut_at(gestures.under_cursor(), session, shown);
}

Done section_at(const std::string&, Session& session, Shown& shown, const Gestures& gestures) {
  return cut_at(gestures.context_face(), session, shown);
}

template <int kAxis>
Done cut_across(const std::string&, Session& session, Shown& shown) {
  return cut_middle(kAxis, session, shown);
}

Done section_box(const std::string&, Session& session, Shown& shown) {
  const auto selection = session.document.selection();
  const core::AabbD bounds = selection.empty() ? session.bounds().bounds : session.document.bounds(selection);
  if (!bounds.empty()) session.sections.box(bounds);
  shown.tab = "Sections";
  return {};
}

Done copy_measurements(Workspace& work, const std::string&) {
  const Session& session = *work.session;
  const std::vector<Measurement>& list = session.measuring.list();
  work.window.set_clipboard(measurement_table(list, session.offset(), work.lengths()));
  work.messages.tell("copied: " + std::to_string(list.size()) + " measurements");
  return {};
}

Done remove_measurement(const std::string& number, Session& session) {
  Measuring& measuring = session.measuring;
  return numbered("measurement", number, measuring.list().size()).map([&](std::size_t i) { measuring.remove(i); });
}

Done select_finding(const std::string& number, Session& session) {
  const std::vector<Finding>& all = session.findings();
  return numbered("finding", number, all.size()).and_then([&](std::size_t i) {
    return session.document.select(all[i].items);
  });
}

/// Toggles the boxes of all states, or of the one that is named.
Done toggle_boxes(const std::string& state, CullingOverlay& culling) {
  CullingSwitches& switches = culling.switches;
  if (state.empty()) return switches.boxes = !switches.boxes, Done();
  for (int i = 0; i < culling::kCullStateCount; ++i) {
    if (name_of(culling::CullState(i)) != state) continue;
    bool& on = switches.states[std::size_t(i)];
    return on = !on, Done();
  }
  return core::fail("boxes: expected inside, intersecting, outside, occluded or too_small, found \"" + state + "\"");
}

/// Sets one of EngineConfig::losses.
template <auto kLoss>
Done set_loss(const std::string& text, Session& session) {
  return parse_finite(text).and_then([&](double number) {
    return session.image.configure([&](engine::EngineConfig& config) {
      auto& loss = config.losses.*kLoss;
      loss = std::remove_reference_t<decltype(loss)>(number);
    });
  });
}

Done set_lod_error(Workspace& work, const std::string& text) {
  return parse_finite(text).and_then([&](double pixels) { return work.set_motion_error(pixels); });
}

Done toggle_levels(Workspace& work, const std::string&) {
  return work.set_motion_error(work.shown.levels ? 0.0 : work.image.motion_error);
}

Done toggle_theme(Workspace& work, const std::string&) {
  work.shown.light = !work.shown.light;
  work.gui.set_theme(work.shown.light ? Theme::kLight : Theme::kDark);
  return {};
}

Done toggle_diagnostics(const std::string&, Shown& shown) {
  shown.diagnostics = !shown.diagnostics;
  if (shown.diagnostics) shown.tab = "Diagnostics";
  return {};
}

Done open_or_ask(Workspace& work, const std::string& file) {
  if (file.empty()) return work.shown.dialog = Dialog::kOpen, Done();
  return work.open({file}), Done();
}

Done open_lenient(Workspace& work, const std::string& file) {
  if (!file.empty()) return work.open({file}, true), Done();
  if (work.damaged.files.empty()) return core::fail("open-lenient: expected FILE");
  return work.open_damaged(), Done();
}

Done toggle_up(Workspace& work, const std::string&) {
  work.opening.toggle_up(work.session.get());
  work.read_again();
  return {};
}

Done find_or_ask(const std::string& text, Session& session, Shown& shown, Messages& messages) {
  if (!text.empty()) return find_parts(text, session, messages);
  shown.find = shown.panels = true;  // what was searched for last stays, to be changed
  return {};
}

const Command kFile[] = {
    {"open", "File", "Open…", "Ctrl+O", "open files, instead of what is open: FILE", open_or_ask, nullptr, nullptr,
     icons::kOpen},
    {"open-lenient", nullptr, "Open what can be read", "",
     "open damaged files without what is damaged: FILE, or what could not be opened", open_lenient, nullptr, nullptr},
    {"append", "File", "Append files…", "", "open files beside what is open: FILE", append_model,
     shows<Dialog::kAppend>},
    {"session-save", "File", "Save the session…", "Ctrl+Shift+S",
     "keep what is open and how it is seen, with all views, to be opened again: FILE.sightline", save_session,
     shows<Dialog::kSaveSession>},
    {"recognise", "File", "Recognise primitives", "",
     "switch whether cylinders, boxes and their like are taken out of the meshes of files that are opened "
     "from now on",
     with<flip<&Shown::recognise>>, is_on<&Shown::recognise>, nullptr},
    {"y-up", "File", "Y is up", "",
     "switch which axis points up in files that do not say (OBJ, PLY, STL, VTK), and read those that are open again",
     toggle_up, [](Workspace& w) { return w.opening.y_is_up(w.session.get()); }, nullptr},
    {"screenshot", "|File", "Save image", "F12",
     "write the image that is shown, PNG or JPEG: FILE [WxH], up to 16384x16384", write_image, nullptr, &needs::kModel,
     icons::kCamera},
    {"large-image", "File", "Save image as…", "Shift+F12", "ask for a size and a file, and write the image",
     with<toggle<Dialog::kImage>>, shows<Dialog::kImage>},
    {"image-background", nullptr, "", "",
     "what is behind everything in images that are written: shown, transparent, white, RRGGBB or TOP,BOTTOM",
     image_background},
    {"image-marks", nullptr, "", "",
     "switch whether images that are written have mark-ups, measurements and the legend",
     with<flip<&Shown::image_marks>>, is_on<&Shown::image_marks>, nullptr},
    {"save-view", "|File", "Save view", "Ctrl+S", "write what is seen and shown, JSON: FILE", with<save_view>},
    {"load-view", nullptr, "", "", "see what a view file shows; or drop it on the window: FILE", with<load_view>},
    {"export-model", "|File", "Export model…", "", "write all of the model, RVM, OBJ, glTF or a scene cache: FILE",
     export_model, shows<Dialog::kExportModel>},
    {"export-selection", "File", "Export selection…", "", "write what is selected, in the same formats: FILE",
     export_selection, shows<Dialog::kExportSelection>, &needs::kSelection},
    {"record", "|File/Camera path", "Record camera path", "R", "begin to record a camera path; end and write it",
     toggle_recording, [](Workspace& w) { return w.recorder.has_value(); }},
    {"play-path", "File/Camera path", "Play camera path", "",
     "play a camera path, or that played or recorded last; or stop: FILE", with<play_path>,
     [](Workspace& w) { return w.player.playing(); }, &needs::kPath},
    {"save-path", "File/Camera path", "Save camera path…", "",
     "write the camera path that was played or recorded last: FILE", with<save_path>, nullptr, &needs::kPath},
    {"path-loop", nullptr, "", "", "play camera paths again and again, or once",
     [](Workspace& w, const std::string&) -> Done { return w.player.loop = !w.player.loop, Done(); }},
    {"path-speed", nullptr, "", "", "how fast camera paths play, times their own speed: FACTOR", with<set_path_speed>},
    {"camera-path", "File/Camera path", "Camera path and video…", "",
     "ask for a camera path to play, and write its frames", with<toggle<Dialog::kPath>>, shows<Dialog::kPath>},
    {"write-frames", nullptr, "", "",
     "write that path as images for a video, 25 a second unless told otherwise: FOLDER [FPS] [WxH]", write_frames},
    {"quit", "|File", "Quit", "Ctrl+Q", "end the program",
     [](Workspace& w, const std::string&) -> Done { return w.window.close(), Done(); }, nullptr, nullptr},
    {"lose-context", nullptr, "", "", "make window and graphics context anew, as after a reset of the driver",
     [](Workspace& w, const std::string&) -> Done { return w.pace.context_lost = true, Done(); }, nullptr, nullptr},
};

const Command kEdit[] = {
    {"undo", "Edit", "Undo", "Ctrl+Z", "undo the last change of selection and visibility",
     with<of_document<&Document::undo>>, nullptr, &needs::kUndo},
    {"redo", "Edit", "Redo", "Ctrl+Shift+Z", "do again what was undone", with<of_document<&Document::redo>>, nullptr,
     &needs::kRedo},
    {"find", "|Edit", "Find", "Ctrl+F", "show the parts that a text names: PART", with<find_or_ask>},
    {"select-found", "Edit", "Select what was found", "", "select what is below the parts that a search names",
     with<select_found>, nullptr, &needs::kFound},
    {"select-named", nullptr, "", "", "select what a text names, or what its conditions are true of: PART",
     with<select_named>},
    {"set-keep", "Edit", "Keep the search as a set", "",
     "list a search, or that of the search field, above the tree, where a click selects what it finds: PART",
     with<keep_set>, nullptr, &needs::kFound},
    {"set-remove", nullptr, "", "", "take a set from the list: PART", with<remove_set>, nullptr, nullptr},
    {"select", "|Edit", "Select", "", "clicks select items again, and no longer measure or cut",
     [](Workspace& w, const std::string&) -> Done { return w.shown.tool = Tool::kSelect, Done(); },
     has_tool<Tool::kSelect>, &needs::kModel, icons::kCursor},
    {"level-item", "Edit/Clicks select", "Items", "", "clicks select single items: primitives and meshes",
     with<set_level<SelectionLevel::kItem>>, has_level<SelectionLevel::kItem>, nullptr},
    {"level-part", "Edit/Clicks select", "Parts", "", "clicks select whole parts: what is below the nearest name",
     with<set_level<SelectionLevel::kPart>>, has_level<SelectionLevel::kPart>, nullptr},
    {"level-assembly", "Edit/Clicks select", "Assemblies", "", "clicks select what parts belong to",
     with<set_level<SelectionLevel::kAssembly>>, has_level<SelectionLevel::kAssembly>, nullptr},
    {"level-file", "Edit/Clicks select", "Files", "", "clicks select all of a file",
     with<set_level<SelectionLevel::kFile>>, has_level<SelectionLevel::kFile>, nullptr},
    {"select-all", "Edit", "Select all", "Ctrl+A", "select all that is not hidden", with<select_all>},
    {"select-part", "Edit", "Select the whole part", "Ctrl+Up",
     "select all of the part that the selection belongs to; again: of the one above",
     with<of_document<&Document::select_part>>, nullptr, &needs::kSelection},
    {"select-none", "Edit", "Select nothing", "", "select nothing", with<select_none>, nullptr, &needs::kSelection},
    {"escape", nullptr, "", "Esc",
     "close the topmost menu or dialog; else end what clicks or keys do otherwise; else select nothing",
     [](Workspace& w, const std::string&) -> Done { return w.gestures.escape(), Done(); }, nullptr, nullptr},
    {"hide", "|Edit", "Hide", "H", "hide what is selected, or a part: PART", with_selection<&Document::hide>, nullptr,
     &needs::kSelection, icons::kEyeCrossed},
    {"isolate", "Edit", "Isolate", "I", "hide all but what is selected, or a part: PART",
     with_selection<&Document::isolate>, nullptr, &needs::kSelection, icons::kIsolate},
    {"ghost-others", "Edit", "Make the rest faint", "G", "make all but what is selected faint, or a part: PART",
     with_selection<&Document::ghost_others>, nullptr, &needs::kSelection},
    {"toggle-part", nullptr, "", "", "hide what lies below a part, or show it if it is hidden: PART",
     with<toggle_part>},
    {"select-finding", nullptr, "", "", "select the items of what the tab Item says is odd about the model: N",
     with<select_finding>},
    {"properties-copy", "|Edit", "Copy properties", "Ctrl+Shift+C",
     "copy what is known of the selection, as a table that spreadsheets take apart", copy_properties, nullptr,
     &needs::kSelection},
    {"properties-save", "Edit", "Save properties", "", "write it as CSV: FILE", with<save_properties>, nullptr,
     &needs::kSelection},
    {"show-all", "|Edit", "Show all", "U", "show what is hidden or faint", with<of_document<&Document::show_all>>,
     nullptr, &needs::kHidden, icons::kEye},
};

const Command kView[] = {
    {"fit", "View", "Fit all", "Home", "see the whole model from above", with<fit>, nullptr, &needs::kModel,
     icons::kFit},
    {"focus", "View", "Focus on selection", "F", "fit what is selected, or the whole model", with<focus>, nullptr,
     &needs::kModel, icons::kFocus},
    {"front", "View/Look from", "Front", "1", "look north", with<look<0, 1, 0>>, nullptr, &needs::kModel,
     icons::kFront},
    {"back", "View/Look from", "Back", "2", "look south", with<look<0, -1, 0>>, nullptr, &needs::kModel, icons::kBack},
    {"left", "View/Look from", "Left", "3", "look east", with<look<1, 0, 0>>, nullptr, &needs::kModel, icons::kLeft},
    {"right", "View/Look from", "Right", "4", "look west", with<look<-1, 0, 0>>, nullptr, &needs::kModel,
     icons::kRight},
    {"top", "View/Look from", "Top", "5", "look down", with<look<0, 0, -1>>, nullptr, &needs::kModel, icons::kTop},
    {"bottom", "View/Look from", "Bottom", "6", "look up", with<look<0, 0, 1>>, nullptr, &needs::kModel,
     icons::kBottom},
    {"zoom-in", nullptr, "", "Keypad +", "come nearer to the middle", with<zoom<1>>},
    {"zoom-out", nullptr, "", "Keypad -", "go away from it", with<zoom<-1>>},
    {"camera-back", "View", "Camera back", "Backspace", "put the camera back to where it was",
     [](Workspace& w, const std::string&) -> Done { return w.session->camera.back(), Done(); }},
    {"orthographic", "|View", "Parallel projection", "P", "switch between parallel and perspective projection",
     [](Workspace& w, const std::string&) {
       return move_camera(*w.session, [](Camera& camera) { camera.set_orthographic(!camera.orthographic()); });
     },
     [](Workspace& w) { return w.session->camera.orthographic(); }, &needs::kModel, icons::kPerspective},
    {"walk", "View", "Walk", "K", "walk on floors and up stairs, and be stopped by walls; or fly again",
     [](Workspace& w, const std::string&) -> Done { return w.gestures.set_walking(!w.gestures.walking()), Done(); },
     [](Workspace& w) { return w.gestures.walking(); }, &needs::kModel, icons::kWalk},
    {"view-add", "|View", "Add to the views", "V", "keep what is seen as a view of the list: NAME", add_view},
    {"view-show", nullptr, "", "", "show a view of the list: NAME or number", with<show_view>},
    {"view-update", nullptr, "", "", "make the current view what is seen now", update_view},
    {"view-rename", nullptr, "", "", "name the current view: NAME", with<rename_view>},
    {"view-status", nullptr, "", "", "say what becomes of the current view, such as Open or Closed: TEXT",
     with<set_view_status>},
    {"view-type", nullptr, "", "", "say what the current view is about, such as Clash: TEXT", with<set_view_type>},
    {"view-comment", nullptr, "", "", "comment the current view: TEXT", with<comment_view>},
    {"view-delete", nullptr, "", "", "take a view from the list: NAME or number, or the current one",
     with<delete_view>},
    {"views-save", "View", "Save all views…", "", "write all views, BCF 2.1 (.bcfzip, .bcf) or JSON: FILE",
     with<save_views>},
    {"views-load", "View", "Load views…", "", "add the views of a file, or drop it on the window: FILE",
     with<load_views>},
    {"depth-shading", "|View/Shapes", "Depth shading and edge lines", "L",
     "switch the shading and the lines that make shapes of one colour legible on or off",
     flip_style<&Shown::depth_shading>, is_on<&Shown::depth_shading>, nullptr},
    {"edges", "View/Shapes", "Edges", "", "switch lines along edges on or off, where faces meet and meshes bend or end",
     flip_style<&Shown::edges>, is_on<&Shown::edges>, nullptr},
    {"smooth", "View/Shapes", "Smooth edges at rest", "",
     "switch smooth edges, which come when nothing moves, on or off", with<flip<&Shown::smooth>>, is_on<&Shown::smooth>,
     nullptr},
    {"hatch", "View/Shapes", "Hatching of cut faces", "", "switch the lines across what sections cut on or off",
     flip_style<&Shown::hatching>, is_on<&Shown::hatching>, nullptr},
    {"lower-resolution", "View/Shapes", "Lower resolution in motion", "",
     "switch whether images have fewer pixels while the view moves and frames come late", with<flip<&Shown::lower>>,
     is_on<&Shown::lower>, nullptr},
    {"levels", "View/Shapes", "Coarser meshes in motion", "",
     "switch whether meshes are drawn by levels of detail while the view moves", toggle_levels, is_on<&Shown::levels>,
     nullptr},
    {"lod-error", nullptr, "", "", "pixels by which meshes may lie elsewhere while the view moves: PX", set_lod_error},
    {"colour-by", "View", "Colour by an attribute", "",
     "give items colours by the value of an attribute, @kind, @material, @layer, @file or @size; or end that: KEY",
     with<colour_by_or_ask>, [](Workspace& w) { return !w.session->colouring.groups.empty(); }},
    {"units-auto", "|View/Units", "As the model suggests", "", "lengths in millimetres, of plants without decimals",
     with<set_units<Units::kAutomatic>>, has_units<Units::kAutomatic>, nullptr},
    {"units-mm", "View/Units", "Millimetres", "", "lengths in millimetres", with<set_units<Units::kMillimetres>>,
     has_units<Units::kMillimetres>, nullptr},
    {"units-m", "View/Units", "Metres", "", "lengths in metres", with<set_units<Units::kMetres>>,
     has_units<Units::kMetres>, nullptr},
    {"units-ft", "View/Units", "Feet", "", "lengths in feet", with<set_units<Units::kFeet>>, has_units<Units::kFeet>,
     nullptr},
    {"theme", "View", "Light colours", "", "switch between light and dark", toggle_theme, is_on<&Shown::light>,
     nullptr},
    {"panels", "|View", "Panels", "Tab", "show or hide the panels", with<flip<&Shown::panels>>, is_on<&Shown::panels>,
     nullptr},
    {"triad", "View", "Axes", "", "show or hide the axes beside the panels; a click on an end looks from there",
     with<flip<&Shown::triad>>, is_on<&Shown::triad>, nullptr},
    {"diagnostics", "|View/Diagnostics", "Diagnostics", "", "show or hide the tab that says what the culler does",
     with<toggle_diagnostics>, is_on<&Shown::diagnostics>, nullptr},
    {"freeze", "|View/Diagnostics", "Freeze the culling camera", "C",
     "cull for this view from now on, and look from elsewhere: what it sees nothing of is magenta",
     [](Workspace& w, const std::string&) -> Done {
       return w.session->image.set_frozen(!w.session->image.frozen()), Done();
     },
     [](Workspace& w) { return w.session->image.frozen() != nullptr; }},
    {"boxes", "View/Diagnostics", "Boxes of the frozen camera", "Shift+C",
     "show or hide the frozen camera's view and boxes of what it culls: STATE", with<toggle_boxes>,
     [](Workspace& w) { return w.culling.switches.boxes; }, nullptr},
    {"cull-auto", "|View/Diagnostics", "As the scene's size suggests", "Alt+0", "cull as the scene's size suggests",
     with<cull<CullerChoice::kAutomatic>>},
    {"cull-cpu", "View/Diagnostics", "On the CPU", "Alt+1", "cull on the CPU", with<cull<CullerChoice::kCpu>>,
     culls<CullerChoice::kCpu>},
    {"cull-gpu", "View/Diagnostics", "On the GPU", "Alt+2", "cull on the GPU", with<cull<CullerChoice::kGpu>>,
     culls<CullerChoice::kGpu>},
    {"cull-hybrid", "View/Diagnostics", "Where it costs less", "Alt+3", "cull where it costs less (hybrid)",
     with<cull<CullerChoice::kHybrid>>, culls<CullerChoice::kHybrid>},
    {"budget", nullptr, "", "", "milliseconds that a frame may take while the view moves; 0: any: MS",
     with<set_loss<&engine::LossConfig::budget_ms>>},
    {"min-projected-area", nullptr, "", "", "leave out what covers fewer pixels; 0: nothing: PX",
     with<set_loss<&engine::LossConfig::min_projected_area>>},
};

const Command kSection[] = {
    {"section-face", "Section", "Pick a face…", "",
     "cut away what lies in front of the face that is clicked on next (X: of the face under the cursor)",
     with<take_tool<Tool::kSection>>, has_tool<Tool::kSection>, &needs::kModel, icons::kSection},
    {"section-at", nullptr, "Cut at this face", "",
     "cut away what lies in front of the face that was clicked on with the right button", with<section_at>, nullptr,
     &needs::kFace},
    {"section-here", nullptr, "", "X", "cut away what lies in front of the face under the cursor", with<section_here>},
    {"section-z", "Section/Through the middle", "Horizontal", "", "cut away the upper half of the model",
     with<cut_across<2>>},
    {"section-x", "Section/Through the middle", "Across X", "",
     "cut away the eastern half of the model, where X is larger", with<cut_across<0>>},
    {"section-y", "Section/Through the middle", "Across Y", "",
     "cut away the northern half of the model, where Y is larger", with<cut_across<1>>},
    {"section-box", "Section", "Box around the selection", "B",
     "cut away what lies outside the box around what is selected, or around the model", with<section_box>, nullptr,
     &needs::kModel, icons::kBox},
    {"section-flip", "|Section", "Flip the selected section", "",
     "keep the other side of a section: N, or the selected one", with<flip_section>, nullptr, &needs::kSection},
    {"section-remove", "Section", "Remove the selected section", "", "take a section away: N, or the selected one",
     with<remove_section>, nullptr, &needs::kSection},
    {"section-clear", "Section", "No sections", "Shift+X", "take all sections away",
     [](Workspace& w, const std::string&) -> Done { return w.session->sections.clear(), Done(); }, nullptr,
     &needs::kSections},
    {"section-handles", "|Section", "Handles", "", "show or hide the handles of sections beside the panels",
     with<flip<&Shown::section_handles>>, is_on<&Shown::section_handles>, nullptr},
    {"section-select", nullptr, "", "", "show all handles of a section: N, 0: of none", with<select_section>},
    {"section-move", nullptr, "", "", "move a section out of what it keeps: N METRES, or the selected one",
     with<move_section>},
};

const Command kMeasure[] = {
    {"measure", "Measure", "Set marks", "M", "clicks set marks, which snap, and measure between them",
     with<set_marks<false>>, sets_marks<false>, &needs::kModel, icons::kMeasure},
    {"measure-angle", "Measure", "Angle of three points", "", "clicks set three marks: the angle is at the second one",
     with<set_marks<true>>, sets_marks<true>, &needs::kModel},
    {"measure-selected", "Measure", "Distance of what is selected", "",
     "the shortest distance of two selected parts or items", measure_selected, nullptr, &needs::kTwoParts},
    {"weigh", "Measure", "Area, volume and mass", "",
     "area, volume and mass of what is selected, with a density from then on, kg a cubic metre: DENSITY", weigh,
     nullptr, &needs::kSelection},
    {"measure-copy", "|Measure", "Copy the list", "",
     "copy all measurements, a line each, with columns that spreadsheets take apart", copy_measurements, nullptr,
     &needs::kMarks},
    {"measure-remove", nullptr, "", "", "take a measurement from the list: N", with<remove_measurement>},
    {"measure-clear", "Measure", "Clear", "", "take marks and distances away",
     [](Workspace& w, const std::string&) -> Done { return w.session->measuring.clear(), Done(); }, nullptr,
     &needs::kMarks},
    {"mark", "|Measure", "Mark up", "Shift+M",
     "drags draw arrows or clouds onto the view, clicks place texts: KIND X Y X Y WORDS", mark, has_tool<Tool::kMark>,
     &needs::kModel, icons::kMarkup},
    {"mark-remove", nullptr, "", "", "take a mark-up from the view: N", with<remove_markup>},
    {"marks-clear", "Measure", "Clear mark-ups", "", "take all mark-ups away",
     [](Workspace& w, const std::string&) -> Done { return w.session->marking.clear(), Done(); }, nullptr,
     &needs::kMarkups},
};

const Command kCompare[] = {
    {"compare", "Compare", "Compare with…", "", "show what has changed since an older revision of what is open: FILE",
     compare_with},
    {"compare-next", "Compare", "Next change", "N", "select the next change since the older revision, and go there",
     with<next_change>, nullptr, &needs::kComparison},
    {"compare-previous", "Compare", "Previous change", "Shift+N", "the change before", with<previous_change>, nullptr,
     &needs::kComparison},
    {"compare-slider", "Compare", "Slider", "",
     "split the image by a line that can be dragged: left of it the older revision as it was, right of it the newer "
     "one; or end that: 0…1 or off",
     set_slider, [](Workspace& w) { return w.session->slider.at().has_value(); }, &needs::kComparison},
    {"compare-save", "Compare", "Save the list", "",
     "write what has changed, with images: FILE.html, .csv, .json, .bcfzip or .bcf", with<save_comparison>, nullptr,
     &needs::kComparison},
    {"compare-end", "|Compare", "End the comparison", "", "show the model alone again", end_comparison, nullptr,
     &needs::kComparison},
    {"compare-toggle", nullptr, "", "",
     "show or hide items that are added, removed, moved, changed or unchanged: WHICH", with<toggle_changes>},
};

const Command kHelp[] = {
    {"help", "Help", "Keys and mouse", "F1", "show keys and mouse", with<toggle<Dialog::kHelp>>, shows<Dialog::kHelp>,
     nullptr},
    {"driver", "Help", "Graphics driver", "", "show what the graphics driver offers, to copy into a report",
     with<toggle<Dialog::kDriver>>, shows<Dialog::kDriver>, nullptr},
};

}  // namespace

std::span<const Command> commands() {
  static const std::vector<Command> all = [] {
    std::vector<Command> menus;
    for (const std::span<const Command> menu :
         {std::span<const Command>(kFile), {kEdit}, {kView}, {kSection}, {kMeasure}, {kCompare}, {kHelp}})
      menus.insert(menus.end(), menu.begin(), menu.end());
    for (Command& command : menus) command.bind();
    return menus;
  }();
  return all;
}

}  // namespace sightline::apps
