#include "sightline/apps/common/tiled_image.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "sightline/apps/common/output.h"
#include "sightline/core/image_rays.h"

namespace sightline::apps {
namespace {

core::Expected<void> set_background(engine::Engine& engine, const gpuprims::Background& background) {
  engine::EngineConfig config = engine.config();
  config.drawing.looks.background = background;
  return engine.configure(config);
}

}  // namespace

/// What shows of the background is a share of it, in sRGB values as all blending is, so that the two differ by just
/// that.
std::vector<std::uint8_t> with_alpha(std::span<const std::uint8_t> on_black, std::span<const std::uint8_t> on_white) {
  std::vector<std::uint8_t> pixels;
  pixels.reserve(on_black.size() / 3 * 4);
  for (std::size_t i = 0; i < on_black.size(); i += 3) {
    int shows = 0;  // of three channels
    for (std::size_t c = i; c < i + 3; ++c) shows += std::max(0, int(on_white[c]) - int(on_black[c]));
    const int alpha = 255 - (shows + 1) / 3;
    for (std::size_t c = i; c < i + 3; ++c)
      pixels.push_back(std::uint8_t(alpha == 0 ? 0 : std::min(255, (255 * on_black[c] + alpha / 2) / alpha)));
    pixels.push_back(std::uint8_t(alpha));
  }
  return pixels;
}

core::Expected<bool> TiledImage::step(engine::Engine& engine) {
  const engine::CroppedTile& tile = tiles_.tiles[done_ / steps_of_tile()];
  const bool first = done_ % steps_of_tile() == 0, apart = first && drawn_apart_;
  const std::size_t number = done_ % steps_of_tile() - std::size_t(drawn_apart_);  // of the shift, unless apart
  const auto drawn = draw_and_read(engine, tile, apart ? core::dvec2(0.0) : wanted_.shifts[number], first);
  if (!drawn) return tl::unexpected(drawn.error());
  covered_ |= drawn->covered;
  if (first) {
    begin_rows(tile);
    if (wanted_.ids) take(tile, drawn->ids.ids, rows_.ids, 1);
    if (wanted_.depth) take(tile, drawn->depth.metres, rows_.metres, 1);
  }
  if (!apart) add(tile, drawn->colours, number);
  ++done_;
  return !apart && number + 1 == wanted_.shifts.size() && tile.x1 == tile.tile.width;
}

/// The image of a shift, to the colours of its tile.
void TiledImage::add(const engine::CroppedTile& tile, const image::Image& image, std::size_t number) {
  if (wanted_.shifts.size() == 1 && !wanted_.transparent) return take(tile, image.pixels, rows_.colours, 3);
  if (number == 0) mean_.clear();
  mean_.add(image);
  if (number + 1 < wanted_.shifts.size()) return;
  if (wanted_.transparent)
    return take(tile, with_alpha(mean_.mean().pixels, on_white_.mean().pixels), rows_.colours, 4);
  take(tile, mean_.mean().pixels, rows_.colours, 3);
}

/// With a transparent background the image is that on black, and on_white_ gets the other.
core::Expected<ReadImage> TiledImage::draw_and_read(engine::Engine& engine, const engine::CroppedTile& tile,
                                                    const core::dvec2& shift, bool first) {
  if (!wanted_.transparent) return read(engine, draw(engine, tile, shift), first);
  const gpuprims::Background own = engine.config().drawing.looks.background;
  if (auto done = set_background(engine, {core::vec3(1.0f), core::vec3(1.0f)}); !done)
    return tl::unexpected(done.error());
  auto white = read(engine, draw(engine, tile, shift), false);
  if (auto done = set_background(engine, {core::vec3(0.0f), core::vec3(0.0f)}); !done)
    return tl::unexpected(done.error());
  auto black = read(engine, draw(engine, tile, shift), first);
  if (auto done = set_background(engine, own); !done) return tl::unexpected(done.error());
  if (!white || !black) return white ? black : white;
  if (first) on_white_.clear();
  if (!first || !drawn_apart_) on_white_.add(white->colours);
  return black;
}

core::Expected<void> TiledImage::draw(engine::Engine& engine, const engine::CroppedTile& tile,
                                      const core::dvec2& shift) {
  engine::ImageTile part = tile.tile;
  part.x -= shift.x;
  part.y += shift.y;
  do {  // more than once with a budget
    const auto report = engine.frame_tile(whole_, part);
    if (!report) return tl::unexpected(report.error());
    if (!report->drawn) return core::fail("the GL context was lost before the image was drawn");
    report_ = *report;
  } while (wanted_.complete && report_.pending > 0);
  engine.finish();
  while (const auto late = engine.take_late_report()) report_.visible = late->visible;
  found_ |= report_.visible > 0;
  return {};
}

void TiledImage::begin_rows(const engine::CroppedTile& tile) {
  if (tile.x0 > 0) return;
  rows_.width = tile.tile.width;
  rows_.first = tile.y0;
  rows_.count = tile.y1 - tile.y0;
  const std::size_t pixels = std::size_t(rows_.width) * std::size_t(rows_.count);
  rows_.colours.resize((wanted_.transparent ? 4 : 3) * pixels);
  rows_.ids.resize(wanted_.ids ? pixels : 0);
  rows_.metres.resize(wanted_.depth ? pixels : 0);
}

core::Expected<ReadImage> TiledImage::read(engine::Engine& engine, const core::Expected<void>& drawn,
                                           bool ids_and_depth) {
  using Report = core::Expected<engine::FrameReport>;
  if (wanted_.read) return wanted_.read(engine, whole_, drawn ? Report(report_) : tl::unexpected(drawn.error()));
  if (!drawn) return tl::unexpected(drawn.error());
  ReadImage out;
  if (ids_and_depth && wanted_.ids) {
    auto ids = engine.read_ids();
    if (!ids) return tl::unexpected(ids.error());
    out.ids = std::move(*ids);
  }
  if (ids_and_depth && wanted_.depth) {
    auto depth = engine.read_depth(whole_);
    if (!depth) return tl::unexpected(depth.error());
    out.depth = std::move(*depth);
  }
  auto colours = engine.read_colour();
  if (!colours) return tl::unexpected(colours.error());
  out.colours = std::move(*colours);
  out.covered = report_.visible != 0 && (covered_ || engine.covered().value_or(true));
  return out;
}

template <class T>
void TiledImage::take(const engine::CroppedTile& tile, const std::vector<T>& drawn, std::vector<T>& rows,
                      std::size_t channels) {
  const std::size_t left = std::size_t(tile.x0 - int(tile.tile.x)), count = std::size_t(tile.x1 - tile.x0);
  for (int y = tile.y0; y < tile.y1; ++y) {
    const std::size_t from = std::size_t(y - int(tile.tile.y)) * std::size_t(tiles_.width) + left;
    const std::size_t to = std::size_t(y - tile.y0) * std::size_t(rows_.width) + std::size_t(tile.x0);
    std::copy_n(drawn.begin() + std::ptrdiff_t(channels * from), channels * count,
                rows.begin() + std::ptrdiff_t(channels * to));
  }
}

std::vector<core::dvec2> sample_shifts(int samples) {
  std::vector<core::dvec2> shifts = core::rook_positions(samples);
  for (core::dvec2& shift : shifts) shift -= 0.5;
  return shifts;
}

core::Expected<engine::ImageTiles> tiles_for(const std::array<int, 2>& size, int largest_side,
                                             const engine::EngineConfig& config) {
  const bool splats = config.losses.contribution_mode != engine::ContributionMode::kDrop;
  const int side = splats ? int(std::ceil(std::sqrt(config.losses.min_projected_area))) : 0;
  return engine::image_tiles(size[0], size[1], largest_side, side);
}

core::Expected<PathFrames> PathFrames::create(const core::CameraPath& path, double per_second) {
  if (!(per_second > 0.0 && per_second <= kMostPerSecond))
    return core::fail("frames per second: expected a number above 0 and at most 1000");
  const double rounding = 1e-9, frames = std::floor((path.end() - path.begin()) * per_second * (1.0 + rounding)) + 1.0;
  if (frames > double(kMost))
    return core::fail("a path of " + std::to_string(path.end() - path.begin()) + " seconds has more than " +
                      std::to_string(kMost) + " frames at that rate");
  PathFrames made;
  made.begin_ = path.begin();
  made.per_second_ = per_second;
  made.count_ = int(frames);
  return made;
}

std::string PathFrames::file_name(int frame) {
  return fmt::format("frame-{:06}.png", frame + 1);
}

core::Expected<void> take_empty_folder(const std::string& folder) {
  if (folder.empty()) return core::fail("expected the name of a folder");
  if (auto made = make_directory(folder); !made) return made;
  std::error_code reason;
  const bool empty = std::filesystem::is_empty(folder, reason);
  if (reason) return core::fail(folder + ": " + reason.message());
  if (!empty) return core::fail(folder + ": is not empty; frames of two flights must not mix");
  return {};
}

}  // namespace sightline::apps
