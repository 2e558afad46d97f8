// hostile_table: damaged and malicious files against every reader of this build, each import in a process of its own
// with little address space, so that a crash or too much memory is a result and not the end.
//
//   hostile_table [--mutations N] [--json]      Markdown, or JSON, on stdout
//
// Exits 1 when an import crashed, took more memory than its bound, ran too long, or read what lies outside the model's
// directory. docs/hostile-files.md holds a table.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sightline/core/snapshot.h"
#include "sightline/importers/import.h"
#include "sightline/importers/view_json.h"
#include "sightline/tests/hostile/attack.h"
#include "sightline/tests/support/places.h"

namespace sightline::hostile {

std::string repeated(const std::string& text, std::size_t times) {
  std::string all;
  all.reserve(text.size() * times);
  for (std::size_t i = 0; i < times; ++i) all += text;
  return all;
}

namespace {

namespace fs = std::filesystem;

/// Address space beyond what the process has already: the largest factor that a reader's header states, and what a
/// library needs however small the file is.
constexpr std::size_t kBytesPerByte = 1000, kConstantBytes = std::size_t{64} << 20;
constexpr rlim_t kSeconds = 20;

// --- in a child ----------------------------------------------------------------------------------------------------

/// What the child tells: plain bytes, for a pipe.
struct Told {
  bool imported_strict = false, imported_lenient = false, broken = false;
  std::uint64_t items = 0, materials = 0;
  double slowest_ms = 0.0;
  char message[200] = {};
};

void keep_message(Told& told, const std::string& message) {
  if (told.message[0] == 0) std::snprintf(told.message, sizeof told.message, "%s", message.c_str());
  told.broken = told.broken || message.find("not enough memory") != message.npos;
}

template <class Call>
auto timed(Told& told, const Call& call) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  auto result = call();
  const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  told.slowest_ms = std::max(told.slowest_ms, ms);
  return result;
}

/// The groups that attribute files speak of.
void add_groups(core::Scene& scene) {
  const core::NodeId site = scene.add_node(scene.add_node(scene.root(), "model.rvm"), "/SITE");
  for (const char* name : {"/A", "/B", "/A", ""}) scene.add_primitive(scene.add_node(site, name), core::Sphere{1.0f});
}

bool import_model(const Target& target, const fs::path& model, bool lenient, Told& told) {
  core::Scene scene;
  if (target.format == "rvm_attributes") add_groups(scene);
  const std::size_t nodes = scene.node_count(), items = scene.item_slots();
  const auto report =
      timed(told, [&] { return importers::import_file(model, scene, scene.root(), {.lenient = lenient}); });
  told.items = std::max<std::uint64_t>(told.items, scene.item_count());
  told.materials = std::max<std::uint64_t>(told.materials, scene.material_slots());
  if (!report) {
    keep_message(told, report.error().message);
    told.broken = told.broken || scene.node_count() != nodes || scene.item_slots() != items || scene.mesh_slots() != 0;
    return false;
  }
  if (!report->warnings.empty()) keep_message(told, report->warnings[0].message);
  told.broken = told.broken || !scene.commit() || core::Snapshot(scene).size() > scene.item_slots();
  return true;
}

template <class Read>
void read_json(const Read& read, Told& told) {
  const auto result = timed(told, read);
  if (!result) keep_message(told, result.error().message);
  told.imported_strict = told.imported_lenient = result.has_value();
}

Told import_all_ways(const Target& target, const fs::path& model) {
  Told told;
  if (target.format == "view_json") {
    read_json([&] { return importers::read_view(model, 1.5); }, told);
  } else if (target.format == "path_json") {
    read_json([&] { return importers::read_path(model); }, told);
  } else {
    told.imported_strict = import_model(target, model, false, told);
    told.imported_lenient = import_model(target, model, true, told);
  }
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

/// A folder for one case's files: FOLDER/models holds the model, FOLDER what lies outside.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / fmt::format("sightline_hostile_{}", getpid())) {}
  ~Folder() { clear(); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  /// Returns the model.
  fs::path write(const Case& made) {
    clear();
    fs::create_directories(path_ / "models");
    for (const File& file : made.files) {
      const fs::path path = path_ / "models" / file.name;
      if (!file.link_to.empty()) {
        fs::create_symlink(file.link_to, path);
        continue;
      }
      std::string content = file.content;
      if (const std::size_t at = content.find(kOutside); at != content.npos)
        content.replace(at, kOutside.size(), path_.string());
      std::ofstream(path, std::ios::binary) << content;
    }
    return path_ / "models" / made.files[0].name;
  }

  /// A message without where the folder lies.
  std::string shortened(std::string message) const {
    for (const std::string& prefix : {(path_ / "models/").string(), path_.string()})
      for (std::size_t at; (at = message.find(prefix)) != message.npos;) message.erase(at, prefix.size());
    return message;
  }

 private:
  void clear() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  fs::path path_;
};

struct Row {
  std::string format, attack, message;
  std::size_t files = 0, errors_strict = 0, imported_lenient = 0, crashed = 0, broken = 0, leaked = 0;
  std::uint64_t peak_kib = 0;
  double slowest_ms = 0.0;
  bool passed() const { return crashed == 0 && broken == 0 && leaked == 0; }
};

Row run(const Target& target, const Attack& attack, Folder& folder) {
  Row row;
  row.format = target.format == "gltf" || target.format == "vtk" ? target.extension.substr(1) : target.format;
  row.attack = attack.name;
  const std::uint64_t baseline_kib = in_child(0, [] { return Told(); }).peak_kib;
  for (std::size_t k = 0; k < attack.cases; ++k) {
    std::size_t bytes = 0, most_items = 0, most_materials = 0;
    fs::path model;
    {
      const Case made = attack.make(k);
      for (const File& file : made.files) bytes += file.content.size();
      most_items = made.most_items;
      most_materials = made.most_materials;
      model = folder.write(made);
    }
    const Outcome outcome = in_child(bytes, [&] { return import_all_ways(target, model); });
    const Told& told = outcome.told;
    ++row.files;
    row.errors_strict += !outcome.crashed && !told.imported_strict;
    row.imported_lenient += told.imported_lenient;
    row.crashed += outcome.crashed;
    row.broken += told.broken;
    row.leaked += told.items > most_items || told.materials > most_materials;
    row.peak_kib = std::max(row.peak_kib, outcome.peak_kib - std::min(baseline_kib, outcome.peak_kib));
    row.slowest_ms = std::max(row.slowest_ms, told.slowest_ms);
    if (told.message[0] != 0 && (row.message.empty() || told.broken)) row.message = folder.shortened(told.message);
    if (outcome.crashed || told.broken) {
      const fs::path kept = fs::temp_directory_path() / ("hostile-" + target.format + "-" + std::to_string(k));
      std::error_code ignored;
      fs::copy_file(model, kept, fs::copy_options::overwrite_existing, ignored);
      std::fprintf(stderr, "%s, %s, file %zu kept as %s: %s\n", target.format.c_str(), attack.name.c_str(), k,
                   kept.c_str(), outcome.crashed ? "crashed or ran too long" : told.message);
    }
  }
  return row;
}

// --- what every format gets ------------------------------------------------------------------------------------------

/// Models; the fuzz targets' side files, which have no names, are left out.
std::vector<std::string> seeds_of(const Target& target) {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(tests::in_checkout("tests/fuzz/corpus") / target.format))
    if (entry.path().extension() == target.extension) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<std::string> seeds;
  for (const fs::path& path : paths) {
    std::ifstream in(path, std::ios::binary);
    const std::string all((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    seeds.push_back(all.substr(0, all.find("\n--side-file--\n")));
  }
  return seeds;
}

/// Every length of the first 100 bytes of each seed, and beyond them steps such that there are about 100 more.
Attack truncation(const Target& target) {
  std::vector<std::pair<std::size_t, std::size_t>> cuts;  // seed, length
  const std::vector<std::string> seeds = seeds_of(target);
  for (std::size_t s = 0; s < seeds.size(); ++s) {
    const std::size_t size = seeds[s].size(), step = std::max<std::size_t>(size / 100, 1);
    for (std::size_t length = 0; length < size; length += length < 100 ? 1 : step) cuts.emplace_back(s, length);
  }
  return {"truncation", cuts.size(), [seeds, cuts, name = "model" + target.extension](std::size_t k) {
            return Case{{{name, seeds[cuts[k].first].substr(0, cuts[k].second)}}};
          }};
}

/// Bits turned, bytes replaced by extremes, pieces doubled or left out: one to eight times. The case is the random
/// seed.
Attack mutation(const Target& target, std::size_t count) {
  const auto make = [seeds = seeds_of(target), name = "model" + target.extension](std::size_t k) {
    std::mt19937 random(unsigned(k) + 1);
    std::string text = seeds[random() % seeds.size()];
    for (unsigned times = 1 + random() % 8; times > 0 && !text.empty(); --times) {
      const std::size_t at = random() % text.size(), length = random() % 16;
      switch (random() % 5) {
        case 0:
          text[at] = char(text[at] ^ (1 << random() % 8));
          break;
        case 1:
          text[at] = char(random());
          break;
        case 2:
          text.replace(at, 4, "\xff\xff\xff\x7f");
          break;
        case 3:
          text.insert(at, text.substr(random() % text.size(), length));
          break;
        default:
          text.erase(at, length);
          break;
      }
    }
    return Case{{{name, text}}};
  };
  return {fmt::format("mutation (seeds 1 to {})", count), count, make};
}

/// Loads what a format needs once and for all: imports that follow are not charged with it.
void warm_up(const Target& target, Folder& folder) {
  for (const std::string& seed : seeds_of(target))
    import_all_ways(target, folder.write({{{"model" + target.extension, seed}}}));
}

std::vector<Target> targets() {
  std::vector<Target> all = {{"rvm", ".rvm", rvm::attacks()}, {"rvm_attributes", ".txt", rvm::attribute_attacks()}};
  const auto known = importers::known_extensions();
  const auto add = [&](const char* format, const char* extension, std::vector<Attack> (*attacks)()) {
    if (std::find(known.begin(), known.end(), extension) != known.end()) all.push_back({format, extension, attacks()});
  };
  add("obj", ".obj", obj::attacks);
  add("gltf", ".gltf", gltf::attacks);
  add("gltf", ".glb", gltf::binary_attacks);
  add("ply", ".ply", polygon_file::ply_attacks);
  add("stl", ".stl", polygon_file::stl_attacks);
  add("vtk", ".vtk", vtk::legacy_attacks);
  add("vtk", ".vtp", vtk::polygon_attacks);
  add("vtk", ".vtu", [] { return std::vector<Attack>(); });
  add("vtk", ".vtm", vtk::block_attacks);
  all.push_back({"view_json", ".json", json::attacks()});
  all.push_back({"path_json", ".json", json::attacks()});
  return all;
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

nlohmann::ordered_json to_json(const Row& r) {
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
  auto rows = nlohmann::ordered_json::array();
  Folder folder;
  if (!json) print_header();
  for (Target& target : targets()) {
    std::vector<Attack> attacks = {truncation(target), mutation(target, mutations)};
    attacks.insert(attacks.end(), target.attacks.begin(), target.attacks.end());
    warm_up(target, folder);
    for (const Attack& attack : attacks) {
      const Row row = run(target, attack, folder);
      passed = passed && row.passed();
      if (json)
        rows.push_back(to_json(row));
      else
        print_markdown(row);
    }
  }
  using Json = nlohmann::ordered_json;
  if (json) std::puts(rows.dump(1, ' ', false, Json::error_handler_t::replace).c_str());
  return passed ? 0 : 1;
}

}  // namespace
}  // namespace sightline::hostile

int main(int argc, char** argv) {
  std::size_t mutations = 500;
  bool json = false;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0) {
      json = true;
    } else if (std::strcmp(argv[i], "--mutations") == 0 && i + 1 < argc) {
      mutations = std::strtoull(argv[++i], nullptr, 10);
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
