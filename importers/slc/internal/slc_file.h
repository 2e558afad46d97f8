// The container of a scene cache: numbered arrays with checksums (docs/reference/scene-cache-format.md). Internal to
// the importers.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "sightline/core/internal/atomic_file.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/core/large_array.h"

namespace sightline::importers {

inline constexpr std::uint32_t kSlcVersion = 2;

/// Numbers of arrays beside those of importers/slc/internal/storage.h.
enum SlcArray : std::uint64_t {
  kSlcReport = 50,
  kSlcSources,
  kSlcSnapshotState,
  kSlcChunkOrigins,
  kSlcMaterials,
  kSlcMaterialNames,
  kSlcMeshes,
  kSlcMeshNames,
  kSlcMeshValues,
  kSlcAttributeNodes,
  kSlcAttributeEnds,
  kSlcAttributeText,
  kSlcJointBits,
  kSlcJointCovers,
  kSlcJointFirst,
  kSlcJointOpaque,
  kSlcLeafBoxes,
  kSlcLeafColours,
  kSlcSlotEnds,
  kSlcPages,
  kSlcLevelsVersion,
  kSlcLevels,
  kSlcLevelValues,
  kSlcCoarseMeshes,
  kSlcCoarseValues,
  kSlcCoarsePages,
  kSlcSurfaceEnds,
  kSlcSurfaces,
};

/// Why a cache cannot be used.
struct SlcProblem {
  enum class Kind { kMissing, kOtherVersion, kDamaged } kind = Kind::kDamaged;
  std::string message;  ///< without the file's name
};
template <class T>
using SlcExpected = tl::expected<T, SlcProblem>;

inline tl::unexpected<SlcProblem> damaged(std::string message) {
  return tl::unexpected<SlcProblem>(SlcProblem{SlcProblem::Kind::kDamaged, std::move(message)});
}

std::uint64_t slc_checksum(std::span<const std::byte> bytes);
/// The checksum of a whole file; 0 when it cannot be read.
std::uint64_t slc_checksum(const std::filesystem::path& file);

/// Appends a container to a file, array by array.
class SlcWriter {
 public:
  explicit SlcWriter(core::AtomicFile& file);
  void begin(std::uint64_t number, std::size_t element_size);
  void append(std::span<const std::byte> bytes);  ///< of the array begun
  void end();
  template <class Array>
  void add(std::uint64_t number, const Array& values) {
    begin(number, sizeof(values.data()[0]));
    append(std::as_bytes(std::span(values.data(), values.size())));
    end();
  }
  void finish();  ///< writes what opening a container begins with

 private:
  struct State;
  struct Delete {
    void operator()(State* state) const;
  };
  void write(std::span<const std::byte> bytes);
  void pad();
  std::unique_ptr<State, Delete> state_;
};

/// A container that was opened: its table is sound, its arrays are not yet verified. Its file must not be changed in
/// place while it is open. To replace it by renaming, as the writer does, is safe.
class SlcFile {
 public:
  static SlcExpected<std::shared_ptr<const SlcFile>> open(const std::filesystem::path& path);
  /// From memory, which is copied.
  static SlcExpected<std::shared_ptr<const SlcFile>> of_bytes(std::span<const std::byte> bytes);
  SlcFile(const SlcFile&) = delete;
  SlcFile& operator=(const SlcFile&) = delete;

  struct Section {
    std::uint64_t number, element_size, count, offset, first_block, blocks;
  };
  std::size_t size() const { return size_; }
  std::span<const Section> sections() const { return sections_; }
  const Section* find(std::uint64_t number) const;

  /// The content in memory that may be written to; nobody else sees that.
  struct Mapping {
    std::shared_ptr<const void> keeper;
    std::byte* data = nullptr;
  };
  SlcExpected<Mapping> map() const;
  /// A mapping to read from alone: limits on memory do not count it.
  SlcExpected<Mapping> map_to_read() const;
  /// The array lies in the mapping. False when its elements have another size. An absent one becomes empty.
  template <class T>
  bool adopt(const Mapping& mapping, std::uint64_t number, core::LargeArray<T>& array) const {
    const Section* section = find(number);
    if (section && section->element_size != sizeof(T)) return false;
    if (!section || section->count == 0)
      array = {};
    else
      array = core::LargeArray<T>::kept(mapping.keeper, reinterpret_cast<T*>(mapping.data + section->offset),
                                        std::size_t(section->count));
    return true;
  }

  /// Copies bytes of the file, without a mapping: they count as memory of whom they are copied to, and of nobody else.
  /// `offset` and their number must lie in a section.
  SlcExpected<void> read(std::uint64_t offset, std::span<std::byte> to) const;

  /// Gives the memory of an array back to the system until somebody reads it. Nobody may have written to it.
  void set_aside(const Mapping& mapping, std::uint64_t number) const;

  /// Compares checksums of the sections, in the mapping where they will be used, with all processors.
  struct Verified {
    const Section* section;
    const Mapping* mapping;
  };
  SlcExpected<void> verify(std::span<const Verified> what) const;

 private:
  SlcFile() = default;
  using Access = core::platform::ReadableFile::Access;
  SlcExpected<Mapping> mapped(Access access) const;
  SlcExpected<void> read_table(const std::byte* data);
  core::platform::ReadableFile file_;
  std::vector<std::byte> memory_;  // where there is no file
  std::size_t size_ = 0;
  std::vector<Section> sections_;
  std::vector<std::uint64_t> checksums_;
};

}  // namespace sightline::importers
