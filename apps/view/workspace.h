// The parts of the viewer that commands and panels act on. Each function takes those that it uses; with() finds them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "sightline/apps/common/finer_meshes.h"
#include "sightline/apps/common/numbers.h"
#include "sightline/apps/view/culling_overlay.h"
#include "sightline/apps/view/exports.h"
#include "sightline/apps/view/file_dialog.h"
#include "sightline/apps/view/file_states.h"
#include "sightline/apps/view/gestures.h"
#include "sightline/apps/view/gui.h"
#include "sightline/apps/view/image_loop.h"
#include "sightline/apps/view/image_textures.h"
#include "sightline/apps/view/messages.h"
#include "sightline/apps/view/opening.h"
#include "sightline/apps/view/path_player.h"
#include "sightline/apps/view/saved_session.h"
#include "sightline/apps/view/shown.h"
#include "sightline/apps/view/thumbnails.h"
#include "sightline/apps/view/view_list.h"

namespace sightline::apps {

/// When the window is drawn again, and how soon it answers.
struct Pace {
  static constexpr int kSettlingFrames = 3;  // after an event: widgets take some to come to rest

  /// Times as long as a frame took: frames of a large window must not delay opening.
  static constexpr double kBetweenFrames = 3.0;

  void redraw() { redraws = kSettlingFrames; }

  int redraws = kSettlingFrames;  ///< frames to draw though nothing has happened
  double frame_seconds = 0.0;     ///< that the last frame took
  double next_frame = 0.0;        ///< while a model lands: when the window is drawn again, unless events come
  double asked_at = -1.0;         ///< when the first of the events came that wait; 0: answered; below 0: none
  double response_ms = 0.0;       ///< from then until the end of the frame that answered it
  double pause_ms = 0.0;          ///< the longest time that events have waited for the loop
  bool context_lost = false;      ///< as if the driver had lost the window's context
  int recovered = 0;              ///< times that the context was made anew
};

/// Models that could not be opened though some of them may be readable in part, and why.
struct Damaged {
  std::vector<std::string> files;
  std::string message;
};

struct Workspace {
  /// In a window that must outlive it.
  Workspace(const ViewerOptions& asked_for, Window& in, Gui widgets, const Settings& settings);

  /// Where the model is drawn: between the panels.
  Part viewport() const;
  LengthFormat lengths() const;  ///< of the open model
  std::vector<std::string> files() const { return session ? session->files : std::vector<std::string>(); }
  /// Models, or one saved session; `lenient`: without what is damaged.
  void open(const std::vector<std::string>& files, bool lenient = false);
  /// The models of a session; once they are there, they are shown as it says (Workspace::returning).
  void open(SavedSession saved);
  /// Opens what could not be opened, without what is damaged; warnings name that.
  void open_damaged();
  bool offers_damaged() const { return !damaged.files.empty() && damaged.message == messages.text(); }
  /// Reads what is open again, as before but for the switches that hold now.
  void read_again();
  std::optional<SavedSession> to_save() const;  ///< none where no model is open
  /// Shows the images of the model that is open as the switches say.
  Done apply_styles();
  /// The error of meshes, by levels of detail, while the view moves; 0: none.
  Done set_motion_error(double pixels);
  /// Gives items the meshes that they came with, for somebody who reads the scene from now on.
  Done show_own_meshes();
  /// Fails while somebody reads the scene, which must not be edited then.
  Done scene_is_free() const;

  /// The part of a type.
  template <class PartOf>
  PartOf& get();

  const ViewerOptions options;
  Window& window;
  Gui gui;
  Shown shown;
  Messages messages;
  Pace pace;
  std::unique_ptr<Session> session;       ///< null while no model is open
  std::optional<SavedSession> returning;  ///< how the models that are being read will be shown
  std::string session_file;               ///< that what is open was saved to, or came from; or empty
  std::optional<SavedSession> last;       ///< what was open when the viewer was closed, until something else is open
  Damaged damaged;                        ///< until something else is opened
  FinerMeshes finer;                      ///< of the session's scene
  Opening opening;
  Exports exports;
  ImageLoop image;
  Gestures gestures;
  PathPlayer player;
  std::optional<PathRecorder> recorder;
  ViewList views;  ///< stays when another model is opened
  CullingOverlay culling;
  FileDialog file_dialog;
  FileStates file_states;  ///< of files that panels name
  Thumbnails thumbnails;
  ImageTextures textures;  ///< of small images in panels

 private:
  void open_models(const std::vector<std::string>& files, bool lenient);
};

template <class PartOf>
PartOf& Workspace::get() {
  if constexpr (std::is_same_v<PartOf, Workspace>)
    return *this;
  else if constexpr (std::is_same_v<PartOf, Session>)
    return *session;
  else
    return std::get<PartOf&>(std::tie(shown, messages, opening, exports, gestures, player, views, culling));
}

/// A function of commands from one that takes the parts which it uses: `with<show_view>`.
template <class... Parts>
Done call(Done (*work)(const std::string&, Parts&...), Workspace& workspace, const std::string& argument) {
  return work(argument, workspace.get<std::remove_const_t<Parts>>()...);
}
template <auto kWork>
Done with(Workspace& work, const std::string& argument) {
  return call(kWork, work, argument);
}

}  // namespace sightline::apps
