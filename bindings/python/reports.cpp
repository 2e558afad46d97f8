#include "sightline/bindings/python/reports.h"

#include <cmath>

#include "sightline/bindings/python/names.h"
#include "sightline/gl/external_target.h"

namespace sightline::python {
namespace {

using culling::CullState;

void bind_frame_report(py::module_& m) {
  using engine::FrameReport;
  py::class_<FrameReport> c(m, "FrameReport", "What a frame did. Times in milliseconds of wall clock.");
  c.def_readonly("frame", &FrameReport::frame, "Frames before this one.")
      .def_property_readonly(
          "culler", [](const FrameReport& r) { return std::string(name_of(r.culler)); },
          "That culled it: \"linear\", \"cpu\" or \"gpu\".")
      .def_property_readonly(
          "state",
          [](const FrameReport& r) -> std::optional<std::string> {
            if (!r.state) return std::nullopt;
            return std::string(name_of(*r.state));
          },
          "Of the hybrid: \"cpu\", \"gpu\" or \"probe\"; None without one.")
      .def_readonly("cull_ms", &FrameReport::cull_ms, "The culler alone.")
      .def_readonly("draw_ms", &FrameReport::draw_ms, "Waiting, then making and submitting the draw lists.")
      .def_readonly("wait_ms", &FrameReport::wait_ms, "Of draw_ms: until the frame before the last was drawn.")
      .def_readonly("frame_ms", &FrameReport::frame_ms, "Since the last frame began; 0 for the first.")
      .def_readonly("drawn", &FrameReport::drawn, "False without drawing, and while the context is lost.")
      .def_readonly("visible", &FrameReport::visible, "Items in the view volume; -1: the GPU alone knows.")
      .def_readonly("tested", &FrameReport::tested, "Boxes tested; -1: the GPU alone knows.")
      .def_readonly("sampled", &FrameReport::sampled, "Items that may cover a sample; -1: unknown.")
      .def_readonly("items_drawn", &FrameReport::items_drawn, "Items drawn; -1: unknown.")
      .def_readonly("triangles", &FrameReport::triangles, "Triangles drawn, of meshes alone; -1: unknown.")
      .def_readonly("below_min_area", &FrameReport::below_min_area, "Items below `min_projected_area`.")
      .def_readonly("splats", &FrameReport::splats, "Items drawn as one splat.")
      .def_readonly("pending", &FrameReport::pending, "Items that `budget_ms` did not suffice for.")
      .def_readonly("coarseness", &FrameReport::coarseness,
                    "Above 1: a moving image with a pixel for so many along either axis.")
      .def_readonly("earlier", &FrameReport::earlier,
                    "Share of a moving image's pixels whose points earlier frames have found: 0 to 1.")
      .def("__repr__", [](const FrameReport& r) {
        return "<sightline.FrameReport " + std::to_string(r.frame) + ": " + std::to_string(r.visible) + " visible, " +
               std::to_string(r.items_drawn) + " drawn>";
      });
  bind_value<&FrameReport::frame, &FrameReport::culler, &FrameReport::state, &FrameReport::cull_ms,
             &FrameReport::draw_ms, &FrameReport::wait_ms, &FrameReport::frame_ms, &FrameReport::drawn,
             &FrameReport::visible, &FrameReport::tested, &FrameReport::sampled, &FrameReport::items_drawn,
             &FrameReport::triangles, &FrameReport::below_min_area, &FrameReport::splats, &FrameReport::pending,
             &FrameReport::coarseness, &FrameReport::earlier>(c);
}

void bind_small_reports(py::module_& m) {
  using engine::LateReport;
  py::class_<LateReport> late(m, "LateReport", "What the GPU culler found in an earlier frame.");
  late.def_readonly("frame", &LateReport::frame, "FrameReport.frame of that frame.")
      .def_readonly("visible", &LateReport::visible, "Items in the view volume.")
      .def_readonly("gpu_cull_ms", &LateReport::gpu_cull_ms, "On the GPU's clock; -1: not known.")
      .def_readonly("items_drawn", &LateReport::items_drawn, "Items drawn; -1 without drawing.");
  bind_value<&LateReport::frame, &LateReport::visible, &LateReport::gpu_cull_ms, &LateReport::items_drawn>(late);

  using engine::LossReport;
  py::class_<LossReport> loss(
      m, "LossReport", "What losses cost an image: of what is left out an estimate, of `lod_error` a proven bound.");
  loss.def_readonly("items", &LossReport::items,
                    "Left out, that may cover a sample and that nothing in the image is known to hide.")
      .def_readonly("pixels", &LossReport::pixels, "That these are expected to cover, at most all.")
      .def_readonly("lod_error", &LossReport::lod_error, "Pixels by which meshes may be drawn elsewhere, proved.")
      .def_readonly("triangles", &LossReport::triangles, "Triangles drawn, of meshes.")
      .def_readonly("full_triangles", &LossReport::full_triangles, "Triangles that the same items have in full.")
      .def_readonly("coarser_share", &LossReport::coarser_share,
                    "Of the items with a mesh that are drawn, those by coarser levels: 0 to 1.")
      .def_readonly("coarseness", &LossReport::coarseness, "Of the frame; above 1 `items` and `pixels` are 0.");
  bind_value<&LossReport::items, &LossReport::pixels, &LossReport::lod_error, &LossReport::triangles,
             &LossReport::full_triangles, &LossReport::coarser_share, &LossReport::coarseness>(loss);

  using engine::PlanEntry;
  py::class_<PlanEntry> entry(m, "PlanEntry", "A feature that the engine uses or leaves out.");
  entry.def_readonly("feature", &PlanEntry::feature, "Its name.")
      .def_readonly("used", &PlanEntry::used, "Whether the scene needs it.")
      .def_readonly("why", &PlanEntry::why, "The reason.");
  bind_value<&PlanEntry::feature, &PlanEntry::used, &PlanEntry::why>(entry);

  using engine::MemoryReport;
  py::class_<MemoryReport> memory(m, "MemoryReport", "Bytes held, and what for.");
  memory.def_readonly("scene", &MemoryReport::scene, "The scene graph.")
      .def_readonly("snapshot", &MemoryReport::snapshot, "The scene flattened.")
      .def_readonly("bvh", &MemoryReport::bvh, "The culler's hierarchy.")
      .def_readonly("gpu", &MemoryReport::gpu, "In the context.")
      .def_readonly("tracer", &MemoryReport::tracer,
                    "The ray tracer and the points of moving images; 0 before the first pick, or frame that is traced.")
      .def_readonly("scratch", &MemoryReport::scratch,
                    "Buffers that all threads of the process keep from call to call.")
      .def_readonly("levels", &MemoryReport::levels, "Clusters and levels of detail of meshes, in main memory.");
  bind_value<&MemoryReport::scene, &MemoryReport::snapshot, &MemoryReport::bvh, &MemoryReport::gpu,
             &MemoryReport::tracer, &MemoryReport::scratch, &MemoryReport::levels>(memory);

  py::class_<ControllerReport> controller(m, "ControllerReport", "What a hybrid's controller has done so far.");
  controller
      .def_property_readonly(
          "state", [](const ControllerReport& r) { return std::string(name_of(r.state)); },
          "\"cpu\", \"gpu\" or \"probe\".")
      .def_readonly("frames", &ControllerReport::frames, "Frames so far.")
      .def_readonly("switches", &ControllerReport::switches, "Changes of the culler, without probes.")
      .def_readonly("probes", &ControllerReport::probes, "Frames on the other culler that only measured it.");
  bind_value<&ControllerReport::state, &ControllerReport::frames, &ControllerReport::switches,
             &ControllerReport::probes>(controller);
}

template <class T>
py::array_t<T> copy_of(const std::vector<T>& values, const Shape& shape) {
  return py::array_t<T>(shape, values.data());
}

void bind_item_states(py::module_& m) {
  py::list names;
  for (int state = 0; state < culling::kCullStateCount; ++state) names.append(std::string(name_of(CullState(state))));
  m.attr("CULL_STATES") = py::tuple(names);
  py::class_<ItemStates> c(m, "CullStates",
                           "What culling makes of each item of a view. States are numbers, of names in CULL_STATES. "
                           "Arrays are copies.");
  c.def_property_readonly(
       "of_item", [](const ItemStates& s) { return copy_of(s.of_item, {py::ssize_t(s.of_item.size())}); },
       "By item id, uint8; \"outside\" where there is no such item.")
      .def_property_readonly(
          "items",
          [](const ItemStates& s) {
            py::dict counts;
            for (std::size_t i = 0; i < s.items.size() && i < std::size_t(culling::kCullStateCount); ++i)
              counts[py::str(std::string(name_of(CullState(i))))] = s.items[i];
            return counts;
          },
          "How many, by the name of their state, a dict.")
      .def_property_readonly(
          "boxes",
          [](const ItemStates& s) {
            return copy_of(s.boxes, {py::ssize_t(s.boxes.size() / 6), 6});
          },
          "Boxes of nodes of the hierarchy and of single items, each of one state, (N, 6) float64 in the world.")
      .def_property_readonly(
          "box_states", [](const ItemStates& s) { return copy_of(s.box_states, {py::ssize_t(s.box_states.size())}); },
          "Of the boxes, (N,) uint8.")
      .def_property_readonly(
          "box_items", [](const ItemStates& s) { return copy_of(s.box_items, {py::ssize_t(s.box_items.size())}); },
          "Items of that state in each box, (N,) uint32.");
  bind_value<&ItemStates::of_item, &ItemStates::items, &ItemStates::boxes, &ItemStates::box_states,
             &ItemStates::box_items>(c);
}

void bind_parts(py::module_& m) {
  using engine::ImageTile;
  py::class_<ImageTile> tile(m, "ImageTile", "A tile of an image, of the size that an engine draws in.");
  tile.def(py::init([](int width, int height, double x, double y) {
             return ImageTile{width, height, x, y};
           }),
           py::arg("width"), py::arg("height"), py::arg("x"), py::arg("y"),
           "`width`, `height`: of the whole image; `x`, `y`: the tile's upper left corner in it. Pixels.")
      .def_readwrite("width", &ImageTile::width, "Of the whole image, pixels.")
      .def_readwrite("height", &ImageTile::height, "Of the whole image, pixels.")
      .def_readwrite("x", &ImageTile::x, "Of the tile's upper left corner.")
      .def_readwrite("y", &ImageTile::y, "Of the tile's upper left corner.");
  bind_value<&ImageTile::width, &ImageTile::height, &ImageTile::x, &ImageTile::y>(tile);

  using engine::CroppedTile;
  py::class_<CroppedTile> cropped(m, "CroppedTile", "A tile, and the rectangle of the whole image taken from it.");
  cropped.def_readonly("tile", &CroppedTile::tile, "For Engine.frame_tile().")
      .def_readonly("x0", &CroppedTile::x0, "First column of the whole image.")
      .def_readonly("y0", &CroppedTile::y0, "First row, from the top.")
      .def_readonly("x1", &CroppedTile::x1, "Column after the last.")
      .def_readonly("y1", &CroppedTile::y1, "Row after the last.");
  bind_value<&CroppedTile::tile, &CroppedTile::x0, &CroppedTile::y0, &CroppedTile::x1, &CroppedTile::y1>(cropped);

  using engine::ImageTiles;
  py::class_<ImageTiles> tiles(m, "ImageTiles", "Parts of one size whose rectangles cover an image.");
  tiles.def_readonly("width", &ImageTiles::width, "Of each tile, pixels.")
      .def_readonly("height", &ImageTiles::height, "Of each tile, pixels.")
      .def_readonly("tiles", &ImageTiles::tiles, "A list, rows from the top, each from left to right.");
  constexpr int kMost = 1 << 18;  // more would be more tiles than memory holds
  m.def(
      "image_tiles",
      [](int width, int height, int largest_side, int more_margin) {
        for (const int side : {width, height, largest_side, more_margin})
          if (side > kMost) fail("image_tiles: expected at most 262144 pixels, found " + std::to_string(side));
        return unwrap(engine::image_tiles(width, height, largest_side, more_margin));
      },
      py::arg("width"), py::arg("height"), py::arg("largest_side"), py::arg("more_margin") = 0,
      "Parts of at most `largest_side` pixels a side, at least 80, that join without seams, for images that are "
      "larger "
      "than what is drawn at once. They overlap by 8 and `more_margin` pixels.");
  bind_value<&ImageTiles::width, &ImageTiles::height, &ImageTiles::tiles>(tiles);
}

}  // namespace

void check_target(const gl::ExternalTarget& target) {
  if (target.width < 1 || target.height < 1)
    fail("target: expected 1 or more pixels, found " + std::to_string(target.width) + " and " +
         std::to_string(target.height));
}

ItemStates states_by_item(const culling::CullStates& states, const core::Snapshot& snapshot, std::size_t items) {
  ItemStates by_item;
  by_item.of_item.assign(items, std::uint8_t(CullState::kOutside));
  for (std::size_t slot = 0; slot < states.of_slot.size(); ++slot)
    if (const auto s = core::Slot(slot); !snapshot.vacant(s) && to_index(snapshot.item(s)) < items)
      by_item.of_item[to_index(snapshot.item(s))] = std::uint8_t(states.of_slot[slot]);
  by_item.items.assign(states.items.begin(), states.items.end());
  const core::dvec3 origin = snapshot.bounds().origin;
  for (const culling::CullBox& box : states.boxes) {
    for (const core::vec3& corner : {box.box.min, box.box.max})
      for (int axis = 0; axis < 3; ++axis) by_item.boxes.push_back(origin[axis] + double(corner[axis]));
    by_item.box_states.push_back(std::uint8_t(box.state));
    by_item.box_items.push_back(box.items);
  }
  return by_item;
}

void bind_reports(py::module_& m) {
  bind_frame_report(m);
  bind_small_reports(m);
  bind_item_states(m);
}

void bind_targets(py::module_& m) {
  using gl::ExternalTarget;
  const ExternalTarget d;
  py::class_<ExternalTarget> c(m, "ExternalTarget",
                               "Part of a framebuffer of the application's, and what its depth buffer means.");
  c.def(py::init([](std::uint32_t framebuffer, int x, int y, int width, int height, double near_depth, double far_depth,
                    bool clear_colour, bool clear_depth, bool linear_colour) {
          const ExternalTarget made{framebuffer,  x, y, width, height, near_depth, far_depth, clear_colour, clear_depth,
                                    linear_colour};
          check_target(made);
          return made;
        }),
        py::arg("framebuffer") = d.framebuffer, py::kw_only(), py::arg("x") = d.x, py::arg("y") = d.y, py::arg("width"),
        py::arg("height"), py::arg("near_depth") = d.near_depth, py::arg("far_depth") = d.far_depth,
        py::arg("clear_colour") = d.clear_colour, py::arg("clear_depth") = d.clear_depth,
        py::arg("linear_colour") = d.linear_colour,
        "`framebuffer`: GL's name, 0 the window's; `x`, `y`: its lower left corner in pixels; `near_depth`, "
        "`far_depth`: "
        "what the depth buffer holds at the near and at the far plane, 0 and 1 in OpenGL's initial state, 1 and 0 with "
        "reverse-Z.")
      .def_readwrite("framebuffer", &ExternalTarget::framebuffer, "GL's name; 0: the window's.")
      .def_readwrite("x", &ExternalTarget::x, "Of the lower left corner, pixels.")
      .def_readwrite("y", &ExternalTarget::y, "Of the lower left corner, pixels.")
      .def_readwrite("width", &ExternalTarget::width, "Pixels.")
      .def_readwrite("height", &ExternalTarget::height, "Pixels.")
      .def_readwrite("near_depth", &ExternalTarget::near_depth, "Of the depth buffer at the near plane.")
      .def_readwrite("far_depth", &ExternalTarget::far_depth, "Of the depth buffer at the far plane.")
      .def_readwrite("clear_colour", &ExternalTarget::clear_colour, "Fill the part with the background first.")
      .def_readwrite("clear_depth", &ExternalTarget::clear_depth, "Fill its depth buffer with `far_depth` first.")
      .def_readwrite("linear_colour", &ExternalTarget::linear_colour, "Write linear light instead of sRGB values.");
  bind_value<&ExternalTarget::framebuffer, &ExternalTarget::x, &ExternalTarget::y, &ExternalTarget::width,
             &ExternalTarget::height, &ExternalTarget::near_depth, &ExternalTarget::far_depth,
             &ExternalTarget::clear_colour, &ExternalTarget::clear_depth, &ExternalTarget::linear_colour>(c);
  bind_parts(m);
}

}  // namespace sightline::python
