// sightline-cad-reader: reads one file of exact surfaces and writes a scene cache. cad_import.cpp starts it; people use
// sightline-convert.
#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "sightline/importers/cad/internal/cad_messages.h"
#include "sightline/importers/cad/internal/cad_reader.h"
#include "sightline/importers/slc/slc_writer.h"

namespace {

using namespace sightline;
namespace cad = importers::cad;

/// A sanitizer reserves more address space than any limit leaves.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

void say(char kind, std::string_view text) {
  std::string line{kind, ' '};
  line.append(text);
  std::replace(line.begin(), line.end(), '\n', ' ');
  line.push_back('\n');
  for (std::string_view left = line; !left.empty();) {
    const auto written = write(cad::kMessages, left.data(), left.size());
    if (written <= 0) _exit(EXIT_FAILURE);  // nobody listens any more
    left.remove_prefix(std::size_t(written));
  }
}

void limit(int what, std::uint64_t to) {
  rlimit limits{};
  getrlimit(decltype(RLIMIT_AS)(what), &limits);
  limits.rlim_cur = std::min<rlim_t>(limits.rlim_max, to);
  setrlimit(decltype(RLIMIT_AS)(what), &limits);
}

template <class T>
T number(std::string_view text) {
  T value{};
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

importers::ImportOptions options_from(int count, char** arguments, importers::CadDetail& detail) {
  importers::ImportOptions options;
  limit(RLIMIT_CORE, 0);
  for (int i = 0; i < count; ++i) {
    const std::string_view argument = arguments[i], name = argument.substr(0, argument.find('=')),
                           value = argument.substr(std::min(argument.size(), name.size() + 1));
    if (name == cad::kTolerance) options.chord_tolerance = number<double>(value);
    if (name == cad::kAngle) options.chord_angle = number<double>(value);
    if (name == cad::kLenient) options.lenient = value == "1";
    if (name == cad::kThreads) options.threads = number<int>(value);
    if (name == cad::kShapesAlone && value == "1") detail = importers::CadDetail::kShapesAlone;
    if (name == cad::kMemory && value != "0" && !kSanitized) limit(RLIMIT_AS, number<std::uint64_t>(value));
    if (name == cad::kSeconds) limit(RLIMIT_CPU, number<std::uint64_t>(value));
  }
  return options;
}

core::Expected<void> run(const char* file, const char* result, importers::ImportOptions options,
                         importers::CadDetail detail) {
  constexpr double kReading = 0.9;  // share of the time
  const auto progress = [&](double begin, double share) {
    return [=](double done) {
      say(cad::kProgress, std::to_string(begin + share * done));
      return true;
    };
  };
  options.progress = progress(0.0, kReading);
  core::Scene scene;
  const auto report = importers::read_cad(file, scene, scene.root(), options, detail);
  if (!report) return tl::unexpected(report.error());
  for (const auto& path : report->side_files) say(cad::kSideFile, path.string());
  return importers::write_slc(scene, result, {.report = &*report, .progress = progress(kReading, 1.0 - kReading)});
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 3 || fcntl(cad::kMessages, F_GETFD) < 0) {
    std::fprintf(stderr,
                 "sightline-cad-reader: is started by the library, which reads with it; use sightline-convert\n");
    return EXIT_FAILURE;
  }
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // Files that a crash leaves behind go with the folder of the result.
  setenv("TMPDIR", std::filesystem::path(arguments[2]).parent_path().c_str(), 1);
  auto detail = importers::CadDetail::kAll;
  const importers::ImportOptions options = options_from(count - 3, arguments + 3, detail);
  const auto done = run(arguments[1], arguments[2], options, detail);
  if (!done) say(cad::kError, done.error().message);
  std::fflush(nullptr);
  // Open CASCADE has nothing left to do; its static objects take time to go, and may fail to.
  _exit(done ? EXIT_SUCCESS : EXIT_FAILURE);
}
