// Builds RVM files byte by byte, independently of the writer under test.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace sightline::tests {

class RvmBytes {
 public:
  RvmBytes& u32(std::uint32_t v) {
    for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(std::byte(v >> shift & 0xff));
    return *this;
  }
  RvmBytes& f32(float v) { return u32(std::bit_cast<std::uint32_t>(v)); }
  RvmBytes& floats(std::initializer_list<float> values) {
    for (const float v : values) f32(v);
    return *this;
  }
  RvmBytes& text(std::string_view s) {
    const std::size_t words = s.size() / 4 + 1;  // like the files of the wild: always a NUL
    u32(std::uint32_t(words));
    for (std::size_t i = 0; i < words * 4; ++i) bytes.push_back(i < s.size() ? std::byte(s[i]) : std::byte{0});
    return *this;
  }
  RvmBytes& begin(std::string_view tag) {
    start_ = bytes.size();
    for (const char c : tag) u32(std::uint8_t(c));
    return u32(0).u32(1);
  }
  RvmBytes& end() { return put(start_ + 16, std::uint32_t(bytes.size())); }
  RvmBytes& put(std::size_t at, std::uint32_t v) {
    for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = std::byte(v >> (24 - 8 * i) & 0xff);
    return *this;
  }

  RvmBytes& head() {
    begin("HEAD").u32(2).text("info").text("note").text("date").text("user").text("Unicode").end();
    return begin("MODL").u32(1).text("project").text("name").end();
  }
  RvmBytes& group(std::string_view name, std::uint32_t colour, std::initializer_list<float> position = {0, 0, 0}) {
    return begin("CNTB").u32(2).text(name).floats(position).u32(colour).end();
  }
  RvmBytes& group_end() { return begin("CNTE").u32(2).end(); }
  RvmBytes& colour(std::uint32_t index, std::uint32_t rgb) {
    return begin("COLR").u32(1).u32(index).u32(rgb << 8).end();
  }
  RvmBytes& matrix() { return floats({.001f, 0, 0, 0, .001f, 0, 0, 0, .001f, 1, 2, 3}); }
  /// PRIM up to its parameters.
  RvmBytes& item(std::uint32_t kind, std::initializer_list<float> box = {-1, -1, -1, 1, 1, 1}) {
    return begin("PRIM").u32(1).u32(kind).matrix().floats(box);
  }
  RvmBytes& prim(std::uint32_t kind, std::initializer_list<float> parameters) {
    return item(kind).floats(parameters).end();
  }
  /// A unit square with a square hole, and a triangle.
  RvmBytes& facets() {
    item(11).u32(2).u32(2);
    u32(4);
    for (const auto& [x, y] : {std::pair{0.f, 0.f}, {4.f, 0.f}, {4.f, 4.f}, {0.f, 4.f}}) floats({x, y, 0, 0, 0, 1});
    u32(4);
    for (const auto& [x, y] : {std::pair{1.f, 1.f}, {1.f, 2.f}, {2.f, 2.f}, {2.f, 1.f}}) floats({x, y, 0, 0, 0, 1});
    u32(1).u32(3);
    for (const auto& [x, y] : {std::pair{0.f, 0.f}, {1.f, 0.f}, {0.f, 1.f}}) floats({x, y, 5, 0, 0, 1});
    return end();
  }
  RvmBytes& finish() {
    begin("END:").u32(1).end();
    while (bytes.size() % 1760) bytes.push_back(std::byte{0});
    return *this;
  }
  /// One of each kind in `layers` of groups.
  RvmBytes& all_kinds() {
    prim(1, {10, 20, 5, 6, 1, 2, 30}).prim(2, {1, 2, 3}).prim(3, {4, 6, 2, 1.5f}).prim(4, {10, 2, 3});
    prim(5, {3, 1}).prim(6, {3, 1}).prim(7, {3, 2, 5, 1, 0, .1f, .2f, 0, 0}).prim(8, {2, 9}).prim(9, {7});
    return prim(10, {-3, 4}).facets();
  }

  std::vector<std::byte> bytes;

 private:
  std::size_t start_ = 0;
};

/// A small file that holds every chunk type and primitive kind.
inline std::vector<std::byte> small_rvm() {
  RvmBytes b;
  b.head().group("/A", 2, {1, 2, 3}).all_kinds().group("/A/B", 3).prim(8, {1, 2});
  b.begin("OBST").u32(1).u32(2).matrix().floats({-1, -2, -3, 1, 2, 3}).u32(50u << 24).floats({2, 4, 6}).end();
  b.begin("INSU").u32(1).u32(8).matrix().floats({-1, -1, -2, 1, 1, 2}).u32(0).floats({1, 4}).end();
  b.group_end().group_end();
  b.begin("CNTB").u32(3).text("/C").floats({0, 0, 0}).u32(2).u32(25u << 24).end().prim(9, {2}).group_end();
  return b.colour(2, 0x102030).finish().bytes;
}

}  // namespace sightline::tests
