#include "sightline/apps/common/colour_file.h"

#include <algorithm>
#include <cstddef>

#include "sightline/core/internal/atomic_file.h"
#include "sightline/core/internal/platform/files.h"

#if SIGHTLINE_HAS_JPEG
// Compiled only here, without access to files.
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#include <stb_image_write.h>
#endif

namespace sightline::apps {
namespace {

constexpr int kMostJpegSide = 65'535;

bool is_jpeg(const std::string& file) {
  const auto path = core::platform::path_of(file);
  return path.has_extension() && !path.stem().empty() &&
         (core::expect_extension(path, ".jpg") || core::expect_extension(path, ".jpeg"));
}

core::Expected<void> write_jpeg([[maybe_unused]] const image::Image& image, const std::string& file) {
#if SIGHTLINE_HAS_JPEG
  constexpr int kQuality = 92;  // from 91 on colours have the resolution of the image
  std::vector<std::byte> bytes;
  const auto append = [](void* to, void* data, int size) {
    const auto* from = static_cast<const std::byte*>(data);
    static_cast<std::vector<std::byte>*>(to)->insert(static_cast<std::vector<std::byte>*>(to)->end(), from,
                                                     from + size);
  };
  if (!stbi_write_jpg_to_func(append, &bytes, image.width, image.height, 3, image.pixels.data(), kQuality))
    return core::fail(file + ": JPEG: the image cannot be written");
  return core::write_file(core::platform::path_of(file), {bytes});
#else
  return core::fail(file + ": this build writes no JPEG (stb_image_write.h was not found)");
#endif
}

}  // namespace

core::Expected<ColourFile> ColourFile::create(const std::string& file, int width, int height, bool alpha) {
  ColourFile made;
  if (is_jpeg(file)) {
    if (alpha) return core::fail(file + ": JPEG has no transparency; PNG has");
    if (width < 1 || height < 1 || width > kMostJpegSide || height > kMostJpegSide)
      return core::fail(file + ": JPEG: width and height must be 1 to " + std::to_string(kMostJpegSide));
    made.jpeg_ = file;
    made.pixels_ = {width, height, {}};
    return made;
  }
  auto png = image::PngWriter::create(core::platform::path_of(file), width, height,
                                      alpha ? image::PngColours::kRgba : image::PngColours::kRgb);
  if (!png) return tl::unexpected(png.error());
  made.png_ = std::move(*png);
  return made;
}

core::Expected<void> ColourFile::write_rows(std::span<const std::uint8_t> pixels) {
  if (png_) return png_->write_rows(pixels);
  pixels_.pixels.insert(pixels_.pixels.end(), pixels.begin(), pixels.end());
  return {};
}

core::Expected<void> ColourFile::finish() {
  if (png_) return png_->finish();
  if (pixels_.pixels.size() != 3u * std::size_t(pixels_.width) * std::size_t(pixels_.height))
    return core::fail(jpeg_ + ": JPEG: rows are missing");
  return write_jpeg(pixels_, jpeg_);
}

core::Expected<void> write_colours(const image::Image& image, const std::string& file) {
  return is_jpeg(file) ? write_jpeg(image, file) : image::write_png(image, core::platform::path_of(file));
}

core::Expected<std::string> parse_image_name(const std::string& text) {
  if (is_jpeg(text)) return text;
  auto good = core::expect_extension(core::platform::path_of(text), ".png");
  return good ? core::Expected<std::string>(text)
              : core::fail(text + ": expected a name that ends in .png, .jpg or .jpeg");
}

}  // namespace sightline::apps
