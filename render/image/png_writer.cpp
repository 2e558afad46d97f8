#include <csetjmp>
#include <string>
#include <utility>

#include <png.h>

#include "sightline/core/internal/atomic_file.h"
#include "sightline/render/image/image.h"

namespace sightline::image {

namespace {

constexpr int kCompression = 3;  // as libpng's fast writing has it

}  // namespace

/// At a fixed address: libpng's callbacks point to it.
struct PngWriter::State {
  State(core::AtomicFile opened, std::string named, int wide, int high, PngColours has)
      : file(std::move(opened)),
        name(std::move(named)),
        colours(has),
        row_bytes(std::size_t(has) * std::size_t(wide)),
        rows_left(high) {}
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() { png_destroy_write_struct(&png, &info); }

  static void write(png_structp png, png_bytep bytes, std::size_t count) {
    // A failed write is told by commit(); libpng goes on.
    static_cast<State*>(png_get_io_ptr(png))->file.write(std::as_bytes(std::span(bytes, count)));
  }
  static void flush(png_structp) {}
  static void fail(png_structp png, png_const_charp message) {
    static_cast<State*>(png_get_error_ptr(png))->reason = message;
    png_longjmp(png, 1);
  }
  static void warn(png_structp, png_const_charp) {}

  bool begin(int width, int height);
  bool write_rows(const std::uint8_t* pixels, std::size_t rows);
  bool end();
  tl::unexpected<core::Error> error() const { return core::fail(name + ": " + reason); }

  core::AtomicFile file;
  std::string name, reason;
  PngColours colours;
  std::size_t row_bytes;
  int rows_left;
  png_structp png = nullptr;
  png_infop info = nullptr;
};

// What libpng calls may leave by a jump, so that nothing in these three functions may need to be destroyed.

bool PngWriter::State::begin(int width, int height) {
  png = png_create_write_struct(PNG_LIBPNG_VER_STRING, this, &State::fail, &State::warn);
  if (png) info = png_create_info_struct(png);
  if (!info) return false;
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_write_fn(png, this, &State::write, &State::flush);
  png_set_IHDR(png, info, png_uint_32(width), png_uint_32(height), 8,
               colours == PngColours::kRgb ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGBA, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_set_compression_level(png, kCompression);
  png_write_info(png, info);
  return true;
}

bool PngWriter::State::write_rows(const std::uint8_t* pixels, std::size_t rows) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  for (std::size_t row = 0; row < rows; ++row) png_write_row(png, pixels + row * row_bytes);
  return true;
}

bool PngWriter::State::end() {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_write_end(png, info);
  return true;
}

PngWriter::PngWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
PngWriter::PngWriter(PngWriter&&) noexcept = default;
PngWriter& PngWriter::operator=(PngWriter&&) noexcept = default;
PngWriter::~PngWriter() = default;

core::Expected<PngWriter> PngWriter::create(const std::filesystem::path& path, int width, int height,
                                            PngColours colours) {
  if (width < 1 || height < 1) return core::fail(path.string() + ": PNG: width and height must be above 0");
  if (auto good = core::expect_extension(path, ".png"); !good) return tl::unexpected(good.error());
  auto file = core::AtomicFile::create(path);
  if (!file) return tl::unexpected(file.error());
  auto state = std::make_unique<State>(std::move(*file), path.string(), width, height, colours);
  if (!state->begin(width, height)) return state->error();
  return PngWriter(std::move(state));
}

core::Expected<void> PngWriter::write_rows(std::span<const std::uint8_t> pixels) {
  const std::size_t rows = pixels.size() / state_->row_bytes;
  if (rows * state_->row_bytes != pixels.size() || rows > std::size_t(state_->rows_left))
    return core::fail(state_->name + ": PNG: expected whole rows, at most " + std::to_string(state_->rows_left));
  state_->rows_left -= int(rows);
  if (!state_->write_rows(pixels.data(), rows)) return state_->error();
  if (state_->file.failed()) return state_->file.commit();
  return {};
}

core::Expected<void> PngWriter::finish() {
  if (state_->rows_left > 0)
    return core::fail(state_->name + ": PNG: " + std::to_string(state_->rows_left) + " rows are missing");
  if (!state_->end()) return state_->error();
  return state_->file.commit();
}

}  // namespace sightline::image
