// Boxes in, indices out: culling without a scene, and what hides boxes.
#include <algorithm>
#include <optional>

#include "sightline/bindings/python/gate.h"
#include "sightline/bindings/python/module.h"
#include "sightline/bindings/python/planes.h"
#include "sightline/culling/box_culler.h"
#include "sightline/culling/occlusion/occluder_raster.h"

namespace sightline::python {
namespace {

static_assert(sizeof(core::AabbD) == 6 * sizeof(double));

struct GatedCuller {
  culling::BoxCuller culler;
  Gate gate;
  explicit GatedCuller(culling::BoxCuller&& made) : culler(std::move(made)) {}
};

/// The boxes where they lie.
std::span<const core::AabbD> boxes_of(const Numbers<double>& numbers, std::size_t count) {
  return {reinterpret_cast<const core::AabbD*>(numbers.data()), count};
}
std::span<const core::AabbD> boxes_of(const Numbers<double>& rows) {
  return boxes_of(rows, std::size_t(rows.shape(0)));
}

std::unique_ptr<GatedCuller> make_culler(const py::object& boxes) {
  const auto rows = doubles(boxes, "boxes", {-1, 6});
  const auto given = boxes_of(rows);
  core::Expected<culling::BoxCuller> made = core::fail("");
  {
    const py::gil_scoped_release released;
    made = culling::BoxCuller::create(given);
  }
  return std::make_unique<GatedCuller>(unwrap(std::move(made)));
}

py::array_t<std::uint32_t> visible_in_view(GatedCuller& culler, const core::View& view) {
  std::vector<std::uint32_t> indices;
  // NOLINTNEXTLINE(performance-unnecessary-copy-initialization): Python may change the view meanwhile
  const core::View copy = view;
  {
    const LongCall call({culler.gate, Use::kRead});
    culler.culler.visible(copy, indices);
  }
  return take(std::move(indices));
}

py::array_t<std::uint32_t> visible_in_matrix(GatedCuller& culler, const py::object& clip_from_world,
                                             const std::string& depth) {
  const core::dmat4 columns = matrix(clip_from_world, "clip_from_world");
  const core::ClipDepth range = depth_of(depth);
  std::vector<std::uint32_t> indices;
  core::Expected<void> done;
  {
    const LongCall call({culler.gate, Use::kRead});
    done = culler.culler.visible(&columns[0][0], range, indices);
  }
  unwrap(std::move(done));
  return take(std::move(indices));
}

py::array_t<std::uint32_t> in_box(GatedCuller& culler, const py::object& box, bool inside) {
  const auto row = doubles(box, "box", {6});
  const core::AabbD range = boxes_of(row, 1)[0];
  std::vector<std::uint32_t> indices;
  {
    const LongCall call({culler.gate, Use::kRead});
    culler.culler.in_box(range, inside, indices);
  }
  return take(std::move(indices));
}

py::array_t<std::uint32_t> around(GatedCuller& culler, const py::object& point, double radius) {
  const core::dvec3 centre = vector3(point, "point");
  std::vector<std::uint32_t> indices;
  {
    const LongCall call({culler.gate, Use::kRead});
    culler.culler.around(centre, radius, indices);
  }
  return take(std::move(indices));
}

py::array_t<culling::BoxHit> along(GatedCuller& culler, const py::object& origin, const py::object& direction,
                                   double t_min, double t_max, std::optional<std::size_t> count) {
  const core::Ray ray{vector3(origin, "origin"), vector3(direction, "direction"), t_min, t_max};
  std::vector<culling::BoxHit> hits;
  {
    const LongCall call({culler.gate, Use::kRead});
    culler.culler.along(ray, count.value_or(culler.culler.size()), hits);
  }
  return take(std::move(hits));
}

py::array_t<culling::BoxHit> nearest(GatedCuller& culler, const py::object& point, std::size_t count) {
  const core::dvec3 from = vector3(point, "point");
  std::vector<culling::BoxHit> hits;
  {
    const LongCall call({culler.gate, Use::kRead});
    culler.culler.nearest(from, count, hits);
  }
  return take(std::move(hits));
}

void check_index(const GatedCuller& culler, const char* argument, std::uint32_t index) {
  if (const std::size_t size = culler.culler.size(); index >= size)
    fail(std::string(argument) + ": expected less than " + std::to_string(size) + ", found " + std::to_string(index));
}

void update(GatedCuller& culler, std::uint32_t index, const py::object& box) {
  const auto row = doubles(box, "box", {6});
  const double* b = row.data();
  culler.gate.pass(Use::kWrite);
  check_index(culler, "index", index);
  unwrap(culler.culler.update(index, {{b[0], b[1], b[2]}, {b[3], b[4], b[5]}}));
}

/// A sequence (arrays are some), so that a number is the index of one box.
void update_many(GatedCuller& culler, const py::sequence& indices_of, const py::object& boxes) {
  const auto numbers = indices(indices_of, "indices", {-1});
  const auto rows = doubles(boxes, "boxes", {numbers.shape(0), 6});
  // A copy: another thread may write to the array between the check and the use.
  const std::vector<std::uint32_t> changed(numbers.data(), numbers.data() + numbers.size());
  for (const std::uint32_t index : changed) check_index(culler, "indices", index);
  const auto given = boxes_of(rows);
  core::Expected<void> done;
  {
    const LongCall call({culler.gate, Use::kWrite});
    done = culler.culler.update(changed, given);
  }
  unwrap(std::move(done));
}

void refit(GatedCuller& culler, const py::object& boxes) {
  const auto rows = doubles(boxes, "boxes", {py::ssize_t(culler.culler.size()), 6});
  const auto given = boxes_of(rows);
  core::Expected<void> done;
  {
    const LongCall call({culler.gate, Use::kWrite});
    done = culler.culler.refit(given);
  }
  unwrap(std::move(done));
}

// --- occluders -------------------------------------------------------------------------------------------------------

struct GatedRaster {
  culling::OccluderRaster raster;
  culling::DepthPyramid pyramid;  // of the image, where `built`
  int width = 0, height = 0;      // 0: there is no image yet
  bool built = false;
  Gate gate;
};

void check_image_size(py::ssize_t width, py::ssize_t height) {
  constexpr py::ssize_t kMost = culling::OccluderRaster::kMostPixels;
  if (width < 1 || height < 1 || width > kMost || height > kMost)
    fail("width and height: expected 1 to 16384 pixels, found " + std::to_string(width) + " and " +
         std::to_string(height));
}

void begin_image(GatedRaster& to, const core::View& view, int width, int height) {
  check_image_size(width, height);
  to.gate.pass(Use::kWrite);
  to.raster.begin(view, width, height);
  to.width = width, to.height = height;
  to.built = false;
}

/// The raster to add occluders to.
culling::OccluderRaster& add_to(GatedRaster& to) {
  to.gate.pass(Use::kWrite);
  if (to.width == 0) fail("occluders: call begin() first");
  to.built = false;
  return to.raster;
}

bool add_cylinder(GatedRaster& to, const py::object& placement, int sides) {
  const core::Affine world = affine(placement, "placement");
  if (sides < 3 || sides > 16) fail("sides: expected 3 to 16, found " + std::to_string(sides));
  return add_to(to).add_cylinder(world, sides);
}

void add_occluder_mesh(GatedRaster& to, const py::object& positions, const py::object& indices_of,
                       const py::object& placement) {
  const auto corners = floats(positions, "positions", {-1, 3});
  const auto numbers = indices(indices_of, "indices", {-1, 3});
  const core::Affine world = affine(placement, "placement");
  // A copy: another thread may write to the array between the check and the use.
  const std::vector<std::uint32_t> used(numbers.data(), numbers.data() + numbers.size());
  for (const std::uint32_t index : used)
    if (index >= corners.shape(0))
      fail("indices: expected less than " + std::to_string(corners.shape(0)) + ", found " + std::to_string(index));
  const auto* first = reinterpret_cast<const core::vec3*>(corners.data());
  add_to(to).add_mesh({first, std::size_t(corners.shape(0))}, used, world);
}

/// Rows from the top.
py::array_t<float> distances(GatedRaster& of) {
  of.gate.pass(Use::kRead);
  if (of.width == 0) fail("occluders: call begin() first");
  const auto width = std::ptrdiff_t(of.width);
  std::vector<float> up(std::size_t(of.width) * std::size_t(of.height));
  of.raster.distances(up);
  py::array_t<float> down(Shape{of.height, of.width});
  for (std::ptrdiff_t y = 0; y < of.height; ++y)
    std::copy_n(up.begin() + y * width, width, down.mutable_data(of.height - 1 - y, 0));
  return down;
}

/// Makes a pyramid of an array as distances() gives it.
culling::DepthPyramid pyramid_of(py::handle value) {
  const auto down = floats(value, "occluders", {-1, -1});
  const py::ssize_t height = down.shape(0), width = down.shape(1);
  check_image_size(width, height);
  std::vector<float> up;
  up.reserve(std::size_t(down.size()));
  for (py::ssize_t y = height; y-- > 0;) up.insert(up.end(), down.data(y, 0), down.data(y, 0) + width);
  culling::DepthPyramid pyramid;
  pyramid.build(up, int(width), int(height));
  return pyramid;
}

py::array_t<std::uint32_t> visible_behind(GatedCuller& culler, const core::View& view, const py::object& occluders) {
  std::vector<std::uint32_t> indices;
  // NOLINTNEXTLINE(performance-unnecessary-copy-initialization): Python may change the view meanwhile
  const core::View copy = view;
  if (!py::isinstance<GatedRaster>(occluders)) {
    const culling::DepthPyramid pyramid = pyramid_of(occluders);
    const LongCall call({culler.gate, Use::kRead});
    culler.culler.visible(copy, pyramid, indices);
  } else {
    auto& raster = occluders.cast<GatedRaster&>();
    if (raster.width == 0) fail("occluders: call begin() first");
    const LongCall call({culler.gate, Use::kRead}, {raster.gate, Use::kWrite});
    if (!raster.built) raster.raster.build(raster.pyramid);
    raster.built = true;
    culler.culler.visible(copy, raster.pyramid, indices);
  }
  return take(std::move(indices));
}

void bind_raster(py::module_& m) {
  py::class_<GatedRaster>(
      m, "OccluderRaster",
      "A depth image of chosen occluders, made by the CPU alone, for BoxCuller.visible(). They must "
      "be solid, opaque and drawn. Reuse one from frame to frame.")
      .def(py::init<>(), "Without an image: see begin().")
      .def("begin", &begin_image, py::arg("view"), py::arg("width"), py::arg("height"),
           "Empties the image, for occluders of this view in an image of so many pixels, 1 to 16384 each.")
      .def(
          "add_largest",
          [](GatedRaster& to, const py::object& boxes, std::size_t count) {
            const auto rows = doubles(boxes, "boxes", {-1, 6});
            return add_to(to).add_largest(boxes_of(rows), count);
          },
          py::arg("boxes"), py::arg("count") = 256,
          "Adds the `count` boxes that look largest from the eye, of solid boxes in the world, (N, 6). Returns how "
          "many "
          "meet the view volume.")
      .def(
          "add_cube",
          [](GatedRaster& to, const py::object& placement) {
            const core::Affine world = affine(placement, "placement");
            return add_to(to).add_cube(world);
          },
          py::arg("placement"), "The cube -1 to 1 in a placement, 4 x 4. False: it hides nothing.")
      .def("add_cylinder", &add_cylinder, py::arg("placement"), py::arg("sides") = 8,
           "The cylinder of radius 1 about z, from -1 to 1, as its inscribed prism of 3 to 16 sides. False: it hides "
           "nothing.")
      .def("add_mesh", &add_occluder_mesh, py::arg("positions"), py::arg("indices"), py::arg("placement") = py::none(),
           "Triangles, seen from both sides: (N, 3) positions and (M, 3) indices.")
      .def("distances", &distances,
           "The image, (height, width) float32: metres along the viewing direction; infinite where nothing is.");
}

}  // namespace

void bind_culling(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(culling::BoxHit, index, distance);
  bind_raster(m);
  py::class_<GatedCuller>(m, "BoxCuller",
                          "Finds the boxes that a camera sees. Needs no scene and no GL. Conservative: no box with a "
                          "part in the view is missing. Several threads may call visible() at once.")
      .def(py::init(&make_culler), py::arg("boxes"),
           "`boxes`: (N, 6), min x, y, z, max x, y, z in the world, in any unit. Float64 in C order is read where it "
           "lies. A box with min > max is never visible; one that is not finite is an error.")
      .def("__len__", [](const GatedCuller& c) { return c.culler.size(); })
      .def("visible", &visible_in_view, py::arg("view"),
           "Indices of the boxes that the view sees, uint32, in no order: the same for the same boxes. Its section "
           "planes count.")
      .def("visible", &visible_in_matrix, py::arg("clip_from_world"), py::kw_only(), py::arg("depth") = "reversed",
           "The same for projection @ view, 4 x 4. `depth`: as for View.from_matrices().")
      .def("visible", &visible_behind, py::arg("view"), py::arg("occluders"),
           "The same without boxes that are hidden, or cover no pixel: `occluders` is an OccluderRaster of this view, "
           "or "
           "its depth, (height, width) metres as Engine.read_depth() gives them. The view must know its eye.")
      .def("in_box", &in_box, py::arg("box"), py::kw_only(), py::arg("inside") = false,
           "Indices of the boxes that share a point with `box`, (6,), or with `inside` lie in it, uint32, rising.")
      .def("around", &around, py::arg("point"), py::arg("radius"),
           "Indices of the boxes within `radius` of a point, uint32, rising.")
      .def("along", &along, py::arg("origin"), py::arg("direction"), py::kw_only(), py::arg("t_min") = 0.0,
           py::arg("t_max") = core::kInfiniteFar, py::arg("count") = py::none(),
           "The boxes that a ray enters, all or the first `count`, front to back: a structured array of `index` and "
           "`distance` in units of the direction.")
      .def("nearest", &nearest, py::arg("point"), py::arg("count") = 1,
           "The `count` boxes nearest to a point, nearest first: a structured array of `index` and `distance`.")
      .def("update", &update_many, py::arg("indices"), py::arg("boxes"),
           "Replaces box indices[i] by boxes[i], (N, 6), for each i, several times faster than one by one. Of a "
           "repeated "
           "index the last box counts. Float64 in C order is read where it lies.")
      .def("update", &update, py::arg("index"), py::arg("box"), "Replaces one box.")
      .def("refit", &refit, py::arg("boxes"),
           "Replaces all boxes, (len(), 6): faster than a new culler. Boxes that move far make culling slower, not "
           "wrong; then make a new one.");
}

}  // namespace sightline::python
