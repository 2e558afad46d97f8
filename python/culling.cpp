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

std::unique_ptr<GatedCuller> make_culler(const py::object& boxes) {
  const auto rows = doubles(boxes, "boxes", {-1, 6});
  const auto* first = reinterpret_cast<const core::AabbD*>(rows.data());
  const std::size_t count = std::size_t(rows.shape(0));
  core::Expected<culling::BoxCuller> made = core::fail("");
  {
    const py::gil_scoped_release released;
    made = culling::BoxCuller::create(std::span(first, count));
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

void update(GatedCuller& culler, std::uint32_t index, const py::object& box) {
  const auto row = doubles(box, "box", {6});
  const double* b = row.data();
  culler.gate.pass(Use::kWrite);
  if (index >= culler.culler.size())
    fail("index: expected less than " + std::to_string(culler.culler.size()) + ", found " + std::to_string(index));
  unwrap(culler.culler.update(index, {{b[0], b[1], b[2]}, {b[3], b[4], b[5]}}));
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
      .def("update", &update, py::arg("index"), py::arg("box"), "Replaces one box.");
}

}  // namespace sightline::python
