// Boxes in, indices out: culling without a scene.
#include "sightline/culling/box_culler.h"
#include "sightline/python/gate.h"
#include "sightline/python/module.h"

namespace sightline::python {
namespace {

static_assert(sizeof(core::AabbD) == 6 * sizeof(double));

struct GatedCuller {
  culling::BoxCuller culler;
  Gate gate;
  explicit GatedCuller(culling::BoxCuller&& made) : culler(std::move(made)) {}
};

/// The boxes where they lie.
std::span<const core::AabbD> boxes_of(const Numbers<double>& rows) {
  return {reinterpret_cast<const core::AabbD*>(rows.data()), std::size_t(rows.shape(0))};
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
  const auto range = core::ClipDepth(one_of("depth", depth, {"reversed", "classic"}));
  std::vector<std::uint32_t> indices;
  core::Expected<void> done;
  {
    const LongCall call({culler.gate, Use::kRead});
    done = culler.culler.visible(&columns[0][0], range, indices);
  }
  unwrap(std::move(done));
  return take(std::move(indices));
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

}  // namespace

void bind_culling(py::module_& m) {
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
           "The same for projection @ view, 4 x 4. `depth`: \"reversed\" (1 near, 0 far) or \"classic\" (-1 near, 1 "
           "far).")
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
