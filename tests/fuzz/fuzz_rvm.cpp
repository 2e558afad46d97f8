// RVM files, binary and text; what was read is written and read again, and must be the same.
#include <algorithm>

#include "sightline/importers/rvm/internal/rvm_reader.h"
#include "sightline/importers/rvm/internal/rvm_text.h"
#include "sightline/importers/rvm/rvm_writer.h"
#include "sightline/tests/fuzz/fuzz_target.h"
#include "sightline/tests/importers/scene_compare.h"

namespace {

using namespace sightline;

/// Only copies that are equal to the bit are shared then, as the writer's promise has it.
core::Expected<importers::ImportReport> read_rvm(std::span<const std::byte> bytes, core::Scene& scene) {
  return importers::read_rvm(bytes, "exact.rvm", scene, scene.root(), {.copies = importers::MeshCopies::kExact});
}

/// What was read without warnings is the same after writing and reading.
void check_writing(std::span<const std::byte> bytes) {
  core::Scene scene, again;
  const auto report = read_rvm(bytes, scene);
  if (!report || !report->warnings.empty()) return;
  const auto written = importers::write_rvm(scene, report->nodes[0]);
  fuzz::require(written.has_value(), written ? "" : written.error().message);
  const auto read = read_rvm(*written, again);
  fuzz::require(read.has_value(), read ? "" : read.error().message);
  fuzz::require(read->warnings.empty(), "no warnings about what was written");
  const std::string difference = tests::scene_difference(scene, report->nodes[0], again, read->nodes[0]);
  fuzz::require(difference.empty(), "the same after writing and reading: " + difference);
}

bool says_nothing_but_empty(const importers::ImportReport& report) {
  return std::all_of(report.warnings.begin(), report.warnings.end(), [](const importers::ImportWarning& warning) {
    return warning.message.starts_with("nothing to draw");
  });
}

/// Any scene is written as a file that is read strictly and without warnings, and then stays the same.
void write_and_check(const core::Scene& scene, const importers::ImportReport& report) {
  const auto written = importers::write_rvm(scene, report.nodes[0]);
  fuzz::require(written.has_value(), written ? "" : written.error().message);
  core::Scene again;
  const auto read = read_rvm(*written, again);
  fuzz::require(read.has_value() && says_nothing_but_empty(*read), "a sound file from what was read");
  check_writing(*written);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto read = [](std::span<const std::byte> bytes, const std::filesystem::path& path, core::Scene& scene,
                       core::NodeId parent, const importers::ImportOptions& options) {
    return importers::read_rvm(bytes, path.string(), scene, parent, options);
  };
  const bool text = importers::is_rvm_text(fuzz::bytes_of(data, size));
  fuzz::check_reader(
      read, "fuzz.rvm", fuzz::bytes_of(data, size),
      {text ? importers::kRvmTextMemoryFactor : importers::kRvmMemoryFactor, importers::kRvmMemoryConstant},
      write_and_check);
  check_writing(fuzz::bytes_of(data, size));
  return 0;
}
