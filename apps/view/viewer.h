// The viewer: joins window, user interface, model and script. Its commands are in commands.h, its panels in panels.h.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sightline/apps/common/numbers.h"
#include "sightline/apps/view/axis_triad.h"
#include "sightline/apps/view/culling_overlay.h"
#include "sightline/apps/view/export.h"
#include "sightline/apps/view/file_dialog.h"
#include "sightline/apps/view/file_states.h"
#include "sightline/apps/view/frame_history.h"
#include "sightline/apps/view/gui.h"
#include "sightline/apps/view/image_textures.h"
#include "sightline/apps/view/loader.h"
#include "sightline/apps/view/model_export.h"
#include "sightline/apps/view/motion_resolution.h"
#include "sightline/apps/view/opening_steps.h"
#include "sightline/apps/view/path_player.h"
#include "sightline/apps/view/preview.h"
#include "sightline/apps/view/script.h"
#include "sightline/apps/view/section_handles.h"
#include "sightline/apps/view/session.h"
#include "sightline/apps/view/settings.h"
#include "sightline/apps/view/thumbnails.h"
#include "sightline/apps/view/view_list.h"
#include "sightline/apps/view/walking.h"
#include "sightline/apps/view/window.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

struct ViewerOptions {
  ModelOptions model;
  std::string size = "1280x720", path, save_path = "path.json", screenshot, json_file, script, settings, theme = "dark";
  engine::CullerChoice culler = engine::CullerChoice::kAutomatic;
  std::optional<culling::GpuVariant> gpu_variant;
  int samples = 1;
  DrawnOptions shown;
  int frames = 0;
  double default_budget_ms = 0.0;  ///< Session::set_default_budget() where a software rasteriser draws
  double scale = 0.0;              ///< of text and panels; 0: as the screen suggests
  bool panels = true, smooth = true;

  /// Whether there are settings to keep: scripts and --frames must do the same for everybody.
  bool remembers() const { return !settings.empty() || (script.empty() && frames == 0); }
};

/// For example "screenshot-1.png", or the next number that no file has.
std::string free_name(const std::string& stem, const std::string& extension);

/// A window in the middle that asks or tells something; there is one at a time.
enum class Dialog {
  kNone,
  kHelp,
  kDriver,
  kOpen,
  kCompare,
  kQuit,
  kImage,
  kPath,
  kReadPath,
  kSavePath,
  kFrames,
  kReadViews,
  kSaveViews,
  kSaveAndQuit,
  kExportModel,
  kExportSelection,
};
const char* name_of(Dialog dialog);

/// What a click in the image does.
enum class Tool {
  kSelect,
  kMeasure,  ///< sets marks
  kSection,  ///< cuts at a face, once
};
const char* name_of(Tool tool);

class Viewer {
 public:
  Viewer(const ViewerOptions& options, Window& window, Gui gui, SettingsFile settings = {});

  /// Until the window is closed, the frames are drawn or the script has ended. Fails with what a tool should end with.
  core::Expected<int> run();

