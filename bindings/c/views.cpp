// Views, and culling without a scene.
#include <algorithm>
#include <mutex>
#include <span>
#include <vector>

#include <glm/gtc/type_ptr.hpp>

#include "sightline/bindings/c/internal/boxes.h"
#if SIGHTLINE_HAS_IMPORTERS
#include "sightline/importers/view_json.h"
#endif

using namespace sightline;
using namespace sightline::capi;

namespace {

void write_view(const core::View& from, sl_view* view) {
  sl_view made SL_VIEW_INIT;
  made.layers = from.layers;
  std::memcpy(made.eye_from_world, glm::value_ptr(from.eye_from_world()), sizeof made.eye_from_world);
  std::memcpy(made.clip_from_eye, glm::value_ptr(from.clip_from_eye()), sizeof made.clip_from_eye);
  made.clip_depth = sl_clip_depth(from.clip_depth());
  made.section_mode = std::int32_t(from.section_mode);
  require(from.sections.size() <= SL_MAX_SECTIONS, "at most SL_MAX_SECTIONS sections");
  made.section_count = from.sections.size();
  for (std::size_t i = 0; i < from.sections.size(); ++i) {
    const core::Plane& plane = from.sections[i];
    made.sections[i] = {{plane.normal.x, plane.normal.y, plane.normal.z}, plane.offset};
  }
  write(view, made);
}

/// Runs `make`, which returns an Expected<View>, and writes the result.
template <class Make>
sl_status make_view(const char* function, sl_view* view, const Make& make) {
  return call(function, [&] {
    check_result(view);
    write_view(value_of(make()), view);
  });
}

core::Pose pose_of(const sl_pose* pose) {
  require(pose != nullptr, "a pose, found null");
  return {vector_of(pose->eye), vector_of(pose->target), vector_of(pose->up)};
}

}  // namespace

// --- views -----------------------------------------------------------------------------------------------------------

sl_status sl_view_perspective(const sl_pose* pose, double fovy, double aspect, double z_near, double z_far,
                              sl_view* view) {
  return make_view(__func__, view, [&] { return core::View::perspective(pose_of(pose), fovy, aspect, z_near, z_far); });
}

sl_status sl_view_orthographic(const sl_pose* pose, double height, double aspect, double z_near, double z_far,
                               sl_view* view) {
  return make_view(__func__, view,
                   [&] { return core::View::orthographic(pose_of(pose), height, aspect, z_near, z_far); });
}

sl_status sl_view_asymmetric(const sl_pose* pose, double left, double right, double bottom, double top, double z_near,
                             double z_far, sl_view* view) {
  return make_view(__func__, view,
                   [&] { return core::View::asymmetric(pose_of(pose), left, right, bottom, top, z_near, z_far); });
}

sl_status sl_view_fit(const sl_box* bounds, const double direction[3], double fovy, double aspect, sl_view* view) {
  return make_view(__func__, view, [&] {
    require(bounds != nullptr, "bounds, found null");
    return core::View::fit(box_of(*bounds), direction ? vector_of(direction) : core::kOverviewDirection, fovy, aspect);
  });
}

sl_status sl_view_from_matrices(const double eye_from_world[16], const double clip_from_eye[16], sl_clip_depth depth,
                                sl_view* view) {
  return make_view(__func__, view, [&] {
    require(clip_from_eye != nullptr, "clip_from_eye, found null");
    const core::dmat4 eye = eye_from_world ? glm::make_mat4(eye_from_world) : core::dmat4(1.0);
    return core::View::from_matrices(eye, glm::make_mat4(clip_from_eye), enum_of<core::ClipDepth>(depth, 3, "depth"));
  });
}

sl_status sl_view_read(const char* path, double aspect, sl_view* view) {
#if SIGHTLINE_HAS_IMPORTERS
  return make_view(__func__, view, [&] { return importers::read_view(path_of(path), aspect); });
#else
  return call(__func__, [&] {
    (void)path, (void)aspect, (void)view;
    refuse(SL_ERROR_UNSUPPORTED, "this library was built without importers");
  });
#endif
}

// --- culling without a scene -----------------------------------------------------------------------------------------

namespace {

template <class Change>
sl_status change_boxes(const char* function, sl_box_culler handle, const Change& change) {
  return call(function, [&] { change(find(handle)->culler); });
}

}  // namespace

sl_status sl_box_culler_create(const sl_box* boxes, size_t box_count, sl_box_culler* culler) {
  return call(__func__, [&] {
    check_result(culler);
    auto made = value_of(culling::BoxCuller::create(boxes_of(boxes, box_count)));
    *culler = add_box_culler(std::make_shared<BoxCullerObject>(std::move(made)));
  });
}

