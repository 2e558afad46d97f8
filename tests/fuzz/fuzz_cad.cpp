// STEP, IGES and BREP files, in this process. Open CASCADE is not instrumented and fails in ways of its own, which end
// the reader's process in applications; here a crash of its code is to be told from one of ours by its stack. Without
// bounds on memory: what it takes says nothing of ours.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

#include "sightline/importers/cad/internal/cad_reader.h"
#include "sightline/tests/fuzz/fuzz_target.h"

namespace {

const char* name_of(std::string_view text) {
  if (text.substr(0, 200).find("CASCADE Topology V") != text.npos) return "fuzz.brep";
  if (text.starts_with("\x1f\x8b") || text.starts_with("PK")) return "fuzz.stpz";
  return text.starts_with("ISO-10303-21") ? "fuzz.stp" : "fuzz.igs";
}

/// Open CASCADE opens files by their names, so that each input is written into memory that has one.
sightline::core::Expected<sightline::importers::ImportReport> read(std::span<const std::byte> bytes,
                                                                   const std::filesystem::path& name,
                                                                   sightline::core::Scene& scene,
                                                                   sightline::core::NodeId parent,
                                                                   const sightline::importers::ImportOptions& options) {
  static const std::filesystem::path folder = [] {
    auto made = std::filesystem::path("/dev/shm") / ("sightline_fuzz_cad_" + std::to_string(getpid()));
    std::filesystem::create_directories(made);
    return made;
  }();
  const auto file = folder / name;
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  return sightline::importers::read_cad(file, scene, parent, options);
}

}  // namespace

/// What Open CASCADE keeps in static objects, and forgets.
extern "C" const char* __lsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "leak:libTK";
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  constexpr std::size_t kAny = std::size_t{1} << 40;
  const std::string_view text = fuzz::text_of(data, size);
  fuzz::check_reader(read, name_of(text), fuzz::bytes_of(data, size), {0, kAny});
  return 0;
}
