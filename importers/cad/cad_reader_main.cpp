// sightline-cad-reader: reads one file of exact surfaces and writes a scene cache. cad_import.cpp starts it; people use
// sightline-convert.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/core/internal/platform/console.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/core/internal/platform/process.h"
#include "sightline/importers/cad/internal/cad_messages.h"
#include "sightline/importers/cad/internal/cad_reader.h"
#include "sightline/importers/slc/slc_writer.h"

namespace {

using namespace sightline;
namespace cad = importers::cad;
namespace platform = core::platform;

/// A sanitizer reserves more address space than any limit leaves.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

/// Ends the process where nobody listens any more.
void say(const platform::AnswerPipe& listener, char kind, std::string_view text) {
  std::string line{kind, ' '};
  line.append(text);
  std::replace(line.begin(), line.end(), '\n', ' ');
  line.push_back('\n');
  if (!listener.write(line)) platform::end_at_once(EXIT_FAILURE);
}

template <class T>
T number(std::string_view text) {
  T value{};
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

importers::ImportOptions options_from(std::span<const std::string> arguments, importers::CadDetail& detail) {
  importers::ImportOptions options;
  platform::ProcessLimits limits;
  for (const std::string_view argument : arguments) {
    const std::string_view name = argument.substr(0, argument.find('=')),
                           value = argument.substr(std::min(argument.size(), name.size() + 1));
    if (name == cad::kTolerance) options.chord_tolerance = number<double>(value);
    if (name == cad::kAngle) options.chord_angle = number<double>(value);
    if (name == cad::kLenient) options.lenient = value == "1";
    if (name == cad::kThreads) options.threads = number<int>(value);
    if (name == cad::kShapesAlone && value == "1") detail = importers::CadDetail::kShapesAlone;
    if (name == cad::kMemory && value != "0" && !kSanitized) limits.memory = number<std::uint64_t>(value);
    if (name == cad::kSeconds) limits.seconds = number<std::uint64_t>(value);
  }
  platform::limit_this_process(limits);
  return options;
}

core::Expected<void> run(const platform::AnswerPipe& listener, const std::filesystem::path& file,
                         const std::filesystem::path& result, importers::ImportOptions options,
                         importers::CadDetail detail) {
  constexpr double kReading = 0.9;  // share of the time
  const auto progress = [listener](double begin, double share) {
    return [=](double done) {
      say(listener, cad::kProgress, std::to_string(begin + share * done));
      return true;
    };
  };
  options.progress = progress(0.0, kReading);
  core::Scene scene;
  const auto report = importers::read_cad(file, scene, scene.root(), options, detail);
  if (!report) return tl::unexpected(report.error());
  for (const auto& path : report->side_files) say(listener, cad::kSideFile, path.string());
  return importers::write_slc(scene, result, {.report = &*report, .progress = progress(kReading, 1.0 - kReading)});
}

}  // namespace

int main(int count, char** words) {
  const std::vector<std::string> arguments = platform::begin_program(count, words);
  const auto listener = platform::AnswerPipe::of_this_process();
  if (arguments.size() < 3 || !listener) {
    std::fprintf(stderr,
                 "sightline-cad-reader: is started by the library, which reads with it; use sightline-convert\n");
    return EXIT_FAILURE;
  }
  platform::end_with_parent();
  const auto file = platform::path_of(arguments[1]), result = platform::path_of(arguments[2]);
  // Files that a crash leaves behind go with the folder of the result.
  platform::set_temporary_folder(result.parent_path());
  platform::write_no_core_dumps();
  auto detail = importers::CadDetail::kAll;
  const importers::ImportOptions options = options_from(std::span(arguments).subspan(3), detail);
  const auto done = run(*listener, file, result, options, detail);
  if (!done) say(*listener, cad::kError, done.error().message);
  std::fflush(nullptr);
  // Open CASCADE has nothing left to do; its static objects take time to go, and may fail to.
  platform::end_at_once(done ? EXIT_SUCCESS : EXIT_FAILURE);
}
