#include "sightline/raytrace/internal/moving_image.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>

#include "sightline/core/image_rays.h"
#include "sightline/core/internal/clock.h"
#include "sightline/raytrace/internal/packed_colour.h"
#include "sightline/raytrace/internal/surface.h"

namespace sightline::raytrace {
namespace {

using core::vec3;
using core::View;

constexpr std::size_t kPixels = PointImage::kPixels;
constexpr std::size_t kOfThread = 8;    // blocks that a thread traces after each other
constexpr double kShare = 0.9;          // of the time left, for blocks that are traced together
constexpr double kFirstRate = 4e5;      // rays a second and thread, before any is measured
constexpr std::int64_t kFewRays = 512;  // say little of how long others take

constexpr std::uint32_t kEmpty = 65 * kPixels;  // urgency of blocks that miss nearly all of their pixels
// The sky counts as so much younger than it is, until it has the age after which it is traced again. That is spread by
// as many views, so that not all of it becomes urgent at once.
constexpr std::uint32_t kSkyStays = 8, kOldSky = 32;
constexpr double kManyEmpty = 0.25;                // of the rays for which there is time
constexpr std::uint32_t kCoarsest = 1, kHalf = 4;  // of sixteen pixels, every fourth and every second along either axis
constexpr std::uint32_t kAll = 16;
constexpr std::size_t kLeast = 24;  // of so many blocks one is traced in any case

/// By what a block misses and the ages of its points. Blocks on the image's border, which have fewer pixels, are as
/// urgent as others. Where surfaces end before the background, thin things are missed: such blocks are by half more so.
std::uint32_t urgency_of(const PointBlock& sum) {
  if (32 * sum.missing > 31 * sum.pixels) return kEmpty;
  const std::uint32_t waited = (sum.waited * std::uint32_t(kPixels) + sum.pixels - 1) / sum.pixels;
  return std::min(kEmpty - 1, sum.surface && sum.background ? waited * 3 / 2 : waited);
}

std::uint32_t urgency_of_sky(std::uint32_t urgency, std::size_t block) {
  const std::uint32_t old = (kOldSky + std::uint32_t(block * 0x9e3779b9u) % kOldSky) * std::uint32_t(kPixels);
  return urgency < old ? (urgency + kSkyStays - 1) / kSkyStays : kOldSky * std::uint32_t(kPixels);
}

/// Whether two views see the same of each item that both look at.
bool same_cuts(const View& a, const View& b) {
  View cut = b;
  cut.sections = a.sections;
  cut.section_mode = a.section_mode;
  cut.layers = a.layers;
  return core::same_image(cut, b);
}

}  // namespace

/// All rays of an image share this.
struct MovingImage::Shot {
  const SceneRays& scene;
  const core::ImageRays& rays;
  Lit lit;
  const gpuprims::Background& background;

