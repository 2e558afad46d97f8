// Boxes, occluders, and questions about boxes: what the package "sightline/culling" holds.
#include <algorithm>

#include "sightline/bindings/wasm/call.h"
#include "sightline/bindings/wasm/numbers.h"
#include "sightline/bindings/wasm/visibility.h"
#include "sightline/culling/box_culler.h"
#include "sightline/culling/frustum/internal/slot_list.h"
#include "sightline/culling/occlusion/depth_pyramid.h"
#include "sightline/culling/occlusion/occluder_raster.h"
#include "sightline/culling/occlusion/occlusion_test.h"

namespace sightline::wasm {
namespace {

/// A culler, and what its answers lie in.
struct Boxes {
  culling::BoxCuller culler;
  core::VisibleSet set = {};
  std::vector<std::uint32_t> indices = {};
  std::vector<culling::BoxHit> hits = {};
  std::vector<double> distances = {};

  /// Indices of boxes here, their distances at sl_boxes_distances().
  void answer_hits() {
    indices.clear();
    distances.clear();
    for (const auto& [index, distance] : hits) {
      indices.push_back(index);
      distances.push_back(distance);
    }
    answer(indices);
  }
};

}  // namespace

// --- boxes -----------------------------------------------------------------------------------------------------------

SIGHTLINE_EXPORT Boxes* sl_boxes_create(const double* boxes, std::uint32_t count) {
  return attempt([&]() -> core::Expected<Boxes*> {
    auto culler = culling::BoxCuller::create(boxes_at(boxes, count));
    if (!culler) return tl::unexpected(culler.error());
    return new Boxes{std::move(*culler)};
  });
}
SIGHTLINE_EXPORT void sl_boxes_destroy(Boxes* boxes) {
  delete boxes;
}

SIGHTLINE_EXPORT bool sl_boxes_visible(Boxes* boxes, const ViewObject* view, const culling::DepthPyramid* pyramid,
                                       float least_area) {
  return attempt_all([&] {
    if (least_area <= 0.0f && pyramid == nullptr) {
      boxes->culler.visible(view->view, boxes->indices);
    } else if (least_area <= 0.0f) {
      boxes->culler.visible(view->view, *pyramid, boxes->indices);
    } else {
      find_visible(boxes->culler.bounds(), boxes->culler.culler(), *view, {pyramid, least_area}, nullptr, boxes->set);
      boxes->indices.resize(boxes->set.count());  // without vacant slots, which have no size
      culling::list_ids(boxes->set, boxes->culler.indices(), boxes->indices);
    }
    answer(boxes->indices);
  });
}

/// By projection * view alone.
SIGHTLINE_EXPORT bool sl_boxes_visible_in(Boxes* boxes, const double* clip_from_world, std::uint32_t depth) {
  return attempt([&]() -> core::Expected<bool> {
    auto found = done(boxes->culler.visible(clip_from_world, core::ClipDepth(depth), boxes->indices));
    if (found) answer(boxes->indices);
    return found;
  });
}

SIGHTLINE_EXPORT bool sl_boxes_update(Boxes* boxes, const std::uint32_t* indices, const double* values,
                                      std::uint32_t count) {
  return attempt([&]() -> core::Expected<bool> {
    return done(boxes->culler.update({indices, count}, boxes_at(values, count)));
  });
}
SIGHTLINE_EXPORT bool sl_boxes_refit(Boxes* boxes, const double* values, std::uint32_t count) {
  return attempt([&]() -> core::Expected<bool> { return done(boxes->culler.refit(boxes_at(values, count))); });
}

SIGHTLINE_EXPORT bool sl_boxes_in_box(Boxes* boxes, const double* range, bool inside) {
  return attempt_all([&] {
    boxes->culler.in_box(boxes_at(range, 1)[0], inside, boxes->indices);
    answer(boxes->indices);
  });
}
SIGHTLINE_EXPORT bool sl_boxes_around(Boxes* boxes, const double* point, double radius) {
  return attempt_all([&] {
    boxes->culler.around(point_at(point), radius, boxes->indices);
    answer(boxes->indices);
  });
}
/// `ray`: origin, direction, the least and the greatest t. `most`: hits at most, front to back; 0: all.
SIGHTLINE_EXPORT bool sl_boxes_along(Boxes* boxes, const double* ray, std::uint32_t most) {
  return attempt_all([&] {
    boxes->culler.along(ray_at(ray), most == 0 ? boxes->culler.size() : most, boxes->hits);
    boxes->answer_hits();
  });
}
SIGHTLINE_EXPORT bool sl_boxes_nearest(Boxes* boxes, const double* point, std::uint32_t count) {
  return attempt_all([&] {
    boxes->culler.nearest(point_at(point), count, boxes->hits);
    boxes->answer_hits();
  });
}
/// Writes the distances of the last hits.
SIGHTLINE_EXPORT void sl_boxes_distances(Boxes* boxes) {
  answer(boxes->distances);
}

// --- depth pyramids --------------------------------------------------------------------------------------------------

SIGHTLINE_EXPORT culling::DepthPyramid* sl_pyramid_create() {
  return attempt([&]() -> core::Expected<culling::DepthPyramid*> { return new culling::DepthPyramid; });
}
SIGHTLINE_EXPORT void sl_pyramid_destroy(culling::DepthPyramid* pyramid) {
  delete pyramid;
}
SIGHTLINE_EXPORT bool sl_pyramid_build(culling::DepthPyramid* pyramid, const float* distances, std::int32_t width,
                                       std::int32_t height) {
  return attempt_all([&] { pyramid->build({distances, std::size_t(width) * std::size_t(height)}, width, height); });
}
/// hidden[i]: whether box i is hidden behind what the pyramid holds, of this view.
SIGHTLINE_EXPORT bool sl_pyramid_hides(const culling::DepthPyramid* pyramid, const ViewObject* view,
                                       const double* boxes, std::uint32_t count, std::uint8_t* hidden) {
  return attempt([&]() -> core::Expected<bool> {
    core::AabbD all;
    for (const core::AabbD& box : boxes_at(boxes, count))
      if (!box.empty()) all.grow(box);
    const core::dvec3 origin = all.empty() ? core::dvec3(0.0) : all.centre();
    const culling::OcclusionTest test(view->view, origin, view->width, view->height, *pyramid);
    for (std::uint32_t i = 0; i < count; ++i) {
      const core::AabbD& box = boxes_at(boxes, count)[i];
      hidden[i] = box.empty() || test.occluded(core::round_outwards(box, origin)) ? 1 : 0;
    }
    return true;
  });
}

// --- occluders -------------------------------------------------------------------------------------------------------

SIGHTLINE_EXPORT culling::OccluderRaster* sl_raster_create() {
  return attempt([&]() -> core::Expected<culling::OccluderRaster*> { return new culling::OccluderRaster; });
}
SIGHTLINE_EXPORT void sl_raster_destroy(culling::OccluderRaster* raster) {
  delete raster;
}
SIGHTLINE_EXPORT bool sl_raster_begin(culling::OccluderRaster* raster, const ViewObject* view) {
  return attempt([&]() -> core::Expected<bool> {
    constexpr int kMost = culling::OccluderRaster::kMostPixels;
    if (view->width < 1 || view->width > kMost || view->height < 1 || view->height > kMost)
      return core::fail("occluders: expected an image of 1 to " + std::to_string(kMost) + " pixels a side, got " +
                        std::to_string(view->width) + " x " + std::to_string(view->height));
    raster->begin(view->view, view->width, view->height);
    return true;
  });
}
/// Returns how many may hide anything.
SIGHTLINE_EXPORT std::uint32_t sl_raster_add_boxes(culling::OccluderRaster* raster, const double* boxes,
                                                   std::uint32_t count) {
  std::uint32_t added = 0;
  attempt_all([&] {
    for (const core::AabbD& box : boxes_at(boxes, count)) added += raster->add_box(box) ? 1 : 0;
  });
  return added;
}
SIGHTLINE_EXPORT std::uint32_t sl_raster_add_largest(culling::OccluderRaster* raster, const double* boxes,
                                                     std::uint32_t count, std::uint32_t most) {
  std::uint32_t added = 0;
  attempt_all([&] { added = std::uint32_t(raster->add_largest(boxes_at(boxes, count), most)); });
  return added;
}
SIGHTLINE_EXPORT bool sl_raster_add_cube(culling::OccluderRaster* raster, const double* world_from_cube) {
  bool added = false;
  attempt_all([&] { added = raster->add_cube(affine_at(world_from_cube)); });
  return added;
}
SIGHTLINE_EXPORT bool sl_raster_add_cylinder(culling::OccluderRaster* raster, const double* world_from_cylinder,
                                             std::int32_t sides) {
  bool added = false;
  attempt_all([&] { added = raster->add_cylinder(affine_at(world_from_cylinder), std::clamp(sides, 3, 16)); });
  return added;
}
SIGHTLINE_EXPORT bool sl_raster_add_mesh(culling::OccluderRaster* raster, const float* positions,
                                         std::uint32_t vertices, const std::uint32_t* indices,
                                         std::uint32_t index_count, const double* world_from_mesh) {
  return attempt([&]() -> core::Expected<bool> {
    if (index_count % 3 != 0)
      return core::fail("occluders: expected three indices a triangle, got " + std::to_string(index_count));
    for (std::uint32_t i = 0; i < index_count; ++i)
      if (indices[i] >= vertices)
        return core::fail("occluders: expected indices below " + std::to_string(vertices) + ", got " +
                          std::to_string(indices[i]));
    static_assert(sizeof(core::vec3) == 3 * sizeof(float));
    raster->add_mesh({reinterpret_cast<const core::vec3*>(positions), vertices}, {indices, index_count},
                     affine_at(world_from_mesh));
    return true;
  });
}
SIGHTLINE_EXPORT bool sl_raster_build(const culling::OccluderRaster* raster, culling::DepthPyramid* pyramid) {
  return attempt_all([&] { raster->build(*pyramid); });
}
/// Writes width * height distances in metres, row by row from the bottom up.
SIGHTLINE_EXPORT bool sl_raster_distances(const culling::OccluderRaster* raster, float* out, std::uint32_t count) {
  return attempt_all([&] { raster->distances({out, count}); });
}

}  // namespace sightline::wasm
