// Depth images of chosen occluders, and boxes behind them.
#include <algorithm>

#include "sightline/bindings/c/internal/boxes.h"

using namespace sightline;
using namespace sightline::capi;

namespace {

constexpr std::int32_t kLeastSides = 3, kMostSides = 16;

void check_image_size(std::int32_t width, std::int32_t height) {
  constexpr std::int32_t kMost = culling::OccluderRaster::kMostPixels;
  require(width >= 1 && width <= kMost && height >= 1 && height <= kMost, "a width and height of 1 to 16384 pixels");
}

/// Runs `run` with the raster while nobody else uses it. Where memory runs out, its image is gone.
template <class Run>
sl_status with_raster(const char* function, sl_occluder_raster handle, const Run& run) {
  return call(function, [&] {
    const std::shared_ptr<OccluderRasterObject> object = find(handle);
    const std::lock_guard lock(object->mutex);
    try {
      run(*object);
    } catch (const Failure&) {
      throw;
    } catch (...) {
      object->width = object->height = 0;
      throw;
    }
  });
}

/// Runs `add` with the image that begin() has made.
template <class Add>
sl_status add_occluders(const char* function, sl_occluder_raster handle, const Add& add) {
  return with_raster(function, handle, [&](OccluderRasterObject& object) {
    require(object.width > 0, "sl_occluder_raster_begin() before occluders");
    add(object.raster);
    object.built = false;
  });
}

void check_corners(const sl_mesh_data& mesh) {
  check_array(mesh.positions, mesh.vertex_count, core::kNone);
  check_array(mesh.indices, mesh.index_count, core::kNone);
  require(mesh.index_count % 3 == 0, "three indices a triangle");
  const auto below = [&](std::uint32_t index) { return index < mesh.vertex_count; };
  require(std::all_of(mesh.indices, mesh.indices + mesh.index_count, below), "indices of vertices");
}

}  // namespace

sl_status sl_occluder_raster_create(sl_occluder_raster* raster) {
  return call(__func__, [&] {
    check_result(raster);
    *raster = add_occluder_raster(std::make_shared<OccluderRasterObject>());
  });
}

sl_status sl_occluder_raster_destroy(sl_occluder_raster raster) {
  return call(__func__, [&] { (void)remove(raster); });
}

sl_status sl_occluder_raster_begin(sl_occluder_raster raster, const sl_view* view, int32_t width, int32_t height) {
  return with_raster(__func__, raster, [&](OccluderRasterObject& object) {
    check_image_size(width, height);
    const core::View seen = view_of(view);
    object.raster.begin(seen, width, height);
    object.width = width, object.height = height;
    object.built = false;
  });
}

sl_status sl_occluder_raster_add_largest(sl_occluder_raster raster, const sl_box* boxes, size_t box_count, size_t most,
                                         size_t* added) {
  return add_occluders(__func__, raster, [&](culling::OccluderRaster& to) {
    const std::size_t count = to.add_largest(boxes_of(boxes, box_count), most);
    if (added) *added = count;
  });
}

sl_status sl_occluder_raster_add_cube(sl_occluder_raster raster, const double world_from_cube[16]) {
  return add_occluders(__func__, raster,
                       [&](culling::OccluderRaster& to) { (void)to.add_cube(affine_of(world_from_cube)); });
}

sl_status sl_occluder_raster_add_cylinder(sl_occluder_raster raster, const double world_from_cylinder[16],
                                          int32_t sides) {
  return add_occluders(__func__, raster, [&](culling::OccluderRaster& to) {
    require(sides >= kLeastSides && sides <= kMostSides, "3 to 16 sides");
    (void)to.add_cylinder(affine_of(world_from_cylinder), sides);
  });
}

sl_status sl_occluder_raster_add_mesh(sl_occluder_raster raster, const sl_mesh_data* mesh,
                                      const double world_from_mesh[16]) {
  return add_occluders(__func__, raster, [&](culling::OccluderRaster& to) {
    const sl_mesh_data from = read(mesh, sl_mesh_data SL_MESH_DATA_INIT);
    check_corners(from);
    const auto* corners = reinterpret_cast<const core::vec3*>(from.positions);
    to.add_mesh({corners, from.vertex_count}, {from.indices, std::size_t(from.index_count)},
                affine_of(world_from_mesh));
  });
}

sl_status sl_occluder_raster_read(sl_occluder_raster raster, float* metres, size_t capacity) {
  return with_raster(__func__, raster, [&](const OccluderRasterObject& object) {
    const std::size_t size = std::size_t(object.width) * std::size_t(object.height);
    require(size > 0, "sl_occluder_raster_begin() before reading");
    require(metres != nullptr && capacity >= size, "room for all pixels");
    object.raster.distances({metres, size});
  });
}

sl_status sl_box_culler_visible_behind(sl_box_culler culler, const sl_view* view, sl_occluder_raster raster,
                                       uint32_t* indices, size_t capacity, size_t* count) {
  sl_status status = SL_OK;
  const sl_status found = with_raster(__func__, raster, [&](OccluderRasterObject& object) {
    require(object.width > 0, "sl_occluder_raster_begin() before culling");
    if (!object.built) object.raster.build(object.pyramid);
    object.built = true;
    status = list_visible("sl_box_culler_visible_behind", culler, indices, capacity, count,
                          [&](const culling::BoxCuller& boxes, std::vector<std::uint32_t>& visible) {
                            boxes.visible(view_of(view), object.pyramid, visible);
                          });
  });
  return found == SL_OK ? status : found;
}

sl_status sl_box_culler_visible_in_depth(sl_box_culler culler, const sl_view* view, const float* metres, int32_t width,
                                         int32_t height, uint32_t* indices, size_t capacity, size_t* count) {
  return list_visible(__func__, culler, indices, capacity, count,
                      [&](const culling::BoxCuller& boxes, std::vector<std::uint32_t>& visible) {
                        check_image_size(width, height);
                        require(metres != nullptr, "metres, found null");
                        culling::DepthPyramid pyramid;
                        pyramid.build({metres, std::size_t(width) * std::size_t(height)}, width, height);
                        boxes.visible(view_of(view), pyramid, visible);
                      });
}
