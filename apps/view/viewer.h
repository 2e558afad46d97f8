// The viewer's loop: what happens in the window, what was opened or written meanwhile, and then a frame. What commands
// and panels act on is its workspace.
#pragma once

#include "sightline/apps/view/script_runner.h"
#include "sightline/apps/view/workspace.h"

namespace sightline::apps {

class Viewer {
 public:
  Viewer(const ViewerOptions& options, Window& window, Gui gui, SettingsFile settings = {});

  /// Until the window is closed, the frames are drawn or the script has ended. Fails with what a tool should end with.
  core::Expected<int> run();

 private:
  Done begin();
  Done finish();
  bool lost() const { return work_.pace.context_lost || work_.window.context().lost(); }
  Done recover();
  bool closing();
  Done step_exports();
  Done land();
  Done not_landed(const core::Error& error, const std::vector<std::string>& files);
  Done landed(std::unique_ptr<Session> session, bool lenient);
  Done read_path();

  // When to draw, and how long to wait.
  double patience() const;
  bool busy() const;
  bool settled() const { return settled_but_for_edges() && !refining() && !work_.finer.active(); }
  bool settled_but_for_edges() const { return at_rest() && !work_.gestures.waits_for_picks(); }
  bool at_rest() const;
  bool refining() const;
  core::Expected<bool> draws_alone();
  Done refine_meshes();

  // A frame.
  Done frame(double seconds);
  void take_events();
  void play();
  void draw_panels();
  Done draw_model(const Part& part);
  void end_frame(double began);

  void keep_session();
  std::filesystem::path last_session() const {
    return std::filesystem::path(settings_.file()).replace_extension(".sightline");
  }
  void keep_settings();
  void keep_thumbnail();

  Workspace work_;
  SettingsFile settings_;
  ScriptRunner script_;
  bool thumbnail_due_ = false;  // of the model that was opened last, once its image is complete
};

}  // namespace sightline::apps
