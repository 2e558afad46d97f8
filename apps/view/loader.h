// Reads models in the background.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <thread>

#include "sightline/apps/common/model.h"

namespace sightline::apps {

class Loader {
 public:
  /// Something to do with the committed model. Ends soon after `progress`, which takes the share that is done, has
  /// returned false. Its failure is the loader's.
  using Work = std::function<core::Expected<void>(Model& model, const std::function<bool(double)>& progress)>;

  /// Begins to read, and prints nothing. Then does `work`, if there is any. Calls `ready` from its thread when it is
  /// done.
  Loader(const ModelOptions& options, std::function<void()> ready, Work work = {});
  /// Cancels what is not done.
  ~Loader();
  Loader(const Loader&) = delete;
  Loader& operator=(const Loader&) = delete;

  const ModelOptions& options() const { return options_; }
  double progress() const { return progress_; }  ///< 0 to 1
  /// When the files were read, or found unreadable; zero before that.
  std::chrono::steady_clock::time_point read_at() const { return read_at_; }
  void cancel() { cancelled_ = true; }
  bool cancelled() const { return cancelled_; }
  /// The model, committed, once it is ready.
  std::optional<core::Expected<Model>> take();

 private:
  void run(const std::function<void()>& ready, const Work& work);
  core::Expected<Model> read(const Work& work);

  ModelOptions options_;
  std::atomic<double> progress_ = 0.0;
  std::atomic<std::chrono::steady_clock::time_point> read_at_{};
  std::atomic<bool> cancelled_ = false, done_ = false;
  std::optional<core::Expected<Model>> result_;  // written before done_
  std::jthread thread_;                          // last: it uses the others
};

}  // namespace sightline::apps
