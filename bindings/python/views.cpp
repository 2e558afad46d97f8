// Views, camera paths, and their JSON files.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sightline/bindings/python/module.h"
#include "sightline/bindings/python/planes.h"
#include "sightline/bindings/python/values.h"
#include "sightline/core/camera_path.h"
#include "sightline/core/view.h"
#include "sightline/importers/view_json.h"

namespace sightline::python {

template <>
inline constexpr int kEnumerators<core::ClipDepth> = 3;
template <>
inline constexpr int kEnumerators<core::SectionMode> = 2;

namespace {

using core::CameraPath;
using core::View;

constexpr auto kAnyRows = py::ssize_t(-1);

core::Pose pose(py::handle eye, py::handle target, py::handle up) {
  return {vector3(eye, "eye"), vector3(target, "target"), vector3(up, "up")};
}

core::AabbD box(py::handle value, const char* argument) {
  const auto corners = doubles(value, argument, {2, 3});
  const double* c = corners.data();
  return {{c[0], c[1], c[2]}, {c[3], c[4], c[5]}};
}

CameraPath make_path(py::handle times, py::handle eyes, py::handle targets, py::handle ups, py::handle fovys,
                     double near, double far) {
  const auto t = doubles(times, "times", {kAnyRows});
  const py::ssize_t count = t.size();
  const auto eye = doubles(eyes, "eyes", {count, 3}), target = doubles(targets, "targets", {count, 3});
  std::vector<core::CameraKey> keys(static_cast<std::size_t>(count));
  for (py::ssize_t i = 0; i < count; ++i) {
    core::CameraKey& key = keys[std::size_t(i)];
    key.time = t.at(i);
    key.pose.eye = {eye.at(i, 0), eye.at(i, 1), eye.at(i, 2)};
    key.pose.target = {target.at(i, 0), target.at(i, 1), target.at(i, 2)};
  }
  if (!ups.is_none()) {
    const auto up = doubles(ups, "ups", {count, 3});
    for (py::ssize_t i = 0; i < count; ++i) keys[std::size_t(i)].pose.up = {up.at(i, 0), up.at(i, 1), up.at(i, 2)};
  }
  if (!fovys.is_none()) {
    const auto fovy = doubles(fovys, "fovys", {count});
    for (py::ssize_t i = 0; i < count; ++i) keys[std::size_t(i)].fovy = fovy.at(i);
  }
  CameraPath path = unwrap(CameraPath::create(std::move(keys)));
  path.near = near;
  path.far = far;
  return path;
}

template <class Get>
Numbers<double> key_vectors(const CameraPath& path, const Get& get) {
  Numbers<double> out(Shape{py::ssize_t(path.keys().size()), 3});
  for (std::size_t i = 0; i < path.keys().size(); ++i)
    for (int axis = 0; axis < 3; ++axis) out.mutable_at(i, axis) = get(path.keys()[i])[axis];
  return out;
}

template <class Get>
Numbers<double> key_numbers(const CameraPath& path, const Get& get) {
  Numbers<double> out(Shape{py::ssize_t(path.keys().size())});
  for (std::size_t i = 0; i < path.keys().size(); ++i) out.mutable_at(i) = get(path.keys()[i]);
  return out;
}

py::tuple state_of_view(const View& v) {
  return py::make_tuple(to_array(v.eye_from_world()), to_array(v.clip_from_eye()), stored(v.clip_depth()), v.layers,
                        stored(v.section_mode), planes_to_array(v.sections));
}

View view_of_state(const py::tuple& state) {
  if (state.size() != 6) fail("pickle: it is of another version");
  View view = unwrap(
      View::from_matrices(matrix(state[0], "pickle"), matrix(state[1], "pickle"), restored<core::ClipDepth>(state[2])));
  view.layers = restored<std::uint32_t>(state[3]);
  view.section_mode = restored<core::SectionMode>(state[4]);
  view.sections = section_planes(state[5], "pickle");
  return view;
}

void bind_view(py::module_& m) {
  const py::tuple up = py::make_tuple(0.0, 0.0, 1.0);
  py::class_<View>(m, "View", "One camera: where it stands, how it projects, and what it cuts away.")
      .def_static(
          "perspective",
          [](const py::object& eye, const py::object& target, const py::object& up_, double fovy, double aspect,
             double near,
             double far) { return unwrap(View::perspective(pose(eye, target, up_), fovy, aspect, near, far)); },
          py::arg("eye"), py::arg("target"), py::arg("up") = up, py::kw_only(), py::arg("fovy") = 1.0,
          py::arg("aspect"), py::arg("near") = 0.1, py::arg("far") = core::kInfiniteFar,
          "From `eye` towards `target`, in metres. `fovy`: the vertical field of view in radians; `aspect`: width / "
          "height.")
      .def_static(
          "orthographic",
          [](const py::object& eye, const py::object& target, const py::object& up_, double height, double aspect,
             double near,
             double far) { return unwrap(View::orthographic(pose(eye, target, up_), height, aspect, near, far)); },
          py::arg("eye"), py::arg("target"), py::arg("up") = up, py::kw_only(), py::arg("height"), py::arg("aspect"),
          py::arg("near"), py::arg("far"), "A parallel projection of `height` metres from bottom to top.")
      .def_static(
          "asymmetric",
          [](const py::object& eye, const py::object& target, const py::object& up_, double left, double right,
             double bottom, double top, double near, double far) {
            return unwrap(View::asymmetric(pose(eye, target, up_), left, right, bottom, top, near, far));
          },
          py::arg("eye"), py::arg("target"), py::arg("up") = up, py::kw_only(), py::arg("left"), py::arg("right"),
          py::arg("bottom"), py::arg("top"), py::arg("near") = 0.1, py::arg("far") = core::kInfiniteFar,
          "An off-axis perspective: the borders lie on the near plane, in metres.")
      .def_static(
          "fit",
          [](const py::object& bounds, const py::object& direction, double fovy, double aspect) {
            return unwrap(View::fit(box(bounds, "bounds"), vector3(direction, "direction"), fovy, aspect));
          },
          py::arg("bounds"), py::arg("direction"), py::kw_only(), py::arg("fovy") = 0.25 * std::numbers::pi,
          py::arg("aspect"), "The perspective view along `direction` that the box [[min], [max]] fills.")
      .def_static(
          "from_matrices",
          [](const py::object& eye_from_world, const py::object& clip_from_eye, const std::string& depth) {
            return unwrap(View::from_matrices(matrix(eye_from_world, "eye_from_world"),
                                              matrix(clip_from_eye, "clip_from_eye"), depth_of(depth)));
          },
          py::arg("eye_from_world"), py::arg("clip_from_eye"), py::kw_only(), py::arg("depth") = "reversed",
          "From an application's matrices for column vectors. `depth`: \"reversed\" (1 near, 0 far), \"classic\" (-1 "
          "near, 1 far) or \"zero_to_one\" (0 near, 1 far); a projection that does not fit is an error. With the "
          "identity as `eye_from_world` it culls but does not draw.")
      .def_static(
          "parse",
          [](const py::str& json, double aspect) { return unwrap(importers::parse_view(to_bytes(json), aspect)); },
          py::arg("json"), py::kw_only(), py::arg("aspect"), "A view as sightline-render reads it, from text.")
      .def_static(
          "read",
          [](const std::filesystem::path& file, double aspect) { return unwrap(importers::read_view(file, aspect)); },
          py::arg("file"), py::kw_only(), py::arg("aspect"), "A view as sightline-render reads it, from a file.")
      .def_property_readonly(
          "eye_from_world", [](const View& v) { return to_array(v.eye_from_world()); }, "4 x 4, in float64.")
      .def_property_readonly(
          "clip_from_eye", [](const View& v) { return to_array(v.clip_from_eye()); }, "4 x 4, in float64.")
      .def_property_readonly(
          "clip_from_world", [](const View& v) { return to_array(v.clip_from_world()); },
          "The product, as the library rounds it: the view volume is defined by it.")
      .def_property_readonly(
          "eye", [](const View& v) { return to_array(v.eye()); }, "Position of a perspective view.")
      .def_property_readonly(
          "is_orthographic", [](const View& v) { return v.orthographic(); }, "Whether the projection is parallel.")
      .def_property(
          "sections", [](const View& v) { return planes_to_array(v.sections); },
          [](View& v, const py::object& planes) { v.sections = section_planes(planes, "sections"); },
          "Section planes, (N, 4): those x with dot(plane[:3], x) + plane[3] >= 0 are kept. At most 8. A copy: assign "
          "to change it.")
      .def_property(
          "section_mode",
          [](const View& v) { return v.section_mode == core::SectionMode::kUnion ? "union" : "intersection"; },
          [](View& v, const std::string& mode) {
            v.section_mode = core::SectionMode(one_of("section_mode", mode, {"intersection", "union"}));
          },
          "\"intersection\": what all section planes keep; \"union\": what any of them keeps.")
      .def_readwrite("layers", &View::layers, "A bit per layer; items are shown that share a bit.")
      .def("__copy__", [](const View& v) { return View(v); })
      .def(
          "__deepcopy__", [](const View& v, const py::dict&) { return View(v); }, py::arg("memo"))
      .def(
          "__eq__", [](const View& a, const View& b) { return core::same_image(a, b); }, py::is_operator())
      .def(py::pickle(&state_of_view, &view_of_state));
}

py::tuple state_of_path(const CameraPath& p) {
  return py::make_tuple(key_numbers(p, [](const auto& k) { return k.time; }),
                        key_vectors(p, [](const auto& k) { return k.pose.eye; }),
                        key_vectors(p, [](const auto& k) { return k.pose.target; }),
                        key_vectors(p, [](const auto& k) { return k.pose.up; }),
                        key_numbers(p, [](const auto& k) { return k.fovy; }), p.near, p.far);
}

CameraPath path_of_state(const py::tuple& state) {
  if (state.size() != 7) fail("pickle: it is of another version");
  return make_path(state[0], state[1], state[2], state[3], state[4], restored<double>(state[5]),
                   restored<double>(state[6]));
}

bool same_paths(const CameraPath& a, const CameraPath& b) {
  const auto same_keys = [](const core::CameraKey& k, const core::CameraKey& l) {
    return k.time == l.time && k.pose.eye == l.pose.eye && k.pose.target == l.pose.target && k.pose.up == l.pose.up &&
           k.fovy == l.fovy;
  };
  return a.near == b.near && a.far == b.far &&
         std::equal(a.keys().begin(), a.keys().end(), b.keys().begin(), b.keys().end(), same_keys);
}

void bind_path(py::module_& m) {
  py::class_<CameraPath>(m, "CameraPath",
                         "A smooth flight through key frames: position, speed and acceleration do not jump.")
      .def(py::init(&make_path), py::arg("times"), py::arg("eyes"), py::arg("targets"), py::arg("ups") = py::none(),
           py::arg("fovys") = py::none(), py::kw_only(), py::arg("near") = 0.1, py::arg("far") = core::kInfiniteFar,
           "`times`: seconds, rising, (N,); `eyes`, `targets`, `ups`: (N, 3); `fovys`: radians, (N,).")
      .def_static(
          "read", [](const std::filesystem::path& file) { return unwrap(importers::read_path(file)); }, py::arg("file"),
          "A path as sightline-replay reads it.")
      .def_static(
          "parse", [](const py::str& json) { return unwrap(importers::parse_path(to_bytes(json))); }, py::arg("json"),
          "A path as sightline-replay reads it, from text.")
      .def(
          "write",
          [](const CameraPath& p, const std::filesystem::path& file) { unwrap(importers::write_path(file, p)); },
          py::arg("file"), "Replaces the file.")
      .def(
          "format", [](const CameraPath& p) { return importers::format_path(p); }, "What write() writes.")
      .def(
          "view", [](const CameraPath& p, double time, double aspect) { return unwrap(p.view(time, aspect)); },
          py::arg("time"), py::kw_only(), py::arg("aspect"),
          "The view at a time in seconds; before the first key and after the last, theirs.")
      .def(
          "time_of",
          [](const CameraPath& p, int frame, int frames) {
            if (frames < 1 || frame < 0 || frame >= frames)
              fail("frame: expected 0 to frames - 1, found " + std::to_string(frame) + " of " + std::to_string(frames));
            return p.time_of(frame, frames);
          },
          py::arg("frame"), py::arg("frames"), "The time of a frame of `frames` evenly spaced ones.")
      .def_property_readonly("begin", &CameraPath::begin, "The first key's time.")
      .def_property_readonly("end", &CameraPath::end, "The last key's time.")
      .def_property_readonly(
          "times", [](const CameraPath& p) { return key_numbers(p, [](const auto& k) { return k.time; }); },
          "Of the keys, (N,).")
      .def_property_readonly(
          "fovys", [](const CameraPath& p) { return key_numbers(p, [](const auto& k) { return k.fovy; }); },
          "Of the keys, (N,), radians.")
      .def_property_readonly(
          "eyes", [](const CameraPath& p) { return key_vectors(p, [](const auto& k) { return k.pose.eye; }); },
          "Of the keys, (N, 3).")
      .def_property_readonly(
          "targets", [](const CameraPath& p) { return key_vectors(p, [](const auto& k) { return k.pose.target; }); },
          "Of the keys, (N, 3).")
      .def_property_readonly(
          "ups", [](const CameraPath& p) { return key_vectors(p, [](const auto& k) { return k.pose.up; }); },
          "Of the keys, (N, 3).")
      .def_readwrite("near", &CameraPath::near, "Distance of the near plane, metres.")
      .def_readwrite("far", &CameraPath::far, "Distance of the far plane, metres; may be infinite.")
      .def("__eq__", &same_paths, py::is_operator())
      .def(py::pickle(&state_of_path, &path_of_state));
}

}  // namespace

core::ClipDepth depth_of(const std::string& name) {
  return core::ClipDepth(one_of("depth", name, {"reversed", "classic", "zero_to_one"}));
}

std::vector<core::Plane> section_planes(py::handle value, const char* argument) {
  const auto rows = doubles(value, argument, {kAnyRows, 4});
  if (rows.shape(0) > py::ssize_t(core::kMaxSectionPlanes))
    fail(std::string(argument) + ": expected at most 8 planes, found " + std::to_string(rows.shape(0)));
  std::vector<core::Plane> planes;
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    planes.push_back({{rows.at(i, 0), rows.at(i, 1), rows.at(i, 2)}, rows.at(i, 3)});
    if (!core::is_finite(planes.back().normal) || !std::isfinite(planes.back().offset))
      fail(std::string(argument) + ": expected finite numbers in plane " + std::to_string(i));
  }
  return planes;
}

Numbers<double> planes_to_array(const std::vector<core::Plane>& planes) {
  Numbers<double> rows(Shape{py::ssize_t(planes.size()), 4});
  for (std::size_t i = 0; i < planes.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) rows.mutable_at(i, axis) = planes[i].normal[axis];
    rows.mutable_at(i, 3) = planes[i].offset;
  }
  return rows;
}

void bind_views(py::module_& m) {
  m.def(
      "translation", [](const py::object& offset) { return to_array(core::translation(vector3(offset, "offset"))); },
      py::arg("offset"), "The 4 x 4 matrix that moves points by `offset`, three numbers.");
  bind_view(m);
  bind_path(m);
  m.attr("OVERVIEW_DIRECTION") =
      py::make_tuple(core::kOverviewDirection.x, core::kOverviewDirection.y, core::kOverviewDirection.z);
  m.attr("DEFAULT_LAYERS") = core::kDefaultLayerMask;
}

}  // namespace sightline::python
