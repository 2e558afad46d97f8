#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <memory>

#include <fmt/format.h>

#include "sightline/core/internal/srgb.h"
#include "sightline/importers/gltf/internal/gltf_materials.h"

// Compressed pixels may swell to a thousand times their size, whatever size the header states. So each allocation of
// stb_image is limited by what an image of the stated size can need. An image that asks for more is damaged.
namespace {
thread_local std::size_t largest_allocation = 0;  // bytes

void* allocate(std::size_t bytes) {
  return bytes <= largest_allocation ? std::malloc(bytes) : nullptr;
}
void* reallocate(void* former, std::size_t bytes) {
  return bytes <= largest_allocation ? std::realloc(former, bytes) : nullptr;
}
}  // namespace

// stb_image is compiled only here, for the two formats that glTF allows, and without access to files.
#define STBI_MALLOC(bytes) allocate(bytes)
#define STBI_REALLOC(former, bytes) reallocate(former, bytes)
#define STBI_FREE(former) std::free(former)
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_NO_HDR
#define STBI_NO_LINEAR
#define STBI_NO_FAILURE_STRINGS
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb_image.h>
#pragma GCC diagnostic pop

namespace sightline::importers {
namespace {

bool starts_with(std::span<const std::byte> file, std::initializer_list<int> signature) {
  if (file.size() < signature.size()) return false;
  std::size_t i = 0;
  for (const int byte : signature)
    if (file[i++] != std::byte(byte)) return false;
  return true;
}

bool is_png(std::span<const std::byte> file) {
  return starts_with(file, {0x89, 'P', 'N', 'G'});
}

/// Whether every chunk of a PNG file ends within it. stb_image reserves memory by the length of a chunk before it reads
/// one, and doubles 32-bit sizes until they overflow.
bool chunks_fit(std::span<const std::byte> png) {
  constexpr std::size_t kSignature = 8, kAround = 12;  // length, name and checksum of a chunk
  for (std::size_t at = kSignature; png.size() >= at + kAround;) {
    std::size_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8 | std::size_t(png[at + i]);
    if (length > png.size() - at - kAround) return false;
    at += kAround + length;
  }
  return true;
}

/// The most bytes that decoding takes in one piece: 16 bits for each of four channels, of an image whose sides a JPEG
/// rounds up to its blocks, or the compressed bytes. stb_image doubles a buffer that is too small.
std::size_t most_allocated(std::size_t file_bytes, std::uint64_t width, std::uint64_t height) {
  constexpr std::size_t kTables = std::size_t{64} << 10;
  return kTables + 2 * std::max<std::size_t>(file_bytes, 8 * (width + 64) * (height + 64));
}

}  // namespace

core::Expected<ImageMean> image_mean(std::span<const std::byte> file, bool weigh, std::uint64_t& pixels_left) {
  if (!is_png(file) && !starts_with(file, {0xff, 0xd8})) return core::fail("expected a PNG or JPEG image");
  if (file.size() > std::size_t(std::numeric_limits<int>::max())) return core::fail("expected an image below 2 GiB");
  if (is_png(file) && !chunks_fit(file)) return core::fail("expected a whole image, found a chunk beyond its end");
  const auto* data = reinterpret_cast<const stbi_uc*>(file.data());
  int width = 0, height = 0, channels = 0;
  largest_allocation = most_allocated(file.size(), 0, 0);
  if (!stbi_info_from_memory(data, int(file.size()), &width, &height, &channels) || width <= 0 || height <= 0)
    return core::fail("expected a readable image header");
  const std::uint64_t count = std::uint64_t(width) * std::uint64_t(height);
  if (count > kMostPixels)
    return core::fail(fmt::format("expected at most {} pixels, found {} x {}", kMostPixels, width, height));
  if (count > pixels_left) return core::fail("more pixels in all images than the file's size allows");
  pixels_left -= count;
  largest_allocation = most_allocated(file.size(), std::uint64_t(width), std::uint64_t(height));
  const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
      stbi_load_from_memory(data, int(file.size()), &width, &height, &channels, 4), stbi_image_free);
  if (!pixels) return core::fail("expected a whole image, found damage");
  const std::array<double, 256> linear = core::linear_from_bytes();
  core::dvec3 sum(0.0);
  double weights = 0.0, alpha = 0.0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const stbi_uc* pixel = pixels.get() + 4 * i;
    const double weight = weigh ? pixel[3] / 255.0 : 1.0;
    sum += weight * core::dvec3(linear[pixel[0]], linear[pixel[1]], linear[pixel[2]]);
    weights += weight;
    alpha += pixel[3] / 255.0;
  }
  return ImageMean{weights > 0.0 ? sum / weights : core::dvec3(1.0), alpha / double(count)};
}

}  // namespace sightline::importers
