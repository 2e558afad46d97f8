// Text forms of binary RVM files, written chunk by chunk.
#pragma once

#include <bit>
#include <cstdio>
#include <span>
#include <string>

namespace sightline::tests {

/// How a file is written out.
struct RvmTextStyle {
  bool fixed = false;        ///< numbers as "%14.5f", as converters do; else with all digits
  bool extra_first = false;  ///< the transparency of OBST and INSU before the matrix, else after the box
  const char* newline = "\n";
};

/// Every chunk of a whole binary file that tests wrote; facet groups, OBST and INSU included.
inline std::string rvm_as_text(std::span<const std::byte> file, const RvmTextStyle& style = {}) {
  std::string text;
  std::size_t at = 0;
  const auto word = [&] {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value = value << 8 | std::to_integer<std::uint32_t>(file[at++]);
    return value;
  };
  const auto number = [&](float value) {
    char digits[64];
    std::snprintf(digits, sizeof digits, style.fixed ? "%14.5f" : " %.9g", double(value));
    text += digits;
  };
  const auto line = [&](const std::string& content) { text += content + style.newline; };
  const auto floats = [&](int n) {
    for (int i = 0; i < n; ++i) number(std::bit_cast<float>(word()));
    line("");
  };
  const auto counted = [&] {
    const std::uint32_t value = word();
    line("     " + std::to_string(value));
    return value;
  };
  const auto string = [&] {
    const std::size_t size = 4 * std::size_t(word());
    const std::string content(reinterpret_cast<const char*>(file.data()) + at, size);
    at += size;
    line(content.substr(0, content.find('\0')));
  };
  for (;;) {
    std::string tag;
    for (int i = 0; i < 4; ++i) tag += char(word());
    const std::size_t next = word();
    word();
    const std::uint32_t version = word();
    line(tag);
    line("     1     " + std::to_string(version));
    if (tag == "END:") return text;
    if (tag == "HEAD")
      for (int i = 0; i < (version >= 2 ? 5 : 4); ++i) string();
    if (tag == "MODL") string(), string();
    if (tag == "CNTB") {
      string();
      floats(3);
      counted();
      if (version >= 3) line("   " + std::to_string(word() >> 24));
    }
    if (tag == "COLR") {
      counted();
      const std::uint32_t rgb = word();
      line(std::to_string(rgb >> 24) + " " + std::to_string(rgb >> 16 & 255) + " " + std::to_string(rgb >> 8 & 255));
    }
    if (tag == "PRIM" || tag == "OBST" || tag == "INSU") {
      const std::uint32_t kind = counted();
      float m[12];
      for (float& value : m) value = std::bit_cast<float>(word());
      std::string box;
      std::swap(box, text);
      floats(3), floats(3);
      std::swap(box, text);
      const std::string extra = tag == "PRIM" ? "" : "   " + std::to_string(word() >> 24) + style.newline;
      if (style.extra_first) text += extra;
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) number(m[3 * column + row]);
        line("");
      }
      text += box;
      if (!style.extra_first) text += extra;
      if (kind != 11) floats(int(next - at) / 4);
      for (std::uint32_t p = 0, polygons = kind == 11 ? counted() : 0; p < polygons; ++p)
        for (std::uint32_t c = 0, contours = counted(); c < contours; ++c)
          for (std::uint32_t v = 0, vertices = counted(); v < vertices; ++v) floats(3), floats(3);
    }
    at = next;
  }
}

}  // namespace sightline::tests
