// Changed scene caches that look whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "sightline/importers/slc/internal/slc_file.h"
#include "sightline/importers/slc/internal/storage.h"

namespace sightline::tests {

/// Makes the checksums of header, table and end right again, so that a change gets past them.
inline void reseal(std::span<std::byte> bytes) {
  constexpr std::size_t kEnd = 64, kSum = 56;
  if (bytes.size() < 2 * kEnd) return;
  const auto put = [](std::span<std::byte> at, std::uint64_t value) { std::memcpy(at.data(), &value, sizeof value); };
  const auto get = [](std::span<std::byte> at) {
    std::uint64_t value = 0;
    std::memcpy(&value, at.data(), sizeof value);
    return value;
  };
  put(bytes.subspan(kSum), importers::slc_checksum(bytes.first(kSum)));
  const auto end = bytes.last(kEnd);
  const std::uint64_t offset = get(end), size = get(end.subspan(8));
  if (offset <= bytes.size() && size <= bytes.size() - offset)
    put(end.subspan(16), importers::slc_checksum(bytes.subspan(std::size_t(offset), std::size_t(size))));
  put(end.subspan(24), bytes.size());
  put(end.subspan(kSum), importers::slc_checksum(end.first(kSum)));
}

/// Gives the header the version, byte order and layout of this build.
inline void make_current(std::span<std::byte> bytes) {
  if (bytes.size() < 64) return;
  const std::uint32_t words[] = {importers::kSlcVersion, 0x01020304};
  const std::uint64_t layout = importers::storage::layout();
  std::memcpy(bytes.data() + 8, words, sizeof words);
  std::memcpy(bytes.data() + 16, &layout, sizeof layout);
}

}  // namespace sightline::tests