  /// Rows are counted from the bottom up.
  core::Ray through(int x, int y, int height) const { return rays.through(x + 0.5, height - (y + 0.5)); }
};

core::Expected<MovingImage::Counts> MovingImage::draw(const ImageRequest& request, core::ThreadPool& threads,
                                                      double deadline) {
  const core::View& view = request.view;
  const int width = request.width, height = request.height;
  const auto rays = core::ImageRays::create(view, width, height);
  if (!rays) return tl::unexpected(rays.error());
  if (!view_ || width != points_.width() || height != points_.height() || !same_cuts(*view_, view))
    points_.reset(width, height, view);
  else if (!core::same_image(*view_, view))
    points_.follow(view, request.background, threads);
  view_ = view;
  const SceneRays scene_rays(request.scene, view, *rays, height);
  const Shot shot{scene_rays, *rays, Lit(request), request.background};
  trace_most_urgent(shot, threads, deadline - finish_seconds_);
  const double traced = core::now_seconds();
  const PointBlock all = points_.fill(request.background, threads);
  finish_seconds_ = core::now_seconds() - traced;
  const std::int64_t kept = std::int64_t(all.own) - all.found - all.assumed;
  return Counts{all.found, kept, std::int64_t(all.pixels) - all.found - kept};
}

/// How urgent blocks are: by what they miss and the ages of their points. Where neither a block nor any beside it shows
/// a surface, the sky most likely stays.
void MovingImage::find_urgency(core::ThreadPool& threads) {
  const int columns = points_.columns(), rows = points_.rows();
  const std::size_t blocks = std::size_t(columns) * std::size_t(rows);
  urgency_.resize(blocks);
  surfaces_.resize(blocks);
  threads.run(std::uint32_t(rows), [&](std::uint32_t row) {
    for (int column = 0; column < columns; ++column) {
      const std::size_t block = std::size_t(row) * std::size_t(columns) + std::size_t(column);
      const PointBlock sum = points_.block(column, int(row));
      urgency_[block] = urgency_of(sum);
      surfaces_[block] = sum.surface;
    }
  });
  for (std::size_t block = 0; block < blocks; ++block)
    if (urgency_[block] != kEmpty && none_around(surfaces_, columns, block))
      urgency_[block] = urgency_of_sky(urgency_[block], block);
}

/// Where the few points of blocks, and of those beside them, are all of the sky, the other pixels most likely show it.
void MovingImage::assume_sky(const Shot& shot, std::span<const std::uint32_t> blocks, core::ThreadPool& threads) {
  const auto columns = std::uint32_t(points_.columns());
  threads.run(std::uint32_t(blocks.size()), [&](std::uint32_t i) {
    if (!none_around(surfaces_, points_.columns(), blocks[i])) return;
    points_.for_each(int(blocks[i] % columns), int(blocks[i] / columns), [&](std::size_t pixel, int x, int y) {
      if (points_.ages()[pixel] != PointAge::kNoPoint) return;
      points_.set_background(x, y, shot.background, PointAge::kAssumed);
    });
  });
}

/// Orders the blocks that are not new, the most urgent first.
void MovingImage::order_blocks() {
  order_.clear();
  for (std::uint32_t block = 0; block < urgency_.size(); ++block)
    if (urgency_[block] > 0) order_.push_back(block);
  std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return urgency_[a] != urgency_[b] ? urgency_[a] > urgency_[b] : a < b;
  });
}

/// Blocks are traced whole, since rays that are neighbours take a fraction of the time. Where many are empty, as in a
/// first image or on the border of one that turns, all of these get some points before: most may show the sky. However
/// little time there is, the image gets some new points.
void MovingImage::trace_most_urgent(const Shot& shot, core::ThreadPool& threads, double deadline) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const auto rays_in_time = [&](double rate) {
    const double seconds = std::max(0.0, deadline - core::now_seconds());
    return (rate > 0.0 ? rate : kFirstRate * threads.size()) * seconds;
  };
  find_urgency(threads);
  order_blocks();
  std::size_t empty = 0;
  while (empty < order_.size() && urgency_[order_[empty]] == kEmpty) ++empty;
  std::size_t least = urgency_.size() / kLeast + 1;
  if (const double pixels = double(empty * kPixels); pixels > kManyEmpty * rays_in_time(whole_rate_)) {
    const std::uint32_t places = pixels * kHalf / kAll <= rays_in_time(sparse_rate_) ? kHalf : kCoarsest;
    const auto blocks = std::span(order_).first(empty);
    if (trace(shot, blocks, places, threads, kNever, sparse_rate_) > 0) least = (urgency_.size() - empty) / kLeast;
    find_urgency(threads);
    assume_sky(shot, blocks, threads);
    order_blocks();
  }
  std::span<std::uint32_t> blocks(order_);
  while (!blocks.empty() && (least > 0 || core::now_seconds() < deadline)) {
    const auto in_time = std::size_t(kShare * rays_in_time(whole_rate_) / kPixels);
    const std::size_t count = std::min(blocks.size(), std::max({least, in_time, std::size_t(threads.size())}));
    trace(shot, blocks.first(count), kAll, threads, least >= count ? kNever : deadline, whole_rate_);
    blocks = blocks.subspan(count);
    least = 0;
  }
}

