// The table of attacks on the readers: files that are damaged or made to harm. hostile_table imports them all in child
// processes, tests/importers/hostile_test.cpp imports them in its own process, where sanitizers look on.
//
// A new reader gets a file <format>_attacks.cpp with a function that returns its targets, which targets.cpp calls.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/importers/import.h"

namespace sightline::hostile {

/// Stands for the folder above the model's directory, in a file's content.
inline constexpr std::string_view kOutside = "@OUTSIDE@";

/// A file, or a link when `link_to` is not empty. The name is relative to the model's directory.
struct File {
  std::string name, content, link_to = {};
};

/// The outcome that an import must have.
enum class Expect { kEither, kFailure, kSuccess };

/// The input of an import. The first file is the model.
struct Case {
  std::vector<File> files;
  Expect strict = Expect::kEither, lenient = Expect::kEither;
  bool warns = false;  ///< a successful import must have warned
  /// Bounds of what a successful import brings. More than `most_…` means that something was read which lies outside
  /// the model's directory.
  std::size_t least_items = 0;
  std::size_t most_items = std::numeric_limits<std::size_t>::max();
  std::size_t most_materials = std::numeric_limits<std::size_t>::max();
};

/// A case of one file.
Case one_file(std::string name, std::string content);
/// The case, with the outcomes that it must have.
Case refused(Case made);  ///< an error, strict and lenient
Case damaged(Case made);  ///< an error when strict, a success when lenient
Case sound(Case made);    ///< a success, strict and lenient

/// The number of cases of an attack with random cases: a case's number is its random seed.
inline constexpr std::size_t kAnyNumber = 0;

struct Attack {
  std::string name;
  std::size_t cases = kAnyNumber;
  std::function<Case(std::size_t)> make;  ///< called with 0 … cases - 1
};

using Reader = core::Expected<importers::ImportReport> (*)(std::span<const std::byte>, const std::filesystem::path&,
                                                           core::Scene&, core::NodeId, const importers::ImportOptions&);

/// Lengths of a seed that a strict and a lenient import need: anything shorter is an error, anything longer is as good
/// as the whole seed. 0: unknown.
struct Needs {
  std::size_t strict = 0, lenient = 0;
};

/// A format under attack: files with this extension, seeds in tests/fuzz/corpus/FORMAT.
struct Target {
  std::string format, extension;
  Reader read = nullptr;  ///< reads a file's bytes
  /// Peak memory of an import in bytes per byte of its files and beyond that, as the reader's header states them.
  std::size_t memory_factor = 0, memory_constant = 0;
  int mutations = 0;                                  ///< cases of each random attack in a long run of importers_tests
  std::vector<Attack> attacks = {};                   ///< those of this format alone
  Expect noise = Expect::kFailure;                    ///< outcome of random bytes
  Needs (*needs)(std::string_view seed) = nullptr;    ///< null: a truncated seed may be whole
  std::string (*seal)(std::string bytes) = nullptr;   ///< makes checksums right again
  void (*prepare)(core::Scene& scene) = nullptr;      ///< adds what the file refers to
  void (*use)(std::span<const std::byte>) = nullptr;  ///< other ways to read the bytes, which must not crash

  /// The name in tables and tests: the format, or the extension where a format has several.
  std::string name() const;
  std::string model() const { return "model" + extension; }
};

/// All targets that this build can read.
std::vector<Target> targets();
/// The target of a name, which must exist.
Target target_of(std::string_view name);

// --- attacks on every format -----------------------------------------------------------------------------------------

/// The attacks on every format, and those of this format alone.
std::vector<Attack> attacks_on(const Target& target);

/// Models of the fuzz targets, without their side files, which have no names.
const std::vector<std::string>& seeds_of(const Target& target);

/// The first bytes of a seed, and the outcomes that the target's needs state.
Case truncated(const Target& target, const std::string& seed, std::size_t length);
/// Every length of the first 100 bytes of each seed, and beyond them steps such that there are about 100 more.
Attack truncation(const Target& target);
/// One to eight random changes of a seed, which is one of the target's where there are none.
Attack mutation(const Target& target, std::vector<std::string> seeds = {});
/// Random bytes, by themselves and after the begin of a seed.
Attack noise(const Target& target);

/// Names of a side file outside the model's directory, which is there and holds `secret`. `names(path)`: a model that
/// names the path, with bounds that tell when the file was read.
Attack path_traversal(const std::string& extension, const std::string& secret,
                      std::function<Case(const std::string&)> names);

/// The text after one to eight random changes.
std::string mutated(std::string text, std::mt19937& random);

// --- parts of files --------------------------------------------------------------------------------------------------

/// Text over and over, with a separator between.
std::string repeated(const std::string& text, std::size_t times, const std::string& separator = "");
/// Four bytes of a little-endian number.
std::string little_endian(std::uint32_t value);
std::string text_of(std::span<const std::byte> bytes);

// --- targets by format -----------------------------------------------------------------------------------------------

std::vector<Target> gltf_targets();
std::vector<Target> json_targets();
std::vector<Target> obj_targets();
std::vector<Target> ply_targets();
std::vector<Target> rvm_targets();
std::vector<Target> slc_targets();
std::vector<Target> stl_targets();
std::vector<Target> vtk_targets();

}  // namespace sightline::hostile
