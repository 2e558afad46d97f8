// Writes models in the background.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "sightline/apps/view/session.h"

namespace sightline::apps {

class ModelExport {
 public:
  /// What is written, and where to.
  struct Job {
    const core::Scene* scene = nullptr;
    std::vector<core::NodeId> tops;                   ///< children of its root that have the model's files
    std::optional<std::vector<bool>> items = {};      ///< those by ItemId, with the nodes above them; none: all
    const importers::ImportReport* report = nullptr;  ///< of the files
    std::string file;
  };
  /// Fails where the name is not one of a model file, or that of a file that the session has read.
  static core::Expected<Job> model(const Session& session, const std::string& file);
  /// Exports the selected items that the model has; removed ones of a comparison it has not.
  static core::Expected<Job> selection(const Session& session, const std::string& file);

  /// Begins to write. The scene must outlive this, and nobody may edit it meanwhile. Calls `ready` from its thread when
  /// it is done. The file appears whole or not at all.
  ModelExport(Job job, std::function<void()> ready);
  /// Cancels what is not done.
  ~ModelExport();
  ModelExport(const ModelExport&) = delete;
  ModelExport& operator=(const ModelExport&) = delete;

  const std::string& file() const { return job_.file; }
  double progress() const { return progress_; }  ///< 0 to 1
  void cancel() { cancelled_ = true; }
  bool cancelled() const { return cancelled_; }
  /// What was written, in words, once it is done.
  std::optional<core::Expected<std::string>> take();

 private:
  core::Expected<std::string> write();

  Job job_;
  std::atomic<double> progress_ = 0.0;
  std::atomic<bool> cancelled_ = false, done_ = false;
  std::optional<core::Expected<std::string>> result_;  // written before done_
  std::jthread thread_;                                // last: it uses the others
};

}  // namespace sightline::apps
