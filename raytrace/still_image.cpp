#include "sightline/raytrace/internal/still_image.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/core/image_rays.h"
#include "sightline/core/internal/scratch.h"
#include "sightline/gpuprims/internal/view_block.h"
#include "sightline/raytrace/internal/packed_colour.h"
#include "sightline/raytrace/internal/surface.h"

namespace sightline::raytrace {
namespace {

using core::dvec2;
using core::dvec3;
using core::dvec4;
using core::vec3;

constexpr int kTileSide = 16;   // pixels along either side, whose rays a thread traces together
constexpr int kSquareSide = 4;  // and of these, along either side, those that follow each other
static_assert(kTileSide * kTileSide <= int(SceneRays::kMostRays));

/// The part of a line between two points that is in the view volume, from `begin` to `end` of its length; none where
/// begin > end. The ends are in clip space of reversed depth.
struct SeenPart {
  SeenPart(const dvec4& from, const dvec4& to) {
    for (const dvec4& form : {dvec4(0, 0, -1, 1), dvec4(0, 0, 1, 0), dvec4(1, 0, 0, 1), dvec4(-1, 0, 0, 1),
                              dvec4(0, 1, 0, 1), dvec4(0, -1, 0, 1)}) {
      const double a = glm::dot(form, from), b = glm::dot(form, to);
      if (a < 0.0 && b < 0.0) end = -1.0;
      if (a < 0.0 && b >= 0.0) begin = std::max(begin, a / (a - b));
      if (b < 0.0 && a >= 0.0) end = std::min(end, a / (a - b));
    }
  }
  double begin = 0.0, end = 1.0;
};

/// Calls visit(x, y, share of the way) for the pixels whose middle column, or row of a steeper line, a line passes.
template <class Visit>
void for_each_pixel(const dvec2& from, const dvec2& to, const Visit& visit) {
  const dvec2 way = to - from;
  const int along = std::abs(way.x) >= std::abs(way.y) ? 0 : 1;
  if (way[along] == 0.0) return;
  const double low = std::min(from[along], to[along]), high = std::max(from[along], to[along]);
  for (int i = int(std::ceil(low - 0.5)); i + 0.5 < high; ++i) {
    const double share = (i + 0.5 - from[along]) / way[along];
    const int across = int(std::floor(from[1 - along] + share * way[1 - along]));
    visit(along == 0 ? i : across, along == 0 ? across : i, share);
  }
}

std::array<dvec3, 2> ends_of(const core::Snapshot& snapshot, core::Slot slot) {
  const core::Affine world_from_item = snapshot.world_from_item(slot);
  const auto line = std::get<core::Line>(snapshot.primitive(slot));
  const auto at = [&](float x) { return world_from_item.origin + double(x) * world_from_item.linear[0]; };
  return {at(line.from), at(line.to)};
}

/// Whether sections keep a point. A plane with zero normal is ignored.
bool keeps(const core::View& view, const dvec3& point) {
  const bool all = view.section_mode == core::SectionMode::kIntersection;
  bool any = false;
  for (const core::Plane& plane : view.sections) {
    if (plane.normal == dvec3(0.0)) continue;
    any = true;
    if ((core::evaluate(plane, point) >= 0.0) != all) return !all;
  }
  return all || !any;
}

}  // namespace

/// All pixels of one sample share this.
struct StillImage::Shot {
  const ImageRequest& request;
  const SceneRays& scene;
  const core::ImageRays& rays;
  const Lit& lit;
  core::dmat4 clip_from_world;  // of reversed depth
  dvec2 offset;                 // of the sample from the middle of its pixel, pixels to the right and down

