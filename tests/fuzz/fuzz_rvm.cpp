// RVM files; what was read is written and read again, and must be the same.
#include "sightline/importers/rvm/rvm_reader.h"
#include "sightline/importers/rvm/rvm_writer.h"
#include "sightline/tests/fuzz/fuzz_target.h"
#include "sightline/tests/importers/scene_compare.h"

namespace {

using namespace sightline;

/// Of a file that was read with warnings, what was written is what must stay the same.
void write_and_read_again(const core::Scene& scene, const importers::ImportReport& report) {
  const auto written = importers::write_rvm(scene, report.nodes[0]);
  fuzz::require(written.has_value(), written ? "" : written.error().message);
  core::Scene again;
  const auto read = importers::read_rvm(*written, "again.rvm", again, again.root());
  fuzz::require(read.has_value(), read ? "" : read.error().message);
  fuzz::require(read->warnings.empty(), "no warnings about what was written");
  if (!report.warnings.empty()) return write_and_read_again(again, *read);
  const std::string difference = tests::scene_difference(scene, report.nodes[0], again, read->nodes[0]);
  fuzz::require(difference.empty(), "the same after writing and reading: " + difference);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto read = [](std::span<const std::byte> bytes, const std::filesystem::path& path, core::Scene& scene,
                       core::NodeId parent, const importers::ImportOptions& options) {
    return importers::read_rvm(bytes, path.string(), scene, parent, options);
  };
  fuzz::check_reader(read, "fuzz.rvm", fuzz::bytes_of(data, size),
                     {importers::kRvmMemoryFactor, importers::kRvmMemoryConstant}, write_and_read_again);
  return 0;
}
