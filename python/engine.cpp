// The engine: frames, pictures, picks and queries.
//
// An engine's calls are long: they release the GIL. An engine's own context is current during its calls alone, so any
// thread may call, and Python may free the engine on any.
#include "sightline/engine/engine.h"

#include <algorithm>
#include <numbers>
#include <optional>
#include <span>

#include "sightline/core/camera_path.h"
#include "sightline/engine/item_style.h"
#include "sightline/engine/pick.h"
#include "sightline/gl/context.h"
#include "sightline/image/image.h"
#include "sightline/python/module.h"
#include "sightline/python/pictures.h"
#include "sightline/python/planes.h"
#include "sightline/python/scene.h"
#include "sightline/raytrace/exact_visibility.h"

namespace sightline::python {
namespace {

using engine::CullerChoice;
using engine::EngineConfig;

CullerChoice culler_of(const std::string& name) {
  return CullerChoice(one_of("culler", name, {"automatic", "linear", "cpu", "gpu", "hybrid"}));
}

/// An engine with its scene and context. After close() all calls fail.
class EngineBox {
 public:
  EngineBox(ScenePtr scene, const EngineConfig& config)
      : scene_(std::move(scene)), width_(config.width), height_(config.height) {
    core::Expected<void> done;
    {
      const LongCall call({gate_, Use::kWrite}, {scene_->gate, Use::kWrite});
      auto made = engine::Engine::create(scene_->scene, config);
      if (made)
        engine_ = std::move(*made);
      else
        done = tl::unexpected(made.error());
    }
    unwrap(std::move(done));
  }
  EngineBox(const EngineBox&) = delete;
  EngineBox& operator=(const EngineBox&) = delete;

  void close() {
    const LongCall call({gate_, Use::kWrite});
    engine_.reset();
  }
  bool closed() {
    gate_.pass(Use::kRead);
    return !engine_;
  }
  const ScenePtr& scene() const { return scene_; }
  int width() const { return width_; }
  int height() const { return height_; }

  /// What `work` returns for the engine, called without the GIL. `scene_use`: what it does with the scene.
  template <class Work>
  auto call(const Work& work, Use scene_use = Use::kRead) {
    const LongCall use({gate_, Use::kWrite}, {scene_->gate, scene_use});
    if (!engine_) fail("engine: it is closed");
    return work(*engine_);
  }

  core::Expected<void> resize(int width, int height) {
    auto done = call([&](engine::Engine& e) { return e.resize(width, height); });
    if (done) width_ = width, height_ = height;
    return done;
  }

