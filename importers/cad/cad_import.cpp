#include "sightline/importers/cad/internal/cad_import.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sightline/core/internal/platform/memory.h"
#include "sightline/core/internal/platform/process.h"
#include "sightline/importers/cad/internal/cad_messages.h"
#include "sightline/importers/cad/internal/temporary_folder.h"
#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/loaded_module.h"
#include "sightline/importers/slc/internal/slc_scene.h"

namespace sightline::importers {
namespace {

namespace fs = std::filesystem;
using Read = decltype(&import_cad);
using core::platform::ChildProcess, core::platform::ProcessEnd;

core::Expected<ImportReport> read_by_module(const fs::path& path, core::Scene& scene, core::NodeId parent,
                                            const ImportOptions& options) {
  static const LoadedModule module = load_module("libsightline_cad.so", "sightline_read_cad");
  if (!module.entry)
    return core::fail(fmt::format("{}: this format needs libsightline_cad.so beside the program: {}",
                                  path.filename().string(), module.error));
  return (*static_cast<const Read*>(module.entry))(path, scene, parent, options);
}

std::uint64_t memory_limit() {
  return core::platform::physical_memory() / 4 * 3;
}

std::uint64_t second_limit(const fs::path& path) {
  std::error_code ignored;
  return 120 + 60 * (std::uint64_t(fs::file_size(path, ignored)) >> 20);
}

/// The reader as a process: what it says, and how it ended. Killed when this goes.
class Reader {
 public:
  core::Expected<void> start(const std::vector<std::string>& command) {
    auto process = ChildProcess::start(command, {});
    if (!process) return core::fail(fmt::format("{} cannot be started: {}", command[0], process.error().message));
    process_ = std::move(*process);
    return {};
  }

  /// Waits a little for more; false at the end.
  bool listen() {
    constexpr std::chrono::milliseconds kWait(50);
    const ChildProcess* const process = &process_;
    ChildProcess::wait_for_answers({&process, 1}, kWait);
    const bool more = process_.read(said_) != ChildProcess::Heard::kEnd;
    take_lines();
    return more;
  }

  ProcessEnd wait() { return process_.wait(); }

  double share() const { return share_; }
  const std::string& error() const { return error_; }
  std::vector<fs::path>& side_files() { return side_files_; }

 private:
  void take_lines() {
    for (std::size_t end; (end = said_.find('\n')) != std::string::npos; said_.erase(0, end + 1)) {
      const std::string_view line = std::string_view(said_).substr(0, end),
                             text = line.substr(std::min<std::size_t>(2, end));
      if (line.starts_with(cad::kProgress)) std::from_chars(text.data(), text.data() + text.size(), share_);
      if (line.starts_with(cad::kSideFile)) side_files_.emplace_back(text);
      if (line.starts_with(cad::kError)) error_ = text;
    }
  }

  ChildProcess process_;
  std::string said_, error_;
  double share_ = 0.0;
  std::vector<fs::path> side_files_;
};

/// Why a reader that said nothing has no result.
std::string end_of(const ProcessEnd& end, std::uint64_t seconds) {
  if (end.kind == ProcessEnd::Kind::kOutOfTime)
    return fmt::format("Open CASCADE took more than {} s of processor time (reading in this process has no limit)",
                       seconds);
  if (end.kind == ProcessEnd::Kind::kCrashed)
    return fmt::format("Open CASCADE crashed while it read this file ({})", end.name);
  return fmt::format("its reader ended with {}", end.code);
}

constexpr double kHandingOver = 0.05;  // share of the time

std::vector<std::string> command_for(const fs::path& program, const fs::path& path, const fs::path& result,
                                     const ImportOptions& options) {
  const auto option = [](const char* key, const auto& value) { return fmt::format("{}={}", key, value); };
  return {program.string(),
          path.string(),
          result.string(),
          option(cad::kTolerance, options.chord_tolerance),
          option(cad::kAngle, options.chord_angle),
          option(cad::kLenient, int(options.lenient)),
          option(cad::kThreads, options.threads),
          option(cad::kMemory, memory_limit()),
          option(cad::kSeconds, second_limit(path))};
}

/// Waits for the reader's end, and returns it; nothing where the caller cancels. `shown` rises.
std::optional<ProcessEnd> wait_for(Reader& reader, const ImportOptions& options, double& shown) {
  while (reader.listen()) {
    shown = std::max(shown, (1.0 - kHandingOver) * reader.share());
    if (options.progress && !options.progress(shown)) return std::nullopt;
  }
  return reader.wait();
}

core::Expected<ImportReport> take_over(const fs::path& path, const fs::path& result, core::Scene& scene,
                                       core::NodeId parent, const ImportOptions& options) {
  ImportOptions handing_over;
  if (options.progress)
    handing_over.progress = [&](double share) { return options.progress(1.0 - kHandingOver * (1.0 - share)); };
  auto report = read_slc(result, scene, parent, handing_over);
  if (!report) return report;
  report->from_cache = false;
  std::error_code ignored;
  report->bytes = fs::file_size(path, ignored);
  return report;
}

core::Expected<ImportReport> read_apart(const fs::path& path, core::Scene& scene, core::NodeId parent,
                                        const ImportOptions& options) {
  const std::string name = path.filename().string();
  const auto program = find_program(cad::kProgram);
  if (!program)
    return core::fail(
        fmt::format("{}: this format needs {} beside the program (package sightline-occt)", name, cad::kProgram));
  const TemporaryFolder folder;
  if (folder.path().empty()) return core::fail(fmt::format("{}: no temporary folder can be made", name));
  const fs::path result = folder.path() / "scene.slc";
  std::vector<std::string> command = command_for(*program, path, result, options);
  std::string crash;  // of the first reader
  double shown = 0.0;
  for (;;) {
    Reader reader;
    if (auto started = reader.start(command); !started)
      return core::fail(fmt::format("{}: {}", name, started.error().message));
    const auto end = wait_for(reader, options, shown);
    if (!end) return core::fail(std::string(kCancelled));
    if (end->kind == ProcessEnd::Kind::kExited && end->code == 0) {
      auto report = take_over(path, result, scene, parent, options);
      if (!report) return report;
      report->side_files = std::move(reader.side_files());
      if (!crash.empty()) report->warnings.insert(report->warnings.begin(), {name, 0, crash + cad::shapes_alone(path)});
      return report;
    }
    const bool crashed = end->kind == ProcessEnd::Kind::kCrashed;
    if (crash.empty() && !reader.error().empty()) return core::fail(reader.error());
    if (!crash.empty() || !crashed)
      return core::fail(fmt::format("{}: {}", name, crash.empty() ? end_of(*end, second_limit(path)) : crash));
    crash = end_of(*end, 0);
    command.push_back(fmt::format("{}=1", cad::kShapesAlone));
  }
}

}  // namespace

core::Expected<ImportReport> import_cad(const fs::path& path, core::Scene& scene, core::NodeId parent,
                                        const ImportOptions& options) {
  return with_whole_path(
      options.in_process ? read_by_module(path, scene, parent, options) : read_apart(path, scene, parent, options),
      path);
}

}  // namespace sightline::importers
