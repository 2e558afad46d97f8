// Images on the CPU: PNG and PFM files, and comparison for regression tests.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"

namespace sightline::image {

/// 8-bit RGB, rows top to bottom, 3 bytes per pixel.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
};

/// Metres along the view axis, rows top to bottom; infinity where nothing was drawn.
struct DepthImage {
  int width = 0, height = 0;
  std::vector<float> metres;
};

/// Item id + 1, rows top to bottom; 0 is background.
struct IdImage {
  int width = 0, height = 0;
  std::vector<std::uint32_t> ids;
};

/// Unit normals in eye space, towards the eye, as used for shading; rows top to bottom; zero where nothing was drawn.
struct NormalImage {
  int width = 0, height = 0;
  std::vector<std::array<float, 3>> normals;
};

enum class PngSize : std::uint8_t {
  kFast,   ///< four times faster to write, a little larger
  kSmall,  ///< for images that are kept
};
/// The bytes of a PNG file.
SIGHTLINE_API core::Expected<std::vector<std::uint8_t>> encode_png(const Image& image, PngSize size = PngSize::kFast);

/// An image out of such bytes. Any bytes are safe: what has more than 2^26 pixels, whatever size the bytes claim, is an
/// error.
SIGHTLINE_API core::Expected<Image> decode_png(std::span<const std::uint8_t> bytes);

/// Writers replace `path` only when complete (core/internal/atomic_file.h). Errors name the file and the reason: a name
/// that ends otherwise than in .png, or .pfm, is one; without any extension it is good.
SIGHTLINE_API core::Expected<void> write_png(const Image& image, const std::filesystem::path& path);
SIGHTLINE_API core::Expected<Image> read_png(const std::filesystem::path& path);
enum class PngColours : std::uint8_t { kRgb = 3, kRgba = 4 };  ///< bytes per pixel; alpha is not multiplied in
/// A PNG file that is written row by row, so that no image as large as it need be in memory. As write_png() does.
class SIGHTLINE_API PngWriter {
 public:
  /// Fails where the file cannot be written or has another extension, and on sizes that PNG does not have.
  static core::Expected<PngWriter> create(const std::filesystem::path& path, int width, int height,
                                          PngColours colours = PngColours::kRgb);
  PngWriter(PngWriter&&) noexcept;
  PngWriter& operator=(PngWriter&&) noexcept;
  ~PngWriter();  ///< without finish() the file stays as it was

  /// The next rows from the top. Fails where there is no space left, and beyond the last row; no
  /// call may follow a failure.
  core::Expected<void> write_rows(std::span<const std::uint8_t> pixels);
  /// Replaces the file. Fails unless all rows were written; no call may follow.
  core::Expected<void> finish();

 private:
  struct State;
  explicit PngWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Grey PFM, little-endian, rows bottom to top as the format wants.
SIGHTLINE_API core::Expected<void> write_pfm(const DepthImage& image, const std::filesystem::path& path);
/// What write_pfm() writes. Anything else is an error, colours and other byte orders too.
SIGHTLINE_API core::Expected<DepthImage> read_pfm(const std::filesystem::path& path);
/// Ids as 24-bit colour, R the low byte; an id above 0xffffff is an error.
SIGHTLINE_API core::Expected<Image> id_colours(const IdImage& ids);
SIGHTLINE_API IdImage ids_of_colours(const Image& image);

/// Differences over all channels of all pixels, in 0 … 255.
struct ImageDifference {
  int max = 0;
  double mean = 0.0;
  std::uint64_t pixels = 0;  ///< pixels that differ at all
};
/// Fails when the sizes differ.
SIGHTLINE_API core::Expected<ImageDifference> compare(const Image& a, const Image& b);
/// Absolute differences, amplified four times, as an image. Sizes must be equal.
SIGHTLINE_API Image difference_image(const Image& a, const Image& b);

}  // namespace sightline::image
