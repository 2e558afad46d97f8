// Random items of one kind side by side in front of a camera, and the rays of the camera's samples at them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/apps/bench/error_time/samples.h"
#include "sightline/core/scene.h"
#include "sightline/core/view.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::bench {

/// Nine kinds: all but lines, facet groups and meshes.
std::span<const core::Kind> measured_kinds();

/// Items of one size: `columns` x `rows` of them in each of `images` images, none in front of another.
struct FieldSize {
  double pixels;  ///< diameter of an item's bounding ball
  int columns, rows, images;
};

struct FieldItem {
  core::Primitive primitive;
  core::Affine world_from_item;
  core::dvec3 centre{0.0};  ///< of a ball around it, in the world; its diameter is 1
};

struct Field {
  core::View view;
  std::vector<FieldItem> items;
  int columns = 1, rows = 1;

  /// The scene is not committed.
  core::Scene scene() const;
};

/// One image of `size`, with the given width and height in pixels. The same seed gives the same image.
Field make_field(core::Kind kind, const FieldSize& size, int width, int height, std::uint32_t seed);

/// Rays through the centres of samples, in an item's own coordinates; t is the distance along the view axis.
struct ItemRays {
  std::vector<core::Ray> rays;
  std::vector<std::uint32_t> samples;  ///< of each ray: y * width + x
};

/// For each item, the rays that may meet its ball in an image of width x height samples.
std::vector<ItemRays> field_rays(const Field& field, int width, int height);

/// Casts rays with gpuprims::intersect. `first_row`: row of `image` where the field's image begins.
void cast(const Field& field, const std::vector<ItemRays>& rays, int first_row, SampleImage& image);

}  // namespace sightline::bench
