// What drawing a task gave, as it is kept in the folder of results:
//
//   OUT/MODEL/VIEW/result.json      written last: where it is, the task is done
//   OUT/MODEL/VIEW/image.png, ids.png
//
// Whether a task passes follows from its result and its limits, so that other limits need no new images.
#pragma once

#include "sightline/apps/regress/suite.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {

struct TaskResult {
  std::string key, files_key;  ///< of the task, when it was drawn
  std::string error;           ///< why there is no image; empty where there is one
  std::string unlike;          ///< why it cannot be compared: no reference, another size
  image::ImageDifference difference;
  double flip = 0.0;            ///< mean; 0 for images below 11 pixels
  std::uint64_t wrong_ids = 0;  ///< pixels that show another item
  std::string renderer;         ///< as GL names it
  double seconds = 0.0;         ///< to draw and to compare
};

enum class Status : std::uint8_t {
  kPassed,
  kFailed,
  kError,     ///< there is no image
  kAccepted,  ///< it failed, and its image is the reference now
  kMissing,   ///< nobody has done it
};
std::string_view name_of(Status status);

/// A figure as a printf format for one double writes it.
std::string number(double value, const char* format = "%.4g");

Status judge(const std::optional<TaskResult>& result, const Limits& limits);
/// One line: what is beyond which limit, or the error; empty for what passed.
std::string reason(const std::optional<TaskResult>& result, const Limits& limits);

/// A folder of results.
class ResultFolder {
 public:
  explicit ResultFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  const std::filesystem::path& path() const { return folder_; }
  std::filesystem::path image(const Task& task) const { return folder_ / task.name / "image.png"; }
  std::filesystem::path ids(const Task& task) const { return folder_ / task.name / "ids.png"; }

  /// Nothing where there is none that can be read, and where it is of another task.
  std::optional<TaskResult> read(const Task& task) const;
  /// Replaces what is there.
  core::Expected<void> write(const Task& task, const TaskResult& result) const;
  /// Removes the result, and leaves images.
  core::Expected<void> remove(const Task& task) const;
  core::Expected<void> make_place(const Task& task) const;
  /// Copies result and images of a task; they are there whole, or not at all. False where `from` has no result.
  core::Expected<bool> take(const Task& task, const ResultFolder& from) const;

 private:
  std::filesystem::path result(const Task& task) const { return folder_ / task.name / "result.json"; }

  std::filesystem::path folder_;
};

/// Replaces `to` by a copy, whole or not at all; makes its folder.
core::Expected<void> copy_whole(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace sightline::apps
