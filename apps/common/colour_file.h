// Files of colour images, of the format that their name says.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {

/// PNG, or JPEG of good quality (92 of 100, colours in full resolution), which loses a little: for people, not for
/// comparisons. Written row by row; a JPEG image is in memory until it is finished.
class ColourFile {
 public:
  /// `alpha`: 4 bytes per pixel, RGBA, instead of 3; JPEG has none, and fails. Fails as image::PngWriter::create()
  /// does; names end in .png, .jpg or .jpeg, or in nothing, which is PNG.
  static core::Expected<ColourFile> create(const std::string& file, int width, int height, bool alpha = false);

  /// The next rows from the top. Fails as image::PngWriter does.
  core::Expected<void> write_rows(std::span<const std::uint8_t> pixels);
  /// Replaces the file.
  core::Expected<void> finish();

 private:
  std::optional<image::PngWriter> png_;
  std::string jpeg_;     // its name
  image::Image pixels_;  // of the JPEG
};

core::Expected<void> write_colours(const image::Image& image, const std::string& file);

/// The name of such a file, or what is wrong with it.
core::Expected<std::string> parse_image_name(const std::string& text);

}  // namespace sightline::apps
