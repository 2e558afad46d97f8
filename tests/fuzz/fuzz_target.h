// What the fuzz targets share. A target reads one input the way an application would and checks what users rely on;
// whatever does not hold ends the process, which the fuzzer (libFuzzer) reports with the input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "sightline/core/scene.h"
#include "sightline/importers/import.h"

namespace sightline::fuzz {

/// Ends the process, naming what was expected.
void require(bool holds, std::string_view expected);

inline std::span<const std::byte> bytes_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const std::byte*>(data), size};
}
inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

using Reader = core::Expected<importers::ImportReport> (*)(std::span<const std::byte>, const std::filesystem::path&,
                                                           core::Scene&, core::NodeId, const importers::ImportOptions&);

/// Memory that a reader may take for an input: `factor` times its bytes and `constant` more.
struct MemoryBound {
  std::size_t factor = 0, constant = 0;
};

/// Between a model and the side files that it names, all in one input: model, separator, side file, separator, …
inline constexpr std::string_view kSideFileSeparator = "\n--side-file--\n";

/// Reads an input strict, lenient and cancelled half-way, into a scene that already holds something. Requires: memory
/// within the bound; after a failure the scene as it was, and an error that names the file; after success counts that
/// agree with the report, texts in UTF-8, a scene that can be committed and shown in a snapshot, meshes whose indices
/// exist, and that what is read strictly is read the same leniently, perhaps with more to say of what is secondary. The
/// k-th name of a side file asked for stands for the k-th in the input: no input reaches the disk.
void check_reader(Reader read, std::string_view file, std::span<const std::byte> input, const MemoryBound& bound);

/// Checks a reader; `also` sees each scene that was read.
void check_reader(Reader read, std::string_view file, std::span<const std::byte> input, const MemoryBound& bound,
                  void (*also)(const core::Scene&, const importers::ImportReport&));

}  // namespace sightline::fuzz