 private:
  ScenePtr scene_;
  Gate gate_;
  int width_, height_;  // of the picture, in pixels
  std::optional<engine::Engine> engine_;
};

void check_size(int width, int height) {
  if (width < 1 || height < 1)
    fail("width and height: expected 1 or more pixels, found " + std::to_string(width) + " and " +
         std::to_string(height));
}

std::unique_ptr<EngineBox> make_engine(const ScenePtr& scene, bool draw, int width, int height, bool ids,
                                       const std::string& culler, bool sample_test, const std::string& occlusion,
                                       float contribution, const std::string& contribution_way, double budget_ms,
                                       const py::object& hidden_colour, int samples, bool gl_debug,
                                       const std::optional<std::filesystem::path>& program_cache, double rebuild_share,
                                       const std::optional<std::string>& gpu_pass, const std::string& policy,
                                       const std::string& context) {
  EngineConfig config;
  config.draw = draw;
  config.width = width;
  config.height = height;
  config.ids = ids;
  config.culler = culler_of(culler);
  config.sample_test = sample_test;
  config.occlusion = engine::OcclusionChoice(one_of("occlusion", occlusion, {"off", "on", "auto"}));
  config.contribution = contribution;
  config.contribution_way =
      engine::ContributionWay(one_of("contribution_way", contribution_way, {"drop", "points", "stochastic"}));
  config.budget_ms = budget_ms;
  if (!hidden_colour.is_none()) config.hidden_colour = core::vec3(vector3(hidden_colour, "hidden_colour"));
  config.samples = samples;
  config.gl_debug = gl_debug;
  config.program_cache = program_cache;
  config.rebuild_share = rebuild_share;
  if (gpu_pass) config.gpu_culler.variant = culling::GpuVariant(one_of("gpu_pass", *gpu_pass, {"geometry", "compute"}));
  config.controller.policy = culling::Policy(one_of("policy", policy, {"frame-cost", "2009"}));
  config.context_platform = unwrap(gl::parse_platform(context));
  check_size(width, height);
  return std::make_unique<EngineBox>(scene, config);
}

engine::FrameReport frame(EngineBox& box, const core::View& view, const std::optional<core::View>& cull_view) {
  const core::View seen = view;  // Python may change the view meanwhile
  return unwrap(box.call([&](engine::Engine& e) { return cull_view ? e.frame(seen, *cull_view) : e.frame(seen); }));
}

/// Ids of the items that the last frame's culler on the CPU found.
py::array_t<std::uint32_t> visible_items(EngineBox& box) {
  return take(box.call([](engine::Engine& e) {
    const core::Snapshot& snapshot = e.snapshot();
    std::vector<core::ItemId> ids;
    ids.reserve(e.visible().count());
    if (e.visible().generation == snapshot.generation())
      e.visible().for_each_slot([&](core::Slot slot) {
        if (!snapshot.vacant(slot)) ids.push_back(snapshot.item(slot));
      });
    std::sort(ids.begin(), ids.end());
    return ids;
  }));
}

core::View fit(EngineBox& box, const py::object& direction, double fovy, std::optional<double> aspect_) {
  const double aspect = aspect_.value_or(double(box.width()) / box.height());
  const core::dvec3 along = direction.is_none() ? core::kOverviewDirection : vector3(direction, "direction");
  return unwrap(box.call([&](engine::Engine& e) {
    return core::View::fit(e.snapshot().bounds().fitted_bounds().bounds, along, fovy, aspect);
  }));
}

core::CameraPath tour(EngineBox& box, double duration) {
  if (!(duration > 0.0 && duration < core::kInfiniteFar)) fail("duration: expected more than 0 seconds");
  return box.call([&](engine::Engine& e) {
    return core::make_tour(e.snapshot().bounds(), e.snapshot().bounds().fitted_bounds(), duration);
  });
}

// --- picks and queries -----------------------------------------------------------------------------------------------

struct Picked {
  ScenePtr scene;
  engine::Pick pick;
};

using Pick = core::Expected<std::optional<engine::Pick>>;

std::optional<Picked> picked(const EngineBox& box, Pick&& pick) {
  auto hit = unwrap(std::move(pick));
  if (!hit) return std::nullopt;
  return Picked{box.scene(), *hit};
}

std::optional<Picked> pick(EngineBox& box, const core::View& view, double x, double y) {
  const core::View seen = view;
  return picked(box, box.call([&](engine::Engine& e) { return e.pick(seen, x, y); }));
}

std::optional<Picked> pick_ray(EngineBox& box, const py::object& origin, const py::object& direction, double t_min,
                               double t_max, std::uint32_t layers) {
  const raytrace::Ray ray{vector3(origin, "origin"), vector3(direction, "direction"), t_min, t_max};
  raytrace::RayFilter filter;
  filter.layers = layers;
  return picked(box, box.call([&](engine::Engine& e) { return e.pick(ray, filter); }));
}

engine::PixelRectangle rectangle_of(py::handle value) {
  const auto r = doubles(value, "rectangle", {4});
  return {r.at(0), r.at(1), r.at(2), r.at(3)};
}

culling::RegionRule rule_of(const std::string& name) {
  return culling::RegionRule(one_of("rule", name, {"crossing", "wholly"}));
}

py::array_t<std::uint32_t> items_in(EngineBox& box, const core::View& view, const py::object& rectangle,
                                    const std::string& rule_name) {
  const core::View seen = view;
  const engine::PixelRectangle r = rectangle_of(rectangle);
  const auto rule = rule_of(rule_name);
  return take(unwrap(box.call([&](engine::Engine& e) { return e.items_in(seen, r, rule); })));
}

py::array_t<std::uint32_t> items_in_planes(EngineBox& box, const py::object& planes, const std::string& rule_name,
                                           std::uint32_t layers) {
  const auto kept = section_planes(planes, "planes");
  const auto rule = rule_of(rule_name);
  return take(unwrap(box.call([&](engine::Engine& e) { return e.items_in(kept, rule, layers); })));
}

py::array_t<raytrace::VisibleItem> visible_items_in(EngineBox& box, const core::View& view, const py::object& rectangle,
                                                    int samples) {
  if (samples < 1 || samples > 4096) fail("samples: expected 1 to 4096, found " + std::to_string(samples));
  const core::View seen = view;
  const engine::PixelRectangle r = rectangle_of(rectangle);
  return take(unwrap(box.call([&](engine::Engine& e) { return e.visible_items_in(seen, r, samples); })));
}

void bind_pick(py::module_& m) {
  py::class_<Picked>(m, "Pick", "What a ray hits first.")
      .def_property_readonly(
          "item", [](const Picked& p) { return p.pick.item; }, "The item's id.")
      .def_property_readonly(
          "node",
          [](const Picked& p) {
            return Node{p.scene, p.pick.node};
          },
          "The node that held it at the engine's last commit(); the scene may have removed it since.")
      .def_property_readonly(
          "point", [](const Picked& p) { return to_array(p.pick.point); }, "In the world, (3,).")
      .def_property_readonly(
          "normal", [](const Picked& p) { return to_array(p.pick.normal); },
          "In the world, of unit length, out of the solid, (3,).")
      .def_property_readonly(
          "t", [](const Picked& p) { return p.pick.t; },
          "Along the ray; in metres where its direction has unit length, as a view's rays have.")
      .def_property_readonly(
          "face", [](const Picked& p) { return std::string(raytrace::name_of(p.pick.face)); },
          "\"side\", \"top\", \"triangle\", \"cut\", …")
      .def_property_readonly(
          "triangle",
          [](const Picked& p) -> std::optional<std::uint32_t> {
            if (p.pick.triangle == core::kNone) return std::nullopt;
            return p.pick.triangle;
          },
          "Number of the mesh's triangle; None for solids and cuts.");
}

// --- overrides -------------------------------------------------------------------------------------------------------

void set_override(EngineBox& box, const py::object& items, const py::object& colour, float alpha, bool outline,
                  bool ghost) {
  engine::ItemStyle style{{}, alpha, outline, ghost};
  if (!colour.is_none()) style.colour = core::vec3(vector3(colour, "colour"));
  const auto ids = item_ids(items, "items");
  unwrap(box.call([&](engine::Engine& e) { return e.set_override(ids, style); }));
}

/// A function of the engine that takes items.
template <core::Expected<void> (engine::Engine::*kFunction)(std::span<const core::ItemId>)>
void of_items(EngineBox& box, const py::object& items) {
  const auto ids = item_ids(items, "items");
  unwrap(box.call([&](engine::Engine& e) { return (e.*kFunction)(ids); }));
}

void isolate(EngineBox& box, const std::vector<Node>& nodes) {
  std::vector<core::NodeId> ids;
  for (const Node& node : nodes) ids.push_back(node_in(box.scene(), node, "nodes"));
  unwrap(box.call([&](engine::Engine& e) { return e.isolate(ids); }));
}

// --- reports ---------------------------------------------------------------------------------------------------------

void bind_reports(py::module_& m) {
  using engine::FrameReport;
  py::class_<FrameReport>(m, "FrameReport", "What a frame did. Times in milliseconds of wall clock.")
      .def_readonly("frame", &FrameReport::frame, "Frames before this one.")
      .def_property_readonly(
          "culler", [](const FrameReport& r) { return std::string(name_of(r.culler)); },
          "That culled it: \"linear\", \"cpu\" or \"gpu\".")
      .def_readonly("cull_ms", &FrameReport::cull_ms, "The culler alone.")
      .def_readonly("draw_ms", &FrameReport::draw_ms, "Waiting, then making and submitting the draw lists.")
      .def_readonly("wait_ms", &FrameReport::wait_ms, "Of draw_ms: until the frame before the last was drawn.")
      .def_readonly("frame_ms", &FrameReport::frame_ms, "Since the last frame began; 0 for the first.")
      .def_readonly("drawn", &FrameReport::drawn, "False without drawing, and while the context is lost.")
      .def_readonly("visible", &FrameReport::visible, "Items in the view volume; -1: the GPU alone knows.")
      .def_readonly("tested", &FrameReport::tested, "Boxes tested; -1: the GPU alone knows.")
      .def_readonly("sampled", &FrameReport::sampled, "Items that may cover a sample; -1: unknown.")
      .def_readonly("shown", &FrameReport::shown, "Items drawn; -1: unknown.")
      .def_readonly("small", &FrameReport::small, "Items below `contribution`.")
      .def_readonly("squares", &FrameReport::squares, "Items drawn as one square.")
      .def_readonly("pending", &FrameReport::pending, "Items that `budget_ms` did not suffice for.")
      .def("__repr__", [](const FrameReport& r) {
        return "<sightline.FrameReport " + std::to_string(r.frame) + ": " + std::to_string(r.visible) + " visible, " +
               std::to_string(r.shown) + " shown>";
      });
  py::class_<engine::LateReport>(m, "LateReport", "What the GPU culler found in an earlier frame.")
      .def_readonly("frame", &engine::LateReport::frame, "FrameReport.frame of that frame.")
      .def_readonly("visible", &engine::LateReport::visible, "Items in the view volume.")
      .def_readonly("gpu_cull_ms", &engine::LateReport::gpu_cull_ms, "On the GPU's clock; -1: not known.")
      .def_readonly("shown", &engine::LateReport::shown, "Items drawn; -1 without drawing.");
  py::class_<engine::PlanEntry>(m, "PlanEntry", "A feature that the engine uses or leaves out.")
      .def_readonly("feature", &engine::PlanEntry::feature, "Its name.")
      .def_readonly("used", &engine::PlanEntry::used, "Whether the scene needs it.")
      .def_readonly("why", &engine::PlanEntry::why, "The reason.");
  py::class_<engine::MemoryReport>(m, "MemoryReport", "Bytes held, and what for.")
      .def_readonly("scene", &engine::MemoryReport::scene, "The scene graph.")
      .def_readonly("snapshot", &engine::MemoryReport::snapshot, "The scene flattened.")
      .def_readonly("bvh", &engine::MemoryReport::bvh, "The culler's hierarchy.")
      .def_readonly("gpu", &engine::MemoryReport::gpu, "In the context.")
      .def_readonly("tracer", &engine::MemoryReport::tracer, "The ray tracer; 0 before the first pick.");
}

// --- the class -------------------------------------------------------------------------------------------------------

using EngineClass = py::class_<EngineBox>;
using namespace py::literals;

void bind_frames(EngineClass& c) {
  c.def("frame", &frame, "view"_a, "cull_view"_a = py::none(),
        "Culls and, with `draw`, draws. `cull_view`: draws from `view` what lies in the volume of this one.")
      .def(
          "finish", [](EngineBox& b) { b.call([](engine::Engine& e) { e.finish(); }); },
          "Waits until everything submitted is drawn.")
      .def(
          "paused", [](EngineBox& b) { b.call([](engine::Engine& e) { e.paused(); }); },
          "Nothing was drawn for a while: the next frame_ms does not count that time.")
      .def(
          "take_late_report",
          [](EngineBox& b) { return b.call([](engine::Engine& e) { return e.take_late_report(); }); },
          "The oldest result of the GPU culler not yet taken; None while there is none.")
      .def(
          "read_colour",
          [](EngineBox& b) { return to_array(unwrap(b.call([](engine::Engine& e) { return e.read_colour(); }))); },
          "The last frame's picture, (height, width, 3) uint8, rows from the top. The array owns it.")
      .def(
          "read_ids",
          [](EngineBox& b) { return to_array(unwrap(b.call([](engine::Engine& e) { return e.read_ids(); }))); },
          "Item + 1 of each pixel, (height, width) uint32; 0: background. Needs `ids`. The array owns it.")
      .def(
          "read_depth",
          [](EngineBox& b, const core::View& view) {
            const core::View drawn = view;
            return to_array(unwrap(b.call([&](engine::Engine& e) { return e.read_depth(drawn); })));
          },
          "view"_a,
          "Metres along the axis of the drawn view, (height, width) float32; infinite where nothing is. The "
          "array owns it.")
      .def(
          "covered", [](EngineBox& b) { return unwrap(b.call([](engine::Engine& e) { return e.covered(); })); },
          "Whether any pixel shows anything but the background.")
      .def("visible_items", &visible_items,
           "Ids of the items that the last frame's culler found in the view volume, uint32, rising. Empty when the GPU "
           "culled.");
}

void bind_queries(EngineClass& c) {
  c.def("pick", &pick, "view"_a, "x"_a, "y"_a,
        "What the view shows at a point, in pixels from the upper left corner; None where nothing is. The first pick "
        "builds the ray tracer.")
      .def("pick_ray", &pick_ray, "origin"_a, "direction"_a, py::kw_only(), "t_min"_a = 0.0,
           "t_max"_a = core::kInfiniteFar, "layers"_a = core::kDefaultLayerMask, "What a ray hits first, or None.")
      .def("items_in", &items_in, "view"_a, "rectangle"_a, "rule"_a = "crossing",
           "Ids of the items in a rectangle (x0, y0, x1, y1) of the picture, hidden or not, uint32, rising. `rule`: "
           "\"crossing\" (any part) or \"wholly\".")
      .def("items_in_planes", &items_in_planes, "planes"_a, "rule"_a = "crossing", py::kw_only(),
           "layers"_a = core::kDefaultLayerMask, "The same for what all planes keep, (N, 4), at most 8.")
      .def("visible_items_in", &visible_items_in, "view"_a, "rectangle"_a, py::kw_only(), "samples"_a = 1,
           "Items that a rectangle of the picture shows, by rays: a structured array of `item` and `samples`.")
      .def("fit", &fit, "direction"_a = py::none(), py::kw_only(), "fovy"_a = 0.25 * std::numbers::pi,
           "aspect"_a = py::none(),
           "The view of the whole model along `direction`, without items that lie too far from all others. "
           "`aspect`: width / height; None: the engine's.")
      .def("tour", &tour, "duration"_a = 60.0, "A flight through the model, as sightline-replay makes it; seconds.");
}

void bind_overrides(EngineClass& c) {
  using engine::Engine;
  c.def("set_override", &set_override, "items"_a, py::kw_only(), "colour"_a = py::none(), "alpha"_a = 1.0f,
        "outline"_a = false, "ghost"_a = false,
        "Shows items in another style, in this engine alone and whatever is edited, from the next frame on. `colour`: "
        "(r, g, b), sRGB, in place of the material's; `alpha`: times the material's; `outline`: a line around what "
        "shows; `ghost`: a faint shell that hides nothing and that picks go through.")
      .def("clear_override", &of_items<&Engine::clear_override>, "items"_a, "Shows items as the scene says.")
      .def(
          "clear_overrides", [](EngineBox& b) { unwrap(b.call([](Engine& e) { return e.clear_overrides(); })); },
          "Shows all items as the scene says; hidden ones stay hidden.")
      .def("hide", &of_items<&Engine::hide>, "items"_a,
           "Hides items in this engine alone: they are not drawn, hide nothing, and no query finds them.")
      .def("show", &of_items<&Engine::show>, "items"_a, "Shows items again, unless the scene hides them.")
      .def("isolate", &isolate, "nodes"_a, "Hides all items but those below the nodes, and shows these.")
      .def(
          "show_all", [](EngineBox& b) { unwrap(b.call([](Engine& e) { return e.show_all(); })); },
          "Shows all items again, unless the scene hides them.");
}

void bind_state(EngineClass& c) {
  c.def(
       "commit",
       [](EngineBox& b, std::optional<double> seconds) {
         return unwrap(b.call(
             [&](engine::Engine& e) { return seconds ? e.commit(*seconds) : e.commit().map([] { return true; }); },
             Use::kWrite));
       },
       py::arg("seconds") = py::none(),
       "Commits the scene's edits and applies all edits that anybody has committed. Frames show no edit before. With "
       "`seconds` it works for about so long, and returns whether all are applied.")
      .def(
          "rebuild", [](EngineBox& b) { unwrap(b.call([](engine::Engine& e) { return e.rebuild(); }, Use::kWrite)); },
          "Commits, and orders all items anew.")
      .def_property_readonly(
          "rebuilding", [](EngineBox& b) { return b.call([](engine::Engine& e) { return e.rebuilding(); }); },
          "True while a new order is made in the background or waits to land.")
      .def(
          "set_culler",
          [](EngineBox& b, const std::string& culler) {
            const CullerChoice choice = culler_of(culler);
            unwrap(b.call([&](engine::Engine& e) { return e.set_culler(choice); }));
          },
          "culler"_a, "Uses another culler from the next frame on.")
      .def(
          "resize",
          [](EngineBox& b, int width, int height) {
            check_size(width, height);
            unwrap(b.resize(width, height));
          },
          "width"_a, "height"_a, "Draws in another size from the next frame on.")
      .def_property_readonly(
          "renderer", [](EngineBox& b) { return b.call([](engine::Engine& e) { return e.renderer(); }); },
          "As GL names it; empty without a context.")
      .def(
          "take_gl_errors", [](EngineBox& b) { return b.call([](engine::Engine& e) { return e.take_gl_errors(); }); },
          "What the driver has complained of since the last call: see `gl_debug`.")
      .def_property_readonly(
          "culler",
          [](EngineBox& b) { return std::string(name_of(b.call([](engine::Engine& e) { return e.plan().culler; }))); },
          "The culler that the plan has chosen.")
      .def_property_readonly(
          "plan", [](EngineBox& b) { return b.call([](engine::Engine& e) { return e.plan().entries; }); },
          "All features, used or left out, with the reason.")
      .def_property_readonly(
          "memory", [](EngineBox& b) { return b.call([](engine::Engine& e) { return e.memory(); }); },
          "Bytes held, and what for.")
      .def_property_readonly("width", &EngineBox::width, "Of the picture, in pixels.")
      .def_property_readonly("height", &EngineBox::height, "Of the picture, in pixels.")
      .def_property_readonly("scene", &EngineBox::scene, "The scene that it shows. The engine keeps it alive.");
}

void bind_life(EngineClass& c) {
  const EngineConfig d;
  c.def(py::init(&make_engine), "scene"_a.none(false), py::kw_only(), "draw"_a = d.draw, "width"_a = d.width,
        "height"_a = d.height, "ids"_a = d.ids, "culler"_a = std::string(name_of(d.culler)),
        "sample_test"_a = d.sample_test, "occlusion"_a = std::string(name_of(d.occlusion)),
        "contribution"_a = d.contribution, "contribution_way"_a = std::string(name_of(d.contribution_way)),
        "budget_ms"_a = d.budget_ms, "hidden_colour"_a = py::none(), "samples"_a = d.samples, "gl_debug"_a = d.gl_debug,
        "program_cache"_a = py::none(), "rebuild_share"_a = d.rebuild_share, "gpu_pass"_a = py::none(),
        "policy"_a = "frame-cost", "context"_a = "auto",
        "Commits the scene and builds what it needs.\n\n"
        "draw: offscreen, in `width` x `height` pixels; False needs no GL.\n"
        "ids: an image of item ids beside colour and depth.\n"
        "culler: \"automatic\", \"linear\", \"cpu\", \"gpu\" or \"hybrid\".\n"
        "sample_test, occlusion (\"off\", \"on\", \"auto\"): leave out what cannot be seen; no pixel is lost.\n"
        "contribution: leave out items below so many pixels; contribution_way: \"drop\", \"points\", \"stochastic\".\n"
        "budget_ms: time for a frame; 0: any.\n"
        "hidden_colour: (r, g, b) of what the tests leave out, in frames with a `cull_view`.\n"
        "samples: per pixel, 1 to 32.\n"
        "gl_debug: collect the driver's messages.\n"
        "program_cache: folder of linked programs; None: the user's cache; \"\": none.\n"
        "rebuild_share: share of slots out of order that starts a rebuild in the background; 0: never.\n"
        "gpu_pass: \"geometry\", \"compute\" or None; policy of the hybrid: \"frame-cost\" or \"2009\".\n"
        "context: where it draws: \"auto\", \"egl\", \"egl-surfaceless\", \"egl-device\" or \"osmesa\".")
      .def("close", &EngineBox::close, "Frees everything now. Later calls fail; a second close() does nothing.")
      .def_property_readonly("closed", &EngineBox::closed, "Whether close() has been called.")
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](EngineBox& b, const py::args&) { b.close(); });
}

}  // namespace

void bind_engine(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(raytrace::VisibleItem, item, samples);
  bind_reports(m);
  bind_pick(m);
  EngineClass c(
      m, "Engine",
      "Culls and draws a scene, and answers picks and queries. Calls release the GIL; of several threads that "
      "call one engine, one runs at a time. Usable in a with statement.");
  bind_life(c);
  bind_frames(c);
  bind_queries(c);
  bind_overrides(c);
  bind_state(c);
}

}  // namespace sightline::python
