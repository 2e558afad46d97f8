// hostile_table: damaged and malicious files against every reader of this build, each import in a process of its own
// with little address space, so that a crash or too much memory is a result and not the end.
//
//   hostile_table [--mutations N] [--json]      Markdown, or JSON, on stdout
//
// N is the number of cases of each random attack. A short run makes 50 of them, at most 50 of each other attack, evenly
// chosen, and leaves out what takes long for the sake of most memory, which importers_tests measures. With
// SIGHTLINE_LONG at 1 there are 500, and all of the others.
//
// Exits 1 when an import crashed, took more memory than its bound, ran too long, or read what lies outside the model's
// directory.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sightline/importers/import.h"
#include "sightline/importers/internal/file_bytes.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/tests/hostile/check.h"
#include "sightline/tests/support/effort.h"

namespace sightline::hostile {

namespace {

namespace fs = std::filesystem;

/// Address space beyond what the process has already: the largest factor that a reader's header states, and what a
/// library needs however small the file is.
constexpr std::size_t kBytesPerByte = 1000, kConstantBytes = std::size_t{64} << 20;
constexpr rlim_t kSeconds = 20;
/// Cases of an attack in a short run.
constexpr std::size_t kShortRun = 20;

// --- in a child ----------------------------------------------------------------------------------------------------

/// What the child tells: plain bytes, for a pipe.
struct Told {
  bool imported_strict = false, imported_lenient = false, broken = false, leaked = false;
  double slowest_ms = 0.0;
  char message[200] = {};
};

core::Expected<importers::ImportReport> import_by_path(const Target& target, const fs::path& model, core::Scene& scene,
                                                       core::NodeId parent, const importers::ImportOptions& options) {
  if (target.extension != ".json") return importers::import_file(model, scene, parent, options);
  const auto bytes = importers::read_file_bytes(model);
  if (!bytes) return tl::unexpected(bytes.error());
  return target.read(*bytes, model, scene, parent, options);
}

Finding import_model(const Target& target, const Case& made, const fs::path& model, bool lenient, Told& told) {
  using Clock = std::chrono::steady_clock;
  return check(target, made, lenient, [&](core::Scene& scene, core::NodeId parent, const auto& options) {
    const auto start = Clock::now();
    auto report = import_by_path(target, model, scene, parent, options);
    const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    told.slowest_ms = std::max(told.slowest_ms, ms);
    return report;
  });
}

Told import_both_ways(const Target& target, const Case& made, const fs::path& model) {
  Told told;
  const Finding strict = import_model(target, made, model, false, told);
  const Finding lenient = import_model(target, made, model, true, told);
  told.imported_strict = strict.imported;
  told.imported_lenient = lenient.imported;
  told.broken = !strict.broken.empty() || !lenient.broken.empty() || (strict.imported && !lenient.imported);
  told.leaked = strict.leaked || lenient.leaked;
  for (const std::string& message : {strict.broken, lenient.broken, strict.message, lenient.message})
    if (told.message[0] == 0) std::snprintf(told.message, sizeof told.message, "%s", message.c_str());
  return told;
}

// --- in the parent ---------------------------------------------------------------------------------------------------

struct Outcome {
  Told told;
  bool crashed = false;  ///< ended by a signal: a crash, or CPU time used up
  std::uint64_t peak_kib = 0;
};

rlim_t address_space_in_use() {
  std::ifstream statm("/proc/self/statm");
  rlim_t pages = 0;
  statm >> pages;
  return pages * rlim_t(sysconf(_SC_PAGESIZE));
}

void limit(int what, rlim_t most) {
  const rlimit both{most, most};
  setrlimit(__rlimit_resource_t(what), &both);
}

/// Runs `work` in a child with limits; the rest is what became of it.
template <class Work>
Outcome in_child(std::size_t file_bytes, const Work& work) {
  int ends[2];
  Outcome outcome;
  if (pipe(ends) != 0) std::exit(2);
  const pid_t child = fork();
  if (child < 0) std::exit(2);
  if (child == 0) {
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, kSeconds);
    limit(RLIMIT_AS, address_space_in_use() + kConstantBytes + kBytesPerByte * file_bytes);
    const Told told = work();
    const bool sent = write(ends[1], &told, sizeof told) == ssize_t(sizeof told);
    _exit(sent ? 0 : 1);
  }
  close(ends[1]);
  outcome.crashed = read(ends[0], &outcome.told, sizeof outcome.told) != ssize_t(sizeof outcome.told);
  close(ends[0]);
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  outcome.crashed = outcome.crashed || status != 0;
  outcome.peak_kib = std::uint64_t(usage.ru_maxrss);
  return outcome;
}

struct Row {
  std::string format, attack, message;
  std::size_t files = 0, errors_strict = 0, imported_lenient = 0, crashed = 0, broken = 0, leaked = 0;
  std::uint64_t peak_kib = 0;
  double slowest_ms = 0.0;
  bool passed() const { return crashed == 0 && broken == 0 && leaked == 0; }
};

/// Keeps a file that a reader failed on.
void keep(const Target& target, const Attack& attack, std::size_t number, const fs::path& model, const char* what) {
  const fs::path kept = fs::temp_directory_path() / fmt::format("hostile-{}-{}", target.name(), number);
  std::error_code ignored;
  fs::copy_file(model, kept, fs::copy_options::overwrite_existing, ignored);
  std::fprintf(stderr, "%s, %s, file %zu kept as %s: %s\n", target.name().c_str(), attack.name.c_str(), number,
               kept.c_str(), what);
}

Row run(const Target& target, const Attack& attack, std::size_t mutations, Folder& folder) {
  Row row;
  row.format = target.name();
  row.attack = attack.name;
  std::ranges::replace(row.attack, '_', ' ');
  const std::uint64_t baseline_kib = in_child(0, [] { return Told(); }).peak_kib;
  const std::size_t cases = attack.cases == kAnyNumber ? mutations : attack.cases;
  const std::size_t step = tests::long_run() ? 1 : 1 + (cases - 1) / std::max(mutations, kShortRun);
  for (std::size_t k = 0; k < cases; k += step) {
    Case made = attack.make(k);
    std::size_t bytes = 0;
    for (const File& file : made.files) bytes += file.content.size();
    const fs::path model = folder.write(made);
    for (File& file : made.files) file.content = {};  // it does not count as memory of the import
    const Outcome outcome = in_child(bytes, [&] { return import_both_ways(target, made, model); });
    const Told& told = outcome.told;
    ++row.files;
    row.errors_strict += !outcome.crashed && !told.imported_strict;
    row.imported_lenient += told.imported_lenient;
    row.crashed += outcome.crashed;
    row.broken += told.broken;
    row.leaked += told.leaked;
    row.peak_kib = std::max(row.peak_kib, outcome.peak_kib - std::min(baseline_kib, outcome.peak_kib));
    row.slowest_ms = std::max(row.slowest_ms, told.slowest_ms);
    if (told.message[0] != 0 && (row.message.empty() || told.broken)) row.message = folder.shortened(told.message);
    if (outcome.crashed || told.broken)
      keep(target, attack, k, model, outcome.crashed ? "crashed or ran too long" : told.message);
  }
  return row;
}

/// Loads what a format needs once and for all: imports that follow are not charged with it.
void warm_up(const Target& target, Folder& folder) {
  for (const std::string& seed : seeds_of(target)) {
    const Case made = one_file(target.model(), seed);
    import_both_ways(target, made, folder.write(made));
  }
}

// --- output ----------------------------------------------------------------------------------------------------------

void print_header() {
  std::printf(
      "| format | attack | files | errors (strict) | imported (lenient) | crashed | beyond memory or unsound | read "
      "outside | peak MiB | slowest ms | for example |\n"
      "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- |\n");
}

void print_markdown(const Row& r) {
  std::string message;
  for (const char c : r.message) message += c == '|' ? '/' : c >= ' ' && c < 127 ? c : '?';
  std::printf("| %s | %s | %zu | %zu | %zu | %zu | %zu | %zu | %.1f | %.1f | %s |\n", r.format.c_str(),
              r.attack.c_str(), r.files, r.errors_strict, r.imported_lenient, r.crashed, r.broken, r.leaked,
              double(r.peak_kib) / 1024.0, r.slowest_ms, message.c_str());
  std::fflush(stdout);
}

json::Value to_json(const Row& r) {
  return {{"format", r.format},
          {"attack", r.attack},
          {"files", r.files},
          {"errors_strict", r.errors_strict},
          {"imported_lenient", r.imported_lenient},
          {"crashed", r.crashed},
          {"broken", r.broken},
          {"read_outside", r.leaked},
          {"peak_kib", r.peak_kib},
          {"slowest_ms", r.slowest_ms},
          {"message", r.message}};
}

int run_table(std::size_t mutations, bool json) {
  bool passed = true;
  auto rows = json::Value::array();
  Folder folder;
  if (!json) print_header();
  for (const Target& target : targets()) {
    warm_up(target, folder);
    for (const Attack& attack : attacks_on(target)) {
      if (attack.name == "most_memory" && !tests::long_run()) continue;
      const Row row = run(target, attack, mutations, folder);
      passed = passed && row.passed();
      if (json)
        rows.push_back(to_json(row));
      else
        print_markdown(row);
    }
  }
  if (json) std::puts(rows.dump(1).c_str());
  return passed ? 0 : 1;
}

}  // namespace
}  // namespace sightline::hostile

int main(int argc, char** argv) {
  std::size_t mutations = std::size_t(sightline::tests::repeated(500, 25));
  bool json = false;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0) {
      json = true;
    } else if (std::strcmp(argv[i], "--mutations") == 0 && i + 1 < argc) {
      mutations = std::max(1ull, std::strtoull(argv[++i], nullptr, 10));
    } else {
      std::fprintf(stderr, "usage: hostile_table [--mutations N] [--json]\n");
      return 2;
    }
  }
  try {
    return sightline::hostile::run_table(mutations, json);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hostile_table: %s\n", error.what());
    return 1;
  }
}