sl_status sl_box_culler_destroy(sl_box_culler culler) {
  return call(__func__, [&] { (void)remove(culler); });
}

sl_status sl_box_culler_visible(sl_box_culler culler, const sl_view* view, uint32_t* indices, size_t capacity,
                                size_t* count) {
  return list_visible(__func__, culler, indices, capacity, count,
                      [&](const culling::BoxCuller& boxes, std::vector<std::uint32_t>& visible) {
                        boxes.visible(view_of(view), visible);
                      });
}

sl_status sl_box_culler_visible_in(sl_box_culler culler, const double clip_from_world[16], sl_clip_depth depth,
                                   uint32_t* indices, size_t capacity, size_t* count) {
  return list_visible(__func__, culler, indices, capacity, count,
                      [&](const culling::BoxCuller& boxes, std::vector<std::uint32_t>& visible) {
                        require(clip_from_world != nullptr, "a matrix, found null");
                        const auto range = enum_of<core::ClipDepth>(depth, 3, "depth");
                        value_of(boxes.visible(clip_from_world, range, visible));
                      });
}

sl_status sl_box_culler_in_box(sl_box_culler culler, const sl_box* range, int32_t inside, uint32_t* indices,
                               size_t capacity, size_t* count) {
  return list_visible(__func__, culler, indices, capacity, count,
                      [&](const culling::BoxCuller& boxes, std::vector<std::uint32_t>& found) {
                        require(range != nullptr, "a box, found null");
                        boxes.in_box(box_of(*range), inside != 0, found);
                      });
}

sl_status sl_box_culler_around(sl_box_culler culler, const double point[3], double radius, uint32_t* indices,
                               size_t capacity, size_t* count) {
  return list_visible(__func__, culler, indices, capacity, count,
                      [&](const culling::BoxCuller& boxes, std::vector<std::uint32_t>& found) {
                        boxes.around(short_vector_of(point), radius, found);
                      });
}

namespace {

template <class Find>
sl_status list_hits(const char* function, sl_box_culler handle, sl_box_hit* hits, std::size_t capacity,
                    std::size_t* count, const Find& find_hits) {
  return call(function, [&] {
    check_buffer(hits, capacity);
    check_result(count);
    const std::shared_ptr<BoxCullerObject> object = find(handle);
    std::vector<culling::BoxHit> found;
    find_hits(object->culler, found);
    write_list(found, hits, capacity, count, [](const culling::BoxHit& hit) {
      return sl_box_hit{hit.index, 0, hit.distance};
    });
  });
}

}  // namespace

sl_status sl_box_culler_along(sl_box_culler culler, const sl_ray* from, sl_box_hit* hits, size_t capacity,
                              size_t* count) {
  return list_hits(__func__, culler, hits, capacity, count,
                   [&](const culling::BoxCuller& boxes, std::vector<culling::BoxHit>& found) {
                     const sl_ray ray = read(from, sl_ray SL_RAY_INIT);
                     boxes.along({short_vector_of(ray.origin), short_vector_of(ray.direction), ray.t_min, ray.t_max},
                                 capacity, found);
                   });
}

sl_status sl_box_culler_nearest(sl_box_culler culler, const double point[3], sl_box_hit* hits, size_t capacity,
                                size_t* count) {
  return list_hits(__func__, culler, hits, capacity, count,
                   [&](const culling::BoxCuller& boxes, std::vector<culling::BoxHit>& found) {
                     boxes.nearest(short_vector_of(point), capacity, found);
                   });
}

sl_status sl_box_culler_update(sl_box_culler culler, uint32_t index, const sl_box* box) {
  return change_boxes(__func__, culler, [&](culling::BoxCuller& boxes) {
    require(box != nullptr, "a box, found null");
    require(index < boxes.size(), "the index of a box");
    value_of(boxes.update(index, box_of(*box)));
  });
}

sl_status sl_box_culler_update_many(sl_box_culler culler, const uint32_t* indices, const sl_box* boxes, size_t count) {
  return change_boxes(__func__, culler, [&](culling::BoxCuller& to) {
    check_array(indices, count, core::kNone);
    const std::span<const core::AabbD> replacements = boxes_of(boxes, count);
    const auto below = [&](std::uint32_t index) { return index < to.size(); };
    require(std::all_of(indices, indices + count, below), "indices of boxes");
    value_of(to.update({indices, count}, replacements));
  });
}

sl_status sl_box_culler_refit(sl_box_culler culler, const sl_box* boxes, size_t box_count) {
  return change_boxes(__func__, culler, [&](culling::BoxCuller& to) {
    const std::span<const core::AabbD> replacements = boxes_of(boxes, box_count);
    require(box_count == to.size(), "as many boxes as there are");
    value_of(to.refit(replacements));
  });
}