  // What commands and panels use. A message is shown in the status bar.
  Session* session() { return session_.get(); }  ///< null while no model is open
  const Loader* loader() const { return loader_.get(); }
  const OpeningSteps& opening() const { return opening_; }
  const Preview* preview() const { return preview_.get(); }  ///< of the model that is being read, if no other is open
  Gui& gui() { return gui_; }
  FileDialog& file_dialog() { return file_dialog_; }
  FileStates& file_states() { return file_states_; }  ///< of files that panels name
  const Thumbnails& thumbnails() const { return thumbnails_; }
  ImageTextures& textures() { return textures_; }  ///< of small images in panels
  ViewList& views() { return views_; }             ///< stays when another model is opened
  void open(const std::vector<std::string>& files);
  /// Reads an older revision of the open model, and shows what has changed since.
  void compare(const std::string& file);
  void cancel_loading();
  /// Shows in the tree the parts that a text names; fails where it names none.
  core::Expected<void> find(const std::string& text);
  /// Selects the items of the parts that the search names.
  core::Expected<void> select_found();
  /// The items of the parts that a text names, in rising order; fails where there are none.
  core::Expected<std::vector<core::ItemId>> items_named(const std::string& text);
  /// Hides the items of a part, or shows them if all are hidden. A text that ends in "?nth=…" or "?item=…" is a name as
  /// views have it.
  core::Expected<void> toggle_part(const std::string& text);
  core::Expected<void> write_screenshot(const std::string& file);
  /// What is seen and shown, as a file for --view of other tools; without a name the next free one.
  core::Expected<void> save_view(const std::string& file);
  core::Expected<void> load_view(const std::string& file);
  core::Expected<void> toggle_recording();
  core::Expected<void> toggle_depth_shading();
  core::Expected<void> toggle_hatching();
  /// Whether y is up in files that do not say so, because the user says it or because they were turned for it.
  bool y_is_up() const;
  /// Changes the axis that points up in such files; those that are open are read again.
  void toggle_up();
  core::Expected<void> toggle_levels();
  /// The error of meshes, by levels of detail, while the view moves; 0: none.
  core::Expected<void> set_motion_error(double pixels);
  bool recording() const { return recorder_.has_value(); }
  PathPlayer& player() { return player_; }
  /// Draws and writes from now on, between images of the window, which takes nothing else until that is done.
  void begin_export(std::unique_ptr<Export> work);
  const Export* exporting() const { return export_.get(); }
  void cancel_export() { export_cancelled_ = true; }
  /// Writes in the background from now on.
  void begin_model_export(ModelExport::Job job);
  ModelExport* model_export() { return model_export_.get(); }  ///< null while none goes on
  /// Fails while somebody reads the scene, which must not be edited then.
  core::Expected<void> scene_is_free() const;
  void tell(std::string message, bool error = false);
  /// What became of an action. An error stays until the next action succeeds.
  void tell_outcome(const core::Expected<void>& done);
  const std::string& message() const { return message_; }
  bool message_is_error() const { return message_is_error_; }
  /// What the image shows under the cursor, or at a point of the window.
  core::Expected<std::optional<engine::Pick>> under_cursor() { return under(cursor_); }
  core::Expected<std::optional<engine::Pick>> under(const core::dvec2& at);
  const std::optional<engine::Pick>& context_face() const { return context_face_; }  ///< below the context menu
  /// The point of the model that the resting cursor is over.
  const std::optional<core::dvec3>& cursor_point() const { return cursor_point_; }
  LengthFormat lengths() const;  ///< of the open model
  /// What a click would mark.
  const std::optional<measure::Snap>& aimed() const { return aimed_; }
  /// The axes in the image's corner; none beside hidden panels or in a small image.
  std::optional<AxisTriad> triad() const;
  std::optional<AxisTriad::End> triad_end() const;  ///< under the cursor
  /// Handles of sections show beside panels.
  bool shows_section_handles() const { return session_ && shown.section_handles && shown.panels; }
  const SectionHandles& section_handles() const { return section_handles_; }
  std::optional<SectionHandles::Target> section_target() const;  ///< dragged, or else under the cursor
  bool over_slider() const;                                      ///< a press would drag it, or does
  const FrameHistory& history() const { return history_; }
  CullingOverlay& culling() { return culling_; }
  bool walking() const { return walker_.has_value(); }
  /// Motion stays on the floor, and walls stop it; or the camera flies again.
  void set_walking(bool walking);
  void set_clipboard(const std::string& text) { window_.set_clipboard(text); }
  /// Ends one thing: the topmost menu, else the dialog, a camera path, the tool, walking, or at last the selection.
  void escape();
  void quit() { window_.close(); }
  const gl::Context& context() const { return window_.context(); }
  /// As if the driver had lost the window's context.
  void lose_context() { context_lost_ = true; }
  json::Value state() const;

  /// Switches of panels.
  struct Shown {
    Dialog dialog = Dialog::kNone;
    Tool tool = Tool::kSelect;
    bool context = false;  ///< the context menu opens next
    bool panels = true;
    bool smooth = true;         ///< edges, while nothing moves
    bool depth_shading = true;  ///< what has one colour
    bool hatching = true;       ///< of cut faces
    bool section_handles = true;
    bool lower = true;                           ///< resolution, while the view moves and frames come late
    bool levels = true;                          ///< of detail of meshes, while the view moves
    bool triad = true;                           ///< beside panels
    bool diagnostics = false;                    ///< the tab that says what the culler does
    Units units = Units::kAutomatic;             ///< of lengths
    bool recognise = false;                      ///< primitives, in meshes of files that are opened
    bool find = false;                           ///< the search field gets the keyboard next
    float tree_width = 0.0f, side_width = 0.0f;  ///< of the panels, in lines of text; 0: as the window's size suggests
    const char* tab = "Item";                    ///< of the right panel, in front; the first where it has no such tab
  } shown;
  const std::vector<std::string>& files() const { return files_; }  ///< those that are open
  const std::vector<std::string>& recent() const { return now_.recent; }

 private:
  static constexpr int kSettlingFrames = 3;  // after an event: widgets take some to come to rest
  // Times as long as a frame took: frames of a large window must not delay opening.
  static constexpr double kBetweenFrames = 3.0;

  struct Drag {
    int button = 0, mods = 0;
    core::dvec2 from{0.0}, last{0.0};
    core::dvec3 point{0.0};  // of the model, under the cursor where it began
    bool moves = false;      // farther than a click may
    bool slides = false;     // the slider of a comparison
  };

