// Whole files in and out of memory, with readable errors.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/core/internal/atomic_file.h"

namespace sightline::importers {

/// The file's contents. Fails when it cannot be opened or read, or is empty.
core::Expected<std::vector<std::byte>> read_file_bytes(const std::filesystem::path& path);

/// Destination of a writer's bytes.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  virtual bool write(std::span<const std::byte> bytes) = 0;  ///< false on failure (disk full, for example)
};

class VectorSink final : public ByteSink {
 public:
  bool write(std::span<const std::byte> added) override {
    bytes.insert(bytes.end(), added.begin(), added.end());
    return true;
  }
  std::vector<std::byte> bytes;
};

class FileSink final : public ByteSink {
 public:
  explicit FileSink(core::AtomicFile& file) : file_(file) {}
  bool write(std::span<const std::byte> bytes) override { return file_.write(bytes); }

 private:
  core::AtomicFile& file_;
};

}  // namespace sightline::importers
