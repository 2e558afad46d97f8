// Internal to the importers: what is left of a texture, its mean. Compiled with the reader of glTF.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "sightline/core/affine.h"
#include "sightline/core/error.h"

namespace sightline::importers {

/// Mean of an image's pixels in linear light: red, green, blue and alpha, 0 … 1. With `weigh`, each pixel counts as far
/// as it is opaque.
struct ImageMean {
  core::dvec3 colour{1.0};
  double alpha = 1.0;
};
/// Decodes a PNG or JPEG file image of at most kMostPixels by stb_image. Its pixels are subtracted from `pixels_left`;
/// the image is refused when that does not suffice. Memory: 4 bytes per pixel during the call.
core::Expected<ImageMean> image_mean(std::span<const std::byte> file, bool weigh, std::uint64_t& pixels_left);
inline constexpr std::uint64_t kMostPixels = std::uint64_t{64} << 20;
/// Most pixels of all images together, per byte of the file: what deflate can pack. This stops files that name one
/// image over and over.
inline constexpr std::uint64_t kPixelsPerByte = 1024;

}  // namespace sightline::importers
