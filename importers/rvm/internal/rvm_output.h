// Writes RVM chunks: each is built in one buffer and flushed with its header.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/importers/internal/file_bytes.h"
#include "sightline/importers/rvm/internal/rvm_chunks.h"

namespace sightline::importers::rvm {

class ChunkWriter {
 public:
  explicit ChunkWriter(ByteSink& sink) : sink_(sink) {}

  void begin(std::string_view tag) {
    buffer_.clear();
    for (const char c : tag) u32(std::uint8_t(c));
    u32(0);  // next chunk, known at end()
    u32(1);
  }
  void u32(std::uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) buffer_.push_back(std::byte(std::uint8_t(value >> shift)));
  }
  void f32(float value) { u32(std::bit_cast<std::uint32_t>(value)); }
  void string(std::string_view text) {
    const std::size_t words = (text.size() + 3) / 4;
    u32(std::uint32_t(words));
    const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
    buffer_.resize(buffer_.size() + words * 4 - text.size());
  }
  void end() {
    const std::uint64_t next = offset_ + buffer_.size();
    if (next > 0xffffffffu) too_large_ = true;
    for (std::size_t i = 0; i < 4; ++i) buffer_[16 + i] = std::byte(std::uint8_t(next >> (24 - 8 * i)));
    flush();
  }
  /// Pads with zeros to a whole number of blocks.
  void pad() {
    buffer_.assign((kFileAlignment - offset_ % kFileAlignment) % kFileAlignment, std::byte{0});
    flush();
  }

  bool too_large() const { return too_large_; }
  bool ok() const { return written_ && !too_large_; }

 private:
  void flush() {
    if (ok()) written_ = sink_.write(buffer_);
    offset_ += buffer_.size();
  }

  ByteSink& sink_;
  std::vector<std::byte> buffer_;
  std::uint64_t offset_ = 0;
  bool written_ = true, too_large_ = false;
};

}  // namespace sightline::importers::rvm