  core::Ray through(int x, int y) const {
    return rays.through(x + 0.5 + offset.x, request.height - (y + 0.5) + offset.y);
  }
  std::uint32_t colour(const vec3& normal, const vec3& to_viewer, const glm::vec4& material) const {
    const vec3 lit_colour = lit.colour(normal, to_viewer, material);
    if (!request.ghosts) return packed_colour(lit_colour);
    const float head = glm::dot(normal, to_viewer), shown = ghost_alpha(material.a, head);
    return packed_colour(lit_colour * (head * shown), shown);  // darker edge-on, so that it shows on any background
  }
  std::uint32_t background(int row) const {
    return request.ghosts ? 0 : background_of(request.background, row, request.height);
  }
};

core::Expected<void> StillImage::draw(const ImageRequest& request, const TracedLines& lines, int samples,
                                      core::ThreadPool& threads) {
  const auto rays = core::ImageRays::create(request.view, request.width, request.height);
  if (!rays) return tl::unexpected(rays.error());
  width_ = request.width, height_ = request.height;
  const std::size_t pixels = std::size_t(width_) * std::size_t(height_);
  colours_.resize(pixels);
  depths_.resize(pixels);
  ids_.resize(pixels);
  if (samples > 1) sums_.assign(pixels, {});
  const SceneRays scene(request.scene, request.view, *rays, height_);
  const Lit lit(request);
  const std::vector<dvec2> places = core::rook_positions(samples);
  for (int sample = 0; sample < samples; ++sample) {
    const Shot shot{request,
                    scene,
                    *rays,
                    lit,
                    gpuprims::reversed_clip_from_eye(request.view) * request.view.eye_from_world(),
                    places[std::size_t(sample)] - 0.5};
    trace(shot, threads);
    for (const core::Slot slot : lines.slots) draw_line(shot, *lines.snapshot, slot);
    if (samples > 1) add(sample, samples);
  }
  return {};
}

void StillImage::trace(const Shot& shot, core::ThreadPool& threads) {
  const int columns = (width_ + kTileSide - 1) / kTileSide, rows = (height_ + kTileSide - 1) / kTileSide;
  threads.run(std::uint32_t(columns * rows), [&](std::uint32_t tile) { trace_tile(shot, tile); });
}

void StillImage::trace_tile(const Shot& shot, std::uint32_t tile) {
  const int columns = (width_ + kTileSide - 1) / kTileSide;
  const int left = int(tile) % columns * kTileSide, bottom = int(tile) / columns * kTileSide;
  std::array<std::uint32_t, kTileSide * kTileSide> pixels;
  std::array<core::Ray, kTileSide * kTileSide> traced;
  std::array<SceneRays::PartHit, kTileSide * kTileSide> found;
  std::size_t count = 0;
  for (int i = 0; i < kTileSide * kTileSide; ++i) {
    constexpr int kOfSquare = kSquareSide * kSquareSide, kSquares = kTileSide / kSquareSide;
    const int square = i / kOfSquare, place = i % kOfSquare;
    const int x = left + square % kSquares * kSquareSide + place % kSquareSide;
    const int y = bottom + square / kSquares * kSquareSide + place / kSquareSide;
    if (x >= width_ || y >= height_) continue;
    traced[count] = shot.through(x, y);
    pixels[count++] = std::uint32_t(y) * std::uint32_t(width_) + std::uint32_t(x);
  }
  const std::span<const core::Ray> rays(traced.data(), count);
  const std::span<SceneRays::PartHit> hits(found.data(), count);
  shot.scene.nearest(rays, {left, bottom, left + kTileSide, bottom + kTileSide}, hits);
  const auto width = std::uint32_t(width_);
  const bool dithers = !shot.request.ghosts && !shot.scene.all_opaque();
  for (std::size_t i = 0; i < count; ++i) {
    if (dithers) pass_dithered(shot.scene, rays[i], {pixels[i] % width, pixels[i] / width}, hits[i]);
    show(shot, rays[i], hits[i], pixels[i]);
  }
}

void StillImage::show(const Shot& shot, const core::Ray& ray, const SceneRays::PartHit& found, std::uint32_t pixel) {
  const auto& [hit, snapshot] = found;
  if (hit.slot == core::kNone) {
    colours_[pixel] = shot.background(int(pixel) / width_);
    depths_[pixel] = 0.0f;
    ids_[pixel] = 0;
    return;
  }
  const dvec4 at = shot.clip_from_world * dvec4(hit.point, 1.0);
  const vec3 normal(shading_normal(*snapshot, hit, ray.direction)), to_viewer(-ray.direction);
  colours_[pixel] = shot.colour(normal, to_viewer, material_of(*snapshot, hit.slot));
  depths_[pixel] = float(at.z / at.w);
  ids_[pixel] = to_index(hit.item) + 1;
}

/// Nearer pixels hide a line, as a rasteriser's depth test has it.
void StillImage::draw_line(const Shot& shot, const core::Snapshot& snapshot, core::Slot slot) {
  const core::View& view = shot.request.view;
  const auto ends = ends_of(snapshot, slot);
  const dvec4 from = shot.clip_from_world * dvec4(ends[0], 1.0), to = shot.clip_from_world * dvec4(ends[1], 1.0);
  const SeenPart part(from, to);
  const dvec4 a = glm::mix(from, to, part.begin), b = glm::mix(from, to, part.end);
  if (part.begin > part.end || !(a.w > 0.0 && b.w > 0.0)) return;
  const auto place = [&](const dvec4& at) {
    return (dvec2(at) / at.w * 0.5 + 0.5) * dvec2(width_, height_) + dvec2(-shot.offset.x, shot.offset.y);
  };
  const glm::vec4 material = material_of(snapshot, slot);
  const std::uint32_t id = to_index(snapshot.item(slot));
  const vec3 towards(glm::transpose(core::dmat3(view.eye_from_world())) * dvec3(0.0, 0.0, 1.0));
  for_each_pixel(place(a), place(b), [&](int x, int y, double share) {
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
    const std::size_t pixel = std::size_t(y) * std::size_t(width_) + std::size_t(x);
    const double depth = glm::mix(a.z / a.w, b.z / b.w, share);
    const double of_part = share / b.w / ((1.0 - share) / a.w + share / b.w);  // in perspective
    const dvec3 point = glm::mix(ends[0], ends[1], glm::mix(part.begin, part.end, of_part));
    if (!(float(depth) > depths_[pixel]) || !keeps(view, point)) return;
    if (!shot.request.ghosts && dithered_away(material.a, std::uint32_t(x), std::uint32_t(y), id)) return;
    colours_[pixel] = shot.colour(towards, vec3(-shot.through(x, y).direction), material);
    depths_[pixel] = float(depth);
    ids_[pixel] = id + 1;
  });
}

/// Adds a sample to the mean of the colours, and ends that with the last one.
void StillImage::add(int sample, int samples) {
  for (std::size_t i = 0; i < colours_.size(); ++i) {
    Sums& sum = sums_[i];
    sum.r = std::uint16_t(sum.r + (colours_[i] & 255u));
    sum.g = std::uint16_t(sum.g + (colours_[i] >> 8 & 255u));
    sum.b = std::uint16_t(sum.b + (colours_[i] >> 16 & 255u));
    sum.a = std::uint16_t(sum.a + (colours_[i] >> 24));
  }
  if (sample == 0) first_depths_ = depths_, first_ids_ = ids_;
  if (sample + 1 < samples) return;
  const auto mean = [&](std::uint16_t sum) { return std::uint32_t((sum + samples / 2) / samples); };
  for (std::size_t i = 0; i < colours_.size(); ++i)
    colours_[i] = mean(sums_[i].r) | mean(sums_[i].g) << 8 | mean(sums_[i].b) << 16 | mean(sums_[i].a) << 24;
  depths_.swap(first_depths_);
  ids_.swap(first_ids_);
}

std::size_t StillImage::memory_bytes() const {
  return core::bytes_of(colours_, ids_, first_ids_, depths_, first_depths_, sums_);
}

}  // namespace sightline::raytrace