  bool lost() const { return context_lost_ || window_.context().lost(); }
  core::Expected<void> recover();
  core::Expected<void> land();
  core::Expected<void> landed();
  std::vector<core::ItemId> items_below(const std::vector<core::NodeId>& nodes) const;
  void follow_opening();
  void drop_loading();
  core::Expected<void> not_landed(const core::Error& error);
  void land_comparison(core::Expected<Model> before, const std::string& file);
  bool closing();
  core::Expected<void> step_script();
  core::Expected<void> carry_out(const ScriptStep& step);
  core::Expected<void> expect(const std::string& argument);
  bool settled() const;
  bool settled_but_for_edges() const;
  bool at_rest() const;
  bool waits_for_picks() const;
  double patience() const;
  bool script_ended() const;
  bool refining() const;
  core::Expected<void> frame(double seconds);
  core::Expected<void> draw_model(const Part& part);
  engine::EngineConfig image_config() const;
  core::Expected<void> apply_styles();
  core::Expected<void> adapt_to_motion();
  core::Expected<void> show_image(const Part& part);
  void note_image();
  Part viewport() const;
  core::dvec2 in_image(const core::dvec2& cursor) const;
  bool in_viewport(const core::dvec2& cursor) const;

  void handle(const Event& event);
  void drop(const std::vector<std::string>& files);
  void press_key(const Event& event);
  void press_button(const Event& event);
  void release_button(const Event& event);
  void move_cursor(const core::dvec2& to);
  void click(const Drag& drag);
  void open_context_menu(const core::dvec2& at);
  void set_mark(const core::dvec2& at);
  void select_rectangle(const Drag& drag);
  void draw_rectangle() const;
  core::Expected<void> step_export();
  core::Expected<void> land_model_export();
  void fly(double seconds);
  void walk(const core::dvec3& held, double seconds);
  void hover();
  void play();
  void keep_thumbnail();
  core::Expected<void> finish();
  core::Expected<void> read_path();
  void take_settings();
  void keep_settings();

  ViewerOptions options_;
  Window& window_;
  Gui gui_;
  std::unique_ptr<Preview> preview_;
  std::unique_ptr<Session> session_, opened_;   // the second by the loader, until it has landed
  std::shared_ptr<compare::Comparison> found_;  // with what is read now; null where a model is read
  std::unique_ptr<Loader> loader_;              // its thread uses those before
  std::unique_ptr<ModelExport> model_export_;   // reads the session's scene
  OpeningSteps opening_;
  engine::Looks looks_;              // with shading and hatching also while these are off
  int engine_portions_ = 0;          // calls of Session::begin()
  bool keeps_moving_image_ = false;  // the window shows it until the image at rest is complete
  bool swapping_in_ = false;         // it is done, and opened_ is brought into the window's context
  std::unique_ptr<Export> export_;   // with the session's engine
  bool export_cancelled_ = false;
  ViewList views_;
  FileDialog file_dialog_;
  FileStates file_states_;
  Thumbnails thumbnails_;
  bool thumbnail_due_ = false;  // of the model that was opened last, once its image is complete
  ImageTextures textures_;
  std::vector<std::string> files_;
  bool recognised_ = false;  // whether primitives were, when these were read
  SettingsFile settings_;
  Settings now_;  // but for recent files as of the last keep_settings()
  PathPlayer player_;
  std::optional<PathRecorder> recorder_;
  std::vector<ScriptStep> script_;
  std::size_t next_step_ = 0;
  double wait_until_ = 0.0;
  std::optional<Event> release_;  // of a key that the script holds until then
  std::string window_shot_;       // file for the next frame's image of the window
  std::set<int> held_;            // keys
  std::optional<Walker> walker_;
  std::optional<Drag> drag_, click_;  // the second until picks do not wait
  SectionHandles section_handles_;    // while one is dragged, drag_ is that motion
  double last_click_ = -1.0;          // GLFW's time, of one without modifiers
  core::dvec2 last_click_at_{0.0};
  core::dvec2 cursor_{-1.0};
  std::optional<engine::Pick> context_face_;
  std::optional<core::dvec3> cursor_point_;
  bool cursor_moved_ = false;
  // When the item under the cursor was last looked for: the document's version, and the camera.
  std::uint64_t hovered_version_ = 0;
  std::optional<core::View> hovered_view_;
  bool context_lost_ = false;
  int recovered_ = 0;  // times that the context was made anew
  std::optional<measure::Snap> aimed_;
  int redraws_ = kSettlingFrames;  // frames to draw though nothing has happened
  Part part_;
  std::string message_;
  bool message_is_error_ = false, message_is_new_ = false;  // since the last frame
  MotionResolution motion_;
  std::optional<core::View> shown_view_;  // of the last frame
  double frame_seconds_ = 0.0;            // that it took
  double next_frame_ = 0.0;               // while a model lands: when the window is drawn again, unless events come
  double asked_at_ = -1.0;                // when the first of the events came that wait; 0: answered; below 0: none
  double response_ms_ = 0.0;              // from then until the end of the frame that answered it
  double pause_ms_ = 0.0;                 // the longest time that events have waited for the loop
  std::vector<double> cull_ms_, frame_ms_;
  FrameHistory history_;
  CullingOverlay culling_;
  int frames_ = 0;
};

}  // namespace sightline::apps
