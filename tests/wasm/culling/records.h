// A file of texts and arrays in turn, for programs in two languages (records.js reads it). Each begins with the type of
// its elements and their number, 4 bytes each, and is filled up to a multiple of 8 bytes. Little endian.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sightline::tests {

enum class RecordType : std::uint32_t { kByte, kWord, kFloat, kDouble };

template <class T>
constexpr RecordType kRecordType = sizeof(T) == 1                     ? RecordType::kByte
                                   : std::is_same_v<T, std::uint32_t> ? RecordType::kWord
                                   : std::is_same_v<T, float>         ? RecordType::kFloat
                                                                      : RecordType::kDouble;

class RecordWriter {
 public:
  explicit RecordWriter(const std::filesystem::path& path) : path_(path), out_(path, std::ios::binary) {}
  const std::filesystem::path& path() const { return path_; }

  template <class T>
  void array(std::span<const T> values) {
    const std::uint32_t head[] = {std::uint32_t(kRecordType<T>), std::uint32_t(values.size())};
    const char zeros[8] = {};
    out_.write(reinterpret_cast<const char*>(head), sizeof head);
    out_.write(reinterpret_cast<const char*>(values.data()), std::streamsize(values.size_bytes()));
    out_.write(zeros, std::streamsize((8 - values.size_bytes() % 8) % 8));
  }
  template <class T>
  void array(const std::vector<T>& values) {
    array(std::span<const T>(values));
  }
  void text(std::string_view text) { array(std::span<const char>(text)); }
  void numbers(std::initializer_list<double> values) { array(std::span<const double>(values.begin(), values.size())); }
  /// Whether all of it has reached the file.
  bool close() {
    out_.close();
    return !out_.fail();
  }

 private:
  std::filesystem::path path_;
  std::ofstream out_;
};

class RecordReader {
 public:
  explicit RecordReader(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(in), {});
  }
  bool more() const { return at_ + 8 <= bytes_.size(); }

  /// The next array, which must be of this type; empty otherwise.
  template <class T>
  std::vector<T> array() {
    std::vector<T> values;
    if (!more()) return values;
    std::uint32_t head[2];
    std::memcpy(head, bytes_.data() + at_, sizeof head);
    const std::size_t size = head[1] * sizeof(T), padded = (size + 7) / 8 * 8;
    if (head[0] != std::uint32_t(kRecordType<T>) || padded > bytes_.size() - at_ - 8) return values;
    values.resize(head[1]);
    if (size > 0) std::memcpy(values.data(), bytes_.data() + at_ + 8, size);
    at_ += 8 + padded;
    return values;
  }
  std::string text() {
    const std::vector<char> letters = array<char>();
    return {letters.begin(), letters.end()};
  }

 private:
  std::vector<char> bytes_;
  std::size_t at_ = 0;
};

}  // namespace sightline::tests
