// Whole files in and out of memory, with errors for people.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "sightline/core/error.h"

namespace sightline::importers {

/// The file's contents. Fails when it cannot be opened or read, or is empty.
core::Expected<std::vector<std::byte>> read_file_bytes(const std::filesystem::path& path);

/// Where a writer's bytes go.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  virtual bool write(std::span<const std::byte> bytes) = 0;  ///< false: could not (disk full, say)
};

class VectorSink final : public ByteSink {
 public:
  bool write(std::span<const std::byte> added) override {
    bytes.insert(bytes.end(), added.begin(), added.end());
    return true;
  }
  std::vector<std::byte> bytes;
};

/// Writes beside the target and renames at the end: readers see the old file or the whole new one.
class ReplacingFileSink final : public ByteSink {
 public:
  explicit ReplacingFileSink(std::filesystem::path target);
  ~ReplacingFileSink() override;  ///< throws away what was not finished
  ReplacingFileSink(const ReplacingFileSink&) = delete;
  ReplacingFileSink& operator=(const ReplacingFileSink&) = delete;

  core::Expected<void> open();
  bool write(std::span<const std::byte> bytes) override;
  core::Expected<void> finish();

 private:
  std::filesystem::path target_, temporary_;
  void* file_ = nullptr;
};

}  // namespace sightline::importers
