// What the file system says of files that panels name in every frame. It may lie far away, so it is asked seldom.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>

namespace sightline::apps {

struct FileState {
  bool there = false;
  std::uint64_t bytes = 0;
  std::filesystem::file_time_type changed;
};

FileState state_of(const std::filesystem::path& file);

class FileStates {
 public:
  static constexpr double kSeconds = 3.0;
  using Clock = std::function<double()>;  ///< seconds
  using Ask = std::function<FileState(const std::filesystem::path&)>;

  explicit FileStates(Clock clock, Ask ask = &state_of) : clock_(std::move(clock)), ask_(std::move(ask)) {}

  /// As of at most kSeconds ago.
  const FileState& of(const std::string& file);

 private:
  struct Asked {
    FileState state;
    double at;
  };
  Clock clock_;
  Ask ask_;
  std::map<std::string, Asked> known_;
};

}  // namespace sightline::apps
