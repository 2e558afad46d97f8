// Images of single items of a scene, and every pixel of them against the reference (pixel_reference.h).
//
// What is drawn is known to a small part of a pixel: rasterisers round corners to 1/256 pixel, and rays that are cast
// in float pass a solid at 1e-6 of its size beside the reference's. So five reference rays are cast for each pixel,
// through its centre and kReach aside of it to four sides:
//   - all five hit, or all miss: so does the image. Where they differ (a silhouette) it may do either
//   - the item is that of one of the rays
//   - where all five hit and their normals agree within kSmooth, the depth lies between theirs, and the normal is that
//     of the ray through the centre, within the tolerance
//   - where all five hit but differ (at an edge, or where a surface turns away), the normal is near that of one of
//     them, and the depth as near to theirs as they are to each other
//   - where some miss, the item is all that counts
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/snapshot.h"
#include "sightline/render/internal/renderer.h"
#include "sightline/tests/render/pixel_reference.h"

namespace sightline::tests {

struct Image {
  core::View view;
  image::Image colour;
  image::DepthImage depth;
  image::IdImage ids;
  image::NormalImage normals;  ///< may be empty: then nothing is said of them
};

/// Draws items of a scene, with ids and normals.
class Camera {
 public:
  Camera(const gl::Context& context, core::Scene& scene, int width, int height, int samples = 1) {
    EXPECT_TRUE(scene.commit());
    snapshot_.emplace(scene);
    gpu_ = std::move(*gpuscene::GpuScene::create(context, *snapshot_));
    lists_ = std::move(*gpuscene::DrawLists::create(context, *gpu_));
    const render::TargetFormat form{true, true, samples};
    auto renderer = render::Renderer::create(context, *gpu_, form);
    EXPECT_TRUE(renderer) << renderer.error().message;
    renderer_ = std::move(*renderer);
    target_ = std::move(*render::RenderTarget::create(context, width, height, form));
  }

  const render::RenderTarget& target() const { return *target_; }
  const core::vec3& background() const { return renderer_->background.top; }
  render::Renderer& renderer() { return *renderer_; }

  Image draw(const core::View& view, std::span<const Shape> shapes) {
    core::VisibleSet visible;
    visible.generation = snapshot_->generation();
    for (const Shape& shape : shapes) visible.single_slots.push_back(snapshot_->slot(shape.item));
    std::sort(visible.single_slots.begin(), visible.single_slots.end());
    EXPECT_TRUE(lists_->update(*snapshot_, *gpu_, visible));
    EXPECT_TRUE(renderer_->draw(view, *snapshot_, *gpu_, *lists_, *target_));
    return {view, target_->read_colour(), target_->read_depth(view), target_->read_ids(), target_->read_normals()};
  }

 private:
  std::optional<core::Snapshot> snapshot_;
  std::optional<gpuscene::GpuScene> gpu_;
  std::optional<gpuscene::DrawLists> lists_;
  std::optional<render::Renderer> renderer_;
  std::optional<render::RenderTarget> target_;
};

struct Tolerance {
  double depth;    ///< of the depth, or of 1 m if that is more
  double degrees;  ///< of normals
  int pixels = 0;  ///< of an image, that may be wrong: where a rasteriser moves a corner of a small triangle
};

/// How much of an image could be compared.
struct Compared {
  int clear = 0, edges = 0, silhouettes = 0, cut = 0;  ///< pixels that show something, clear ones on cut faces
};

/// What is wrong with a pixel; empty: nothing.
inline std::string complaint(const Image& image, std::size_t pixel, const PixelHits& around,
                             const Tolerance& tolerance) {
  std::ostringstream text;
  const double depth = image.depth.metres[pixel];
  const std::uint32_t id = image.ids.ids[pixel];
  const bool with_normals = !image.normals.normals.empty();
  const auto n = with_normals ? image.normals.normals[pixel] : std::array<float, 3>{};
  const dvec3 normal(n[0], n[1], n[2]);
  const bool hit = std::isfinite(depth);
  if (hit != (id != 0) || (with_normals && hit != (normal != dvec3(0.0))))
    return "depth, id and normal disagree on whether there is something";
  if (!hit) {
    if (around.hits == 5)
      text << "nothing, not item " << to_index(around.centre().items[0]) << " at " << around.centre().depth;
    return text.str();
  }
  if (around.hits == 0) {
    text << "item " << id - 1 << " at " << depth << ", not nothing";
    return text.str();
  }
  double low = std::numeric_limits<double>::infinity(), high = -low, beside = 180.0;
  bool known = false;
  core::ItemId expected{0};
  for (const RayHit& seen_hit : around.hits_around) {
    if (!seen_hit.hit()) continue;
    low = std::min(low, seen_hit.depth);
    high = std::max(high, seen_hit.depth);
    beside = std::min(beside, degrees_between(normal, seen_hit.normal));
    expected = seen_hit.items.front();
    known = known || std::count(seen_hit.items.begin(), seen_hit.items.end(), core::ItemId{id - 1}) > 0;
  }
  if (!known) text << "item " << id - 1 << ", not " << to_index(expected) << "; ";
  const double slack = tolerance.depth * std::max(1.0, std::abs(depth)) + (around.smooth ? 0.0 : high - low);
  if (around.hits == 5 && (depth < low - slack || depth > high + slack))
    text << "depth " << depth << ", not " << low << " to " << high << "; ";
  if (!with_normals) return text.str();
  if (std::abs(glm::length(normal) - 1.0) > 1e-5) text << "normal of length " << glm::length(normal) << "; ";
  if (around.smooth) {
    beside = degrees_between(normal, around.centre().normal);
    if (beside > tolerance.degrees) text << "normal " << beside << " degrees beside; ";
  } else if (around.hits == 5 && beside > kSmooth + tolerance.degrees) {
    text << "normal " << beside << " degrees beside any that is near; ";
  }
  return text.str();
}

/// Compares every pixel. `seen` has one for each, row by row.
inline Compared compare(const Image& image, std::span<const PixelHits> seen, const Tolerance& tolerance) {
  Compared compared;
  int wrong = 0;
  std::ostringstream first;
  for (std::size_t pixel = 0; pixel < seen.size(); ++pixel) {
    const PixelHits& around = seen[pixel];
    if (around.hits > 0) ++(around.smooth ? compared.clear : around.hits == 5 ? compared.edges : compared.silhouettes);
    compared.cut += around.smooth && around.centre().cut;
    const std::string text = complaint(image, pixel, around, tolerance);
    if (text.empty() || ++wrong > 4) continue;
    const int x = int(pixel) % image.ids.width, y = int(pixel) / image.ids.width;
    first << "\n  (" << x << ", " << y << "): " << text << around.hits << " of 5 rays hit";
  }
  EXPECT_LE(wrong, tolerance.pixels) << "of " << compared.clear << " clear pixels, " << compared.edges << " at edges, "
                                     << compared.silhouettes << " at silhouettes:" << first.str();
  return compared;
}

}  // namespace sightline::tests
