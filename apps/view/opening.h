// Opens models, from a file's name to the image in the window, and reads older revisions to compare with.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sightline/apps/view/loader.h"
#include "sightline/apps/view/opening_steps.h"
#include "sightline/apps/view/preview.h"
#include "sightline/apps/view/session.h"

namespace sightline::apps {

class Opening {
 public:
  /// `options`: of all models that are opened. `default_budget_ms`: Session::set_default_budget().
  Opening(ModelOptions options, double default_budget_ms)
      : options_(std::move(options)), default_budget_ms_(default_budget_ms) {}

  /// Begins to read and to make the session of these files, in place of what was being read. `config`: of its images;
  /// `previews`: shows the largest items until the session is there.
  void open(const std::vector<std::string>& files, const engine::EngineConfig& config, Reading reading, bool previews);
  /// Begins to read an older revision of what is open, which must stay until that is done.
  void compare(const std::string& file, const Session& open);
  void cancel();
  /// Gives up what is being read.
  void drop();

  /// What was being read, once it is there; at most one of them.
  struct Opened {
    std::unique_ptr<Session> session;
    std::unique_ptr<ChangeList> changes;
  };
  /// Goes on for a moment: a model comes into the window's context, which is current, portion by portion, while the
  /// window goes on. Where it fails, unless the context was lost, what was being read is given up.
  core::Expected<Opened> step(gl::Context& context, const std::array<int, 2>& size);

  bool active() const { return loader_ != nullptr; }
  /// Whether a session is coming into the window's context.
  bool swapping_in() const { return swapping_in_; }
  /// Whether an older revision is being read, by somebody who reads the open model's scene.
  bool comparing() const { return loader_ && found_; }
  double progress() const { return loader_ ? loader_->progress() : 0.0; }
  /// The files that are being read.
  const std::vector<std::string>& files() const { return loader_->options().files; }
  /// Whether damaged files among them are kept as far as they can be read.
  bool lenient() const { return loader_ && loader_->options().import.lenient; }
  const OpeningSteps& steps() const { return steps_; }
  int portions() const { return portions_; }  ///< calls of Session::begin()
  /// Session::first_image() of the model that is coming in; null while there is none.
  const image::Image* first_image() const { return swapping_in_ ? opened_->first_image() : nullptr; }
  const Preview* preview() const { return preview_.get(); }  ///< of the model that is being read, if no other is open
  Preview* preview() { return preview_.get(); }

  /// Whether y is up in files that do not say so, because the user says it or because the open ones were turned for it.
  bool y_is_up(const Session* open) const;
  /// Changes the axis that points up in such files from now on.
  void toggle_up(const Session* open);

 private:
  core::Expected<Opened> land(gl::Context& context, const std::array<int, 2>& size);
  void begin(const ModelOptions& model, Loader::Work work);
  void follow();

  ModelOptions options_;
  double default_budget_ms_;
  std::unique_ptr<Preview> preview_;
  std::unique_ptr<Session> opened_;  // by the loader, until it has landed
  std::shared_ptr<Compared> found_;  // with what is read now; null where a model is read
  std::unique_ptr<Loader> loader_;   // its thread uses those before
  OpeningSteps steps_;
  int portions_ = 0;
  bool swapping_in_ = false;  // the loader is done, and opened_ is brought into the window's context
};

/// Whether reading these files again without what is damaged may help: all are models that are there, and the readers
/// of some can leave out damage.
bool readable_in_part(const std::vector<std::string>& files);

/// "plant.rvm and 2 more".
std::string name_of_files(const std::vector<std::string>& files);

}  // namespace sightline::apps
