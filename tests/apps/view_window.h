// sightline-view in a window of a virtual display: its images, and scripts that drive it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <png.h>

#include "sightline/tests/apps/window_test.h"

namespace sightline::tests {

/// 8-bit RGB, rows top to bottom.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

inline void write_png(const Image& image, const std::string& file) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = png_uint_32(image.width);
  header.height = png_uint_32(image.height);
  header.format = PNG_FORMAT_RGB;
  EXPECT_TRUE(png_image_write_to_file(&header, file.c_str(), 0, image.rgb.data(), 0, nullptr)) << header.message;
}

inline Image read_png(const std::string& file) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  Image image;
  EXPECT_TRUE(png_image_begin_read_from_file(&header, file.c_str())) << file << ": " << header.message;
  header.format = PNG_FORMAT_RGB;
  image.rgb.resize(PNG_IMAGE_SIZE(header));
  EXPECT_TRUE(png_image_finish_read(&header, nullptr, image.rgb.data(), 0, nullptr)) << header.message;
  image.width = int(header.width);
  image.height = int(header.height);
  return image;
}

/// Pixels in which surfaces that coincide may change places when items are drawn in another order.
inline constexpr std::size_t kTies = 5;

inline std::size_t differing(const Image& a, const Image& b) {
  if (a.rgb.size() != b.rgb.size()) return a.rgb.size() + b.rgb.size();
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.rgb.size(); i += 3) count += !std::equal(&a.rgb[i], &a.rgb[i] + 3, &b.rgb[i]);
  return count;
}

/// The upper left corner of a screen that Xvfb keeps as a file: an X window dump (XWDFile.h, version 7) of 32 bits per
/// pixel, blue first.
inline Image read_screen(const std::string& file, int width, int height) {
  const std::string bytes = read_bytes(file);
  const auto word = [&](std::size_t index) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | std::uint8_t(bytes.at(4 * index + i));
    return std::size_t(value);
  };
  constexpr std::size_t kHeaderBytes = 0, kBytesPerLine = 12, kColours = 19, kBytesPerColour = 12;
  const std::size_t first = word(kHeaderBytes) + kBytesPerColour * word(kColours);
  Image image{width, height, {}};
  for (std::size_t y = 0; y < std::size_t(height); ++y)
    for (std::size_t x = 0; x < std::size_t(width); ++x)
      for (const std::size_t channel : {2, 1, 0})
        image.rgb.push_back(std::uint8_t(bytes.at(first + y * word(kBytesPerLine) + 4 * x + channel)));
  return image;
}

class View : public WindowTest {
 protected:
  /// sightline-view must succeed.
  Outcome view(const Args& args) const {
    Outcome outcome = run("view", args);
    EXPECT_EQ(outcome.code, 0) << outcome;
    return outcome;
  }
  /// The window's part of the screen, the window being the only one there.
  std::string screen(int width, int height) const {
    std::string file = path("screen.png");
    write_png(read_screen(path("Xvfb_screen0"), width, height), file);
    return file;
  }
  /// Other drivers make the same image but for a few pixels on edges.
  Outcome compare(const std::string& image, Args render_args) const {
    render_args.insert(render_args.end(), {"--plain", "--compare", image, "--max", "255", "--mean", "0.05"});
    return run("render", render_args);
  }
};

/// sightline-view driven by a script. Any expectation that it does not meet makes it fail.
class ViewScript : public View {
 protected:
  Outcome drive(const std::string& text, Args args) const {
    args.insert(args.end(), {"--script", write("script.txt", text)});
    return run("view", args);
  }
  void expect_driven(const std::string& text, const Args& args) const {
    const Outcome outcome = drive(text, args);
    EXPECT_EQ(outcome.code, 0) << outcome;
  }
  /// The state at the end.
  Json state_after(const std::string& text, Args args) const {
    args.insert(args.end(), {"--script", write("script.txt", text + "wait 0\n")});
    return run_json("view", args);
  }
  struct Box {
    const char* name;
    double x, y, z, half;
  };
  std::string write_boxes(const std::string& file, const std::vector<Box>& boxes) const {
    std::string text;
    int vertex = 0;
    for (const Box& b : boxes) {
      text += std::string("o ") + b.name + "\n";
      for (int i = 0; i < 8; ++i)
        text += "v " + std::to_string(b.x + (i & 1 ? b.half : -b.half)) + " " +
                std::to_string(b.y + (i & 2 ? b.half : -b.half)) + " " +
                std::to_string(b.z + (i & 4 ? b.half : -b.half)) + "\n";
      for (const auto& f :
           {std::array{1, 3, 4, 2}, {5, 6, 8, 7}, {1, 2, 6, 5}, {3, 7, 8, 4}, {1, 5, 7, 3}, {2, 4, 8, 6}})
        text += "f " + std::to_string(vertex + f[0]) + " " + std::to_string(vertex + f[1]) + " " +
                std::to_string(vertex + f[2]) + " " + std::to_string(vertex + f[3]) + "\n";
      vertex += 8;
    }
    return write(file, text);
  }
  /// Four boxes: one behind another, and two beside them.
  std::string boxes() const {
    return write_boxes("boxes.obj",
                       {{"front", 0, 0, 0, 1}, {"behind", 0, 10, 0, 1}, {"left", -6, 5, 0, 1}, {"right", 6, 5, 0, 1}});
  }
  static constexpr const char* kSize = "600x400";
};

}  // namespace sightline::tests