/// Traces so many of sixteen pixels of these blocks until the deadline, neighbours after each other: they meet the same
/// items, which then are in the caches. `rate`: rays a second, measured. Returns the number of rays.
std::int64_t MovingImage::trace(const Shot& shot, std::span<std::uint32_t> blocks, std::uint32_t places,
                                core::ThreadPool& threads, double deadline, double& rate) {
  const double begin = core::now_seconds();
  std::sort(blocks.begin(), blocks.end());
  std::atomic<std::int64_t> traced = 0;
  const auto jobs = std::uint32_t((blocks.size() + kOfThread - 1) / kOfThread);
  threads.run_at_once(jobs, [&](std::uint32_t job) {
    for (std::size_t i = job * kOfThread; i < std::min(blocks.size(), (job + 1) * kOfThread); ++i)
      if (core::now_seconds() < deadline) traced += trace_block(shot, blocks[i], places);
  });
  const double seconds = core::now_seconds() - begin;
  const double now = seconds > 0.0 ? double(traced) / seconds : 0.0;
  if (traced >= kFewRays && now > 0.0) rate = rate > 0.0 ? 0.5 * (rate + now) : now;
  return traced;
}

std::int64_t MovingImage::trace_block(const Shot& shot, std::uint32_t block, std::uint32_t places) {
  std::array<std::uint32_t, kPixels> pixels;
  std::size_t count = 0;
  const int columns = points_.columns(), column = int(block) % columns, row = int(block) / columns;
  points_.for_each(column, row, [&](std::size_t pixel, int x, int y) {
    if (points_.ages()[pixel] != PointAge::kNew && place_of(std::uint32_t(x), std::uint32_t(y)) < places)
      pixels[count++] = std::uint32_t(pixel);
  });
  constexpr int kSide = PointImage::kBlock;
  shoot(shot, {column * kSide, row * kSide, (column + 1) * kSide, (row + 1) * kSide}, {pixels.data(), count});
  return std::int64_t(count);
}

/// Traces pixels of a block.
void MovingImage::shoot(const Shot& shot, const PixelRange& block, std::span<const std::uint32_t> pixels) {
  static_assert(kPixels <= SceneRays::kMostRays);
  std::array<core::Ray, kPixels> traced;
  std::array<SceneRays::PartHit, kPixels> found;
  const auto width = std::uint32_t(points_.width());
  for (std::size_t i = 0; i < pixels.size(); ++i)
    traced[i] = shot.through(int(pixels[i] % width), int(pixels[i] / width), points_.height());
  const std::span<const core::Ray> rays(traced.data(), pixels.size());
  const std::span<SceneRays::PartHit> hits(found.data(), pixels.size());
  shot.scene.nearest(rays, block, hits);
  if (!shot.scene.all_opaque())
    for (std::size_t i = 0; i < pixels.size(); ++i)
      pass_dithered(shot.scene, rays[i], {pixels[i] % width, pixels[i] / width}, hits[i]);
  for (std::size_t i = 0; i < pixels.size(); ++i) show(shot, rays[i], hits[i], pixels[i]);
}

/// Lets a pixel show what its ray hits.
void MovingImage::show(const Shot& shot, const core::Ray& ray, const SceneRays::PartHit& found, std::uint32_t pixel) {
  const auto width = std::uint32_t(points_.width());
  const auto& [hit, snapshot] = found;
  if (hit.slot == core::kNone) return points_.set_background(int(pixel % width), int(pixel / width), shot.background);
  const vec3 to_viewer(-ray.direction);
  if (!snapshot) {
    const TracedBoxes& boxes = shot.scene.boxes();
    const glm::vec4 material(vec3(colour_of(boxes.colours[hit.slot])), 1.0f);
    return points_.set(pixel, hit.point, boxes.first_id + hit.slot + 1,
                       packed_colour(shot.lit.colour(vec3(hit.normal), to_viewer, material)));
  }
  const vec3 normal(shading_normal(*snapshot, hit, ray.direction));
  const vec3 colour = shot.lit.colour(normal, to_viewer, material_of(*snapshot, hit.slot));
  points_.set(pixel, hit.point, to_index(hit.item) + 1, packed_colour(colour));
}

}  // namespace sightline::raytrace
