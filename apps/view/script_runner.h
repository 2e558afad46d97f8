// Carries out a script in the viewer, a step at a time.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sightline/apps/view/messages.h"
#include "sightline/apps/view/script.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

struct Workspace;

class ScriptRunner {
 public:
  /// Without a file there is nothing to do.
  Done read(const std::string& file);
  bool has_steps() const { return next_ < steps_.size(); }
  /// Whether there was a script, and nothing of it goes on.
  bool ended() const;
  /// Whether a step takes some time, which is not over, or an image of the window.
  bool waits() const;
  /// Carries out the next step; fails where it fails, with its line.
  Done step(Workspace& work);
  /// Lets go of a key that was held long enough.
  void follow(Workspace& work);
  /// The file for the next frame's image of the window; empty for none.
  std::string take_window_shot() { return std::exchange(window_shot_, {}); }

 private:
  Done carry_out(const ScriptStep& step, Workspace& work);
  Done hold(const ScriptStep& step, Workspace& work);

  std::string file_;
  std::vector<ScriptStep> steps_;
  std::size_t next_ = 0;
  double wait_until_ = 0.0;
  std::optional<Event> release_;  // of a key that is held until then
  std::string window_shot_;
};

/// What scripts and --json see.
json::Value state_json(const Workspace& work);

}  // namespace sightline::apps
