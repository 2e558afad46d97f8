#include "sightline/render/image/image.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <span>
#include <string>

#include <png.h>

#include "sightline/core/internal/atomic_file.h"
#include "sightline/core/internal/platform/files.h"

namespace sightline::image {

namespace fs = std::filesystem;

namespace {

/// What was begun is over afterwards.
core::Expected<Image> finish_reading(png_image& header, const std::string& source) {
  header.format = PNG_FORMAT_RGB;
  Image image{int(header.width), int(header.height), {}};
  image.pixels.resize(PNG_IMAGE_SIZE(header));
  if (png_image_finish_read(&header, nullptr, image.pixels.data(), 0, nullptr)) return image;
  const std::string reason = header.message;
  png_image_free(&header);
  return core::fail(source + ": " + reason);
}

}  // namespace

core::Expected<std::vector<std::uint8_t>> encode_png(const Image& image, PngSize size) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = png_uint_32(image.width);
  header.height = png_uint_32(image.height);
  header.format = PNG_FORMAT_RGB;
  header.flags = size == PngSize::kFast ? PNG_IMAGE_FLAG_FAST : 0;
  png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(header);  // asking for the size would encode the image twice
  std::vector<std::uint8_t> encoded(bytes);
  if (!png_image_write_to_memory(&header, encoded.data(), &bytes, 0, image.pixels.data(), 0, nullptr))
    return core::fail(std::string("PNG: ") + header.message);
  encoded.resize(bytes);
  return encoded;
}

core::Expected<void> write_png(const Image& image, const fs::path& path) {
  if (auto good = core::expect_extension(path, ".png"); !good) return good;
  const auto encoded = encode_png(image);
  if (!encoded) return core::fail(path.string() + ": " + encoded.error().message);
  return core::write_file(path, {std::as_bytes(std::span(*encoded))});
}

core::Expected<Image> read_png(const fs::path& path) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(core::platform::open_file(path, "rb"), std::fclose);
  if (!file) return core::fail(path.string() + ": " + std::strerror(errno));
  if (!png_image_begin_read_from_stdio(&header, file.get())) return core::fail(path.string() + ": " + header.message);
  return finish_reading(header, path.string());
}

core::Expected<Image> decode_png(std::span<const std::uint8_t> bytes) {
  constexpr std::uint64_t kMostPixels = 1u << 26;
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&header, bytes.data(), bytes.size()))
    return core::fail(std::string("PNG: ") + header.message);
  if (std::uint64_t(header.width) * header.height > kMostPixels) {
    png_image_free(&header);
    return core::fail("PNG: more pixels than are read");
  }
  return finish_reading(header, "PNG");
}

core::Expected<void> write_pfm(const DepthImage& image, const fs::path& path) {
  if (auto good = core::expect_extension(path, ".pfm"); !good) return good;
  static_assert(std::endian::native == std::endian::little, "the scale line below says little-endian");
  const std::string header = "Pf\n" + std::to_string(image.width) + " " + std::to_string(image.height) + "\n-1.0\n";
  const std::size_t row = std::size_t(image.width);
  std::vector<float> flipped(image.metres.size());
  for (std::size_t y = 0; y < std::size_t(image.height); ++y)
    std::copy_n(image.metres.begin() + std::ptrdiff_t(y * row), row, flipped.end() - std::ptrdiff_t((y + 1) * row));
  return core::write_file(path, {std::as_bytes(std::span(header)), std::as_bytes(std::span(flipped))});
}

core::Expected<DepthImage> read_pfm(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return core::fail(path.string() + ": cannot be read");
  constexpr int kLargestSide = 65536;
  std::string kind;
  DepthImage image;
  double scale = 0.0;
  in >> kind >> image.width >> image.height >> scale;
  const auto within = [](int side) { return side > 0 && side <= kLargestSide; };
  if (!in || in.get() != '\n' || kind != "Pf" || scale != -1.0 || !within(image.width) || !within(image.height))
    return core::fail(path.string() + ": not a grey PFM file with little-endian numbers");
  const std::size_t row = std::size_t(image.width), rows = std::size_t(image.height);
  // The file's size is checked before memory is taken for what its header promises.
  const std::streamoff start = in.tellg();
  in.seekg(0, std::ios::end);
  if (std::size_t(in.tellg() - start) != row * rows * sizeof(float))
    return core::fail(path.string() + ": its size does not fit its " + std::to_string(row) + "x" +
                      std::to_string(rows) + " pixels");
  in.seekg(start);
  image.metres.resize(row * rows);
  for (std::size_t y = rows; y-- > 0;)
    in.read(reinterpret_cast<char*>(image.metres.data() + y * row), std::streamsize(row * sizeof(float)));
  if (!in) return core::fail(path.string() + ": cannot be read to its end");
  return image;
}

core::Expected<Image> id_colours(const IdImage& ids) {
  Image image{ids.width, ids.height, std::vector<std::uint8_t>(3 * ids.ids.size())};
  for (std::size_t i = 0; i < ids.ids.size(); ++i) {
    const std::uint32_t id = ids.ids[i];
    if (id > 0xffffffu) return core::fail("id image: item " + std::to_string(id - 1) + " does not fit into 24 bits");
    for (unsigned c = 0; c < 3; ++c) image.pixels[3 * i + c] = std::uint8_t(id >> (8 * c));
  }
  return image;
}

IdImage ids_of_colours(const Image& image) {
  IdImage ids{image.width, image.height, std::vector<std::uint32_t>(image.pixels.size() / 3)};
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    ids.ids[i / 3] |= std::uint32_t(image.pixels[i]) << (8 * (i % 3));
  return ids;
}

core::Expected<ImageDifference> compare(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height)
    return core::fail("images differ in size: " + std::to_string(a.width) + "x" + std::to_string(a.height) + " and " +
                      std::to_string(b.width) + "x" + std::to_string(b.height));
  ImageDifference difference;
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); i += 3) {
    int worst = 0;
    for (std::size_t c = i; c < i + 3; ++c) {
      const int d = std::abs(int(a.pixels[c]) - int(b.pixels[c]));
      worst = std::max(worst, d);
      sum += std::uint64_t(d);
    }
    difference.max = std::max(difference.max, worst);
    difference.pixels += worst > 0;
  }
  difference.mean = a.pixels.empty() ? 0.0 : double(sum) / double(a.pixels.size());
  return difference;
}

Image difference_image(const Image& a, const Image& b) {
  assert(a.pixels.size() == b.pixels.size());
  Image out{a.width, a.height, std::vector<std::uint8_t>(a.pixels.size())};
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    out.pixels[i] = std::uint8_t(std::min(255, 4 * std::abs(int(a.pixels[i]) - int(b.pixels[i]))));
  return out;
}

}  // namespace sightline::image
