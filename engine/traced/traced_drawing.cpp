#include "sightline/engine/traced/internal/traced_drawing.h"

#include <algorithm>
#include <string>
#include <utility>

#include "sightline/core/image_rays.h"
#include "sightline/core/internal/instruction_set.h"
#include "sightline/engine/internal/settings.h"
#include "sightline/engine/traced/internal/depth_shading.h"
#include "sightline/engine/traced/internal/edges.h"
#include "sightline/gpuprims/internal/view_block.h"
#include "sightline/raytrace/internal/packed_colour.h"
#include "sightline/render/image/image.h"

namespace sightline::engine {
namespace {

using raytrace::StillImage;

/// Calls visit(row) from the top down.
template <class Pixel, class Visit>
void for_each_row_down(const StillImage& image, std::span<Pixel> pixels, const Visit& visit) {
  const auto width = std::size_t(image.width());
  for (std::size_t end = pixels.size(); end > 0; end -= width) visit(pixels.subspan(end - width, width));
}

/// A colour, multiplied by its alpha, over another one.
std::uint32_t over(std::uint32_t front, std::uint32_t back) {
  const std::uint32_t rest = 255u - (front >> 24);
  const auto channel = [&](int shift) {
    return std::min(255u, (front >> shift & 255u) + ((back >> shift & 255u) * rest + 127u) / 255u) << shift;
  };
  return channel(0) | channel(8) | channel(16) | 0xff000000u;
}

}  // namespace

TracedDrawing::TracedDrawing(const EngineConfig& config, const Overrides& overrides, std::string why)
    : config_(config), overrides_(overrides), why_(std::move(why)), threads_(config.threads, config.runner) {
  (void)use_image(0, config.width, config.height);
}

core::Expected<void> TracedDrawing::resize(int width, int height) {
  *image_ = {width, height, {}};
  return {};
}

core::Expected<void> TracedDrawing::use_image(std::uint32_t number, int width, int height) {
  image_ = &images_[number];
  if (image_->width != width || image_->height != height) return resize(width, height);
  return {};
}

core::Expected<DrawResult> TracedDrawing::draw(const Frame& frame, const core::VisibleSet& visible, bool) {
  const DepthShading& depth_shading = config_.drawing.looks.depth_shading;
  StillImage& image = image_->pixels;
  find_shown(frame, visible);
  auto done = draw_items(frame, frame.aside() ? all_but(shown_, overrides_.ghosts()) : overrides_.ghosts(), image);
  if (done && depth_shading.any())
    shade({image.width(), image.height(), image.pixels().colours, image.pixels().depths},
          gpuprims::pixel_depth(frame.view, image.height()), depth_shading, threads_);
  if (done && config_.drawing.looks.edges.any()) draw_edges(frame);
  if (done) done = draw_ghosts(frame);
  if (done) done = draw_outline(frame);
  if (!done) return tl::unexpected(done.error());
  DrawResult result;
  result.counts = {-1, std::int64_t(frame.snapshot.count(visible))};
  return result;
}

/// Sets shown_ for what asks for it: lines, what lies over the image, and views beside the one that was culled for.
void TracedDrawing::find_shown(const Frame& frame, const core::VisibleSet& visible) {
  shown_.clear();
  if (frame.lines.empty() && overrides_.ghosts().empty() && overrides_.outlined().empty() && !frame.aside()) return;
  shown_.resize(culling::bit_words(frame.snapshot.size()));
  culling::set_bits(visible, shown_);
}

/// Bits of all slots but the visible ones of a set, and of `more`.
culling::SlotBits TracedDrawing::all_but(culling::SlotBits items, culling::SlotBits more) {
  const auto word_of = [](culling::SlotBits bits, std::size_t word) { return word < bits.size() ? bits[word] : 0; };
  without_.resize(shown_.size());
  for (std::size_t word = 0; word < without_.size(); ++word)
    without_[word] = ~(word_of(items, word) & shown_[word]) | word_of(more, word);
  return without_;
}

core::Expected<void> TracedDrawing::draw_items(const Frame& frame, culling::SlotBits without, StillImage& image,
                                               bool as_ghosts) {
  line_bits_.assign(frame.lines.begin(), frame.lines.end());
  for (std::size_t word = 0; word < line_bits_.size(); ++word)
    line_bits_[word] &= shown_[word] & ~(word < without.size() ? without[word] : 0);
  culling::slots_of(line_bits_, lines_);
  const Looks& looks = config_.drawing.looks;
  const raytrace::TracedPart part{frame.tracer, without};
  return image.draw({{{&part, 1}},
                     frame.view,
                     image_->width,
                     image_->height,
                     looks.lighting,
                     looks.sun,
                     rows_of(looks.background, frame.rows),
                     as_ghosts},
                    {&frame.snapshot, lines_}, config_.drawing.samples, threads_);
}

/// Over what the image shows: items without a pixel have no lines.
void TracedDrawing::draw_edges(const Frame& frame) {
  StillImage& image = image_->pixels;
  const StillImage::Pixels pixels = image.pixels();
  std::vector<std::uint64_t> seen(culling::bit_words(frame.snapshot.size()));
  std::uint32_t last = 0;
  for (const std::uint32_t id : pixels.ids) {
    if (id == last || (last = id) == 0) continue;
    const core::Slot slot = frame.snapshot.slot(core::ItemId{id - 1});
    seen[slot / 64] |= std::uint64_t(1) << slot % 64;
  }
  std::vector<core::Slot> slots;
  culling::slots_of(seen, slots);
  const Edges& edges = config_.drawing.looks.edges;
  edges_.update(frame.snapshot, slots, frame.view, image.height(), edges, threads_);
  const core::dvec2 place = core::rook_positions(config_.drawing.samples).front();  // counted from the upper corner
  engine::draw_edges({image.width(), image.height(), pixels.colours, pixels.depths}, {place.x, 1.0 - place.y},
                     frame.view, edges_, {.width = edges.width, .colour = edges.colour}, threads_);
}

/// Ghosts lie over the image where nothing hides them, and of those only the nearest.
core::Expected<void> TracedDrawing::draw_ghosts(const Frame& frame) {
  if (overrides_.ghosts().empty()) return {};
  auto done = draw_items(frame, all_but(overrides_.ghosts()), layer_, true);
  if (!done) return done;
  const auto image = image_->pixels.pixels(), ghosts = layer_.pixels();
  for (std::size_t i = 0; i < image.colours.size(); ++i)
    if (ghosts.depths[i] > image.depths[i]) image.colours[i] = over(ghosts.colours[i], image.colours[i]);
  return {};
}

/// A line around outlined items: twin of render/shaders/outline.frag with one sample per pixel.
core::Expected<void> TracedDrawing::draw_outline(const Frame& frame) {
  if (overrides_.outlined().empty()) return {};
  if (auto done = draw_items(frame, all_but(overrides_.outlined()), layer_, true); !done) return done;
  constexpr int kReach = 2;
  constexpr float kOccludedLine = 0.35f, kSameDepth = 1e-4f;
  const auto image = image_->pixels.pixels(), items = layer_.pixels();
  const int width = image_->width, height = image_->height;
  const core::vec3 colour = config_.drawing.outline_colour;
  const auto at = [&](int x, int y) { return std::size_t(y) * std::size_t(width) + std::size_t(x); };
  const auto alpha_at = [&](int x, int y) {
    float alpha = 0.0f;
    for (int v = std::max(0, y - kReach); v <= std::min(height - 1, y + kReach); ++v)
      for (int u = std::max(0, x - kReach); u <= std::min(width - 1, x + kReach); ++u) {
        const float depth = items.depths[at(u, v)];
        if (depth == 0.0f || (u - x) * (u - x) + (v - y) * (v - y) > kReach * kReach + 1) continue;
        alpha = std::max(alpha, depth >= image.depths[at(u, v)] * (1.0f - kSameDepth) ? 1.0f : kOccludedLine);
      }
    return alpha;
  };
  threads_.run(std::uint32_t(height), [&](std::uint32_t row) {
    for (int x = 0, y = int(row); x < width; ++x) {
      const float alpha = items.depths[at(x, y)] > 0.0f ? 0.0f : alpha_at(x, y);
      std::uint32_t& pixel = image.colours[at(x, y)];
      if (alpha > 0.0f) pixel = over(raytrace::packed_colour(colour * alpha, alpha), pixel);
    }
  });
  return {};
}

// --- reading ---------------------------------------------------------------------------------------------------------

/// Fails before the first frame of an image's size.
core::Expected<void> TracedDrawing::check_drawn() const {
  const bool drawn = image_->pixels.width() == image_->width && image_->pixels.height() == image_->height;
  return drawn ? core::Expected<void>() : core::fail("image: no frame was drawn yet");
}

core::Expected<image::Image> TracedDrawing::read_colour() {
  if (auto drawn = check_drawn(); !drawn) return tl::unexpected(drawn.error());
  const StillImage::Pixels pixels = image_->pixels.pixels();
  image::Image read{image_->width, image_->height, {}};
  read.pixels.reserve(3 * pixels.colours.size());
  for_each_row_down(image_->pixels, pixels.colours, [&](std::span<const std::uint32_t> row) {
    for (const std::uint32_t colour : row)
      for (const int shift : {0, 8, 16}) read.pixels.push_back(std::uint8_t(colour >> shift));
  });
  return read;
}

core::Expected<image::IdImage> TracedDrawing::read_ids() {
  if (auto drawn = check_drawn(); !drawn) return tl::unexpected(drawn.error());
  image::IdImage read{image_->width, image_->height, {}};
  for_each_row_down(image_->pixels, image_->pixels.pixels().ids, [&](std::span<const std::uint32_t> row) {
    read.ids.insert(read.ids.end(), row.begin(), row.end());
  });
  return read;
}

core::Expected<image::DepthImage> TracedDrawing::read_depth(const core::View* view) {
  if (auto drawn = check_drawn(); !drawn) return tl::unexpected(drawn.error());
  image::DepthImage read{image_->width, image_->height, {}};
  for_each_row_down(image_->pixels, image_->pixels.pixels().depths,
                    [&](std::span<const float> row) { read.metres.insert(read.metres.end(), row.begin(), row.end()); });
  if (view) gpuprims::to_distances(*view, read.metres);
  return read;
}

BackendReport TracedDrawing::report() const {
  BackendReport report;
  report.renderer = std::string("rays (") + core::name_of(core::instruction_set()) + ", " +
                    std::to_string(threads_.size()) + (threads_.size() == 1 ? " thread)" : " threads)");
  report.why_rays = why_;
  for (const auto& [number, image] : images_) report.points_bytes += image.pixels.memory_bytes();
  report.points_bytes += layer_.memory_bytes();
  return report;
}

}  // namespace sightline::engine
