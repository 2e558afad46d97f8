// The engine: frames, images, picks and queries.
//
// An engine's calls are long: they release the GIL. An engine's own context is current during its calls alone, so any
// thread may call, and Python may free the engine on any. With a context of the application's, its thread calls.
#include "sightline/engine/engine.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>
#include <span>

#include "sightline/bindings/python/config.h"
#include "sightline/bindings/python/engine_box.h"
#include "sightline/bindings/python/images.h"
#include "sightline/bindings/python/module.h"
#include "sightline/bindings/python/names.h"
#include "sightline/bindings/python/planes.h"
#include "sightline/bindings/python/reports.h"
#include "sightline/core/camera_path.h"
#include "sightline/core/fitting.h"
#include "sightline/engine/item_style.h"
#include "sightline/engine/pick.h"
#include "sightline/engine/tour.h"
#include "sightline/gl/external_target.h"
#include "sightline/raytrace/exact_visibility.h"
#include "sightline/render/image/image.h"

namespace sightline::python {
namespace {

using engine::CullerChoice;
using engine::EngineConfig;

CullerChoice culler_of(const std::string& name) {
  return enumerator_of<CullerChoice>("culler", name);
}

void check_size(int width, int height) {
  if (width < 1 || height < 1)
    fail("width and height: expected 1 or more pixels, found " + std::to_string(width) + " and " +
         std::to_string(height));
}

std::unique_ptr<EngineBox> make_engine(const ScenePtr& scene, const py::object& get_proc, const py::object& progress,
                                       const py::kwargs& given) {
  return std::make_unique<EngineBox>(scene, config_of<EngineConfig>("Engine", given), get_proc, progress);
}

void configure(EngineBox& box, const py::kwargs& given) {
  EngineConfig config = box.call([](engine::Engine& e) { return e.config(); });
  set_given(config, "configure", given, true);
  unwrap(box.call([&](engine::Engine& e) {
    // Another thread may have resized the image or changed the context meanwhile.
    config.width = e.config().width, config.height = e.config().height;
    config.context.application = e.config().context.application;
    config.context.later = e.config().context.later;
    return e.configure(config);
  }));
}

engine::FrameReport frame(EngineBox& box, const core::View& view, const std::optional<core::View>& cull_view) {
  const core::View seen = view;  // Python may change the view meanwhile
  const engine::FrameInput input{.view = seen, .cull_view = cull_view ? &*cull_view : nullptr};
  return unwrap(box.call([&](engine::Engine& e) { return e.frame(input); }));
}

engine::FrameReport frame_into(EngineBox& box, const core::View& view, const gl::ExternalTarget& target) {
  check_target(target);
  const core::View seen = view;
  const gl::ExternalTarget into = target;
  return unwrap(box.call([&](engine::Engine& e) {
    auto done = e.frame(seen, into);
    box.note_size(e);
    return done;
  }));
}

std::vector<engine::FrameReport> frame_views(EngineBox& box, const std::vector<core::View>& views,
                                             const std::vector<gl::ExternalTarget>& targets) {
  for (const gl::ExternalTarget& target : targets) check_target(target);
  return unwrap(box.call([&](engine::Engine& e) { return e.frame(views, targets); }));
}

void use_image(EngineBox& box, std::uint32_t number) {
  unwrap(box.call([&](engine::Engine& e) {
    auto done = e.use_image(number);
    box.note_size(e);
    return done;
  }));
}

engine::FrameReport frame_tile(EngineBox& box, const core::View& whole, const engine::ImageTile& tile) {
  const core::View seen = whole;
  const engine::ImageTile drawn = tile;
  return unwrap(box.call([&](engine::Engine& e) { return e.frame_tile(seen, drawn); }));
}

void draw_outline(EngineBox& box, const core::View& view, const py::object& items, const gl::ExternalTarget& target) {
  check_target(target);
  const auto ids = item_ids(items, "items");
  const core::View seen = view;
  const gl::ExternalTarget over = target;
  unwrap(box.call([&](engine::Engine& e) { return e.draw_outline(seen, ids, over); }));
}

engine::LossReport loss(EngineBox& box, const core::View& view) {
  const core::View drawn = view;
  return unwrap(box.call([&](engine::Engine& e) { return e.loss(drawn); }));
}

ItemStates cull_states(EngineBox& box, const core::View& view) {
  const core::View seen = view;
  return unwrap(box.call([&](engine::Engine& e) {
    return e.cull_states(seen).map([&](const culling::CullStates& states) {
      return states_by_item(states, e.snapshot(), box.scene()->scene.item_slots());
    });
  }));
}

std::optional<ControllerReport> controller(EngineBox& box) {
  return box.call([](engine::Engine& e) -> std::optional<ControllerReport> {
    const culling::Controller* c = e.controller();
    if (!c) return std::nullopt;
    return ControllerReport{c->state(), c->frames(), c->switches(), c->probes()};
  });
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
    const core::ItemBounds& items = e.snapshot().bounds();
    return core::fit_items(items, items.fitted_bounds().bounds, along, fovy, aspect);
  }));
}

core::CameraPath tour(EngineBox& box, double duration) {
  if (!(duration > 0.0 && duration < core::kInfiniteFar)) fail("duration: expected more than 0 seconds");
  return box.call([&](engine::Engine& e) {
    return engine::make_tour(e.snapshot().bounds(), e.snapshot().bounds().fitted_bounds(), duration);
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

engine::Ghosts ghosts_of(bool hit) {
  return hit ? engine::Ghosts::kHit : engine::Ghosts::kPassed;
}

std::optional<Picked> pick(EngineBox& box, const core::View& view, double x, double y, bool ghosts) {
  const core::View seen = view;
  return picked(box, box.call([&](engine::Engine& e) { return e.pick(seen, x, y, ghosts_of(ghosts)); }));
}

std::optional<Picked> pick_ray(EngineBox& box, const py::object& origin, const py::object& direction, double t_min,
                               double t_max, std::uint32_t layers, bool ghosts, const py::object& sections,
                               const std::string& section_mode, bool cuts) {
  const core::Ray ray{vector3(origin, "origin"), vector3(direction, "direction"), t_min, t_max};
  raytrace::RayFilter filter;
  filter.layers = layers;
  if (!sections.is_none()) filter.sections = section_planes(sections, "sections");
  filter.section_mode = core::SectionMode(one_of("section_mode", section_mode, {"intersection", "union"}));
  filter.cuts = cuts;
  return picked(box, box.call([&](engine::Engine& e) { return e.pick(ray, filter, ghosts_of(ghosts)); }));
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
          "face", [](const Picked& p) { return std::string(core::name_of(p.pick.face)); },
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

std::vector<core::NodeId> nodes_in(const EngineBox& box, const std::vector<Node>& nodes) {
  std::vector<core::NodeId> ids;
  ids.reserve(nodes.size());
  for (const Node& node : nodes) ids.push_back(node_in(box.scene(), node, "nodes"));
  return ids;
}

void isolate(EngineBox& box, const std::vector<Node>& nodes) {
  const auto ids = nodes_in(box, nodes);
  unwrap(box.call([&](engine::Engine& e) { return e.isolate(ids); }));
}

py::array_t<std::uint32_t> items_below(EngineBox& box, const std::vector<Node>& nodes) {
  const auto ids = nodes_in(box, nodes);
  return take(unwrap(box.call([&](engine::Engine& e) { return e.items_below(ids); })));
}

/// Throws for what set_override() and hide() refuse.
void check_known(const engine::Engine& engine, core::ItemId item) {
  if (engine.snapshot().slot(item) == core::kNone)
    fail("engine: no item " + std::to_string(core::to_index(item)) + " as of the last commit");
}

bool is_hidden(EngineBox& box, core::ItemId item) {
  return box.call([&](engine::Engine& e) { return check_known(e, item), e.is_hidden(item); });
}

/// The arguments of set_override().
std::optional<py::dict> override_of(EngineBox& box, core::ItemId item) {
  const auto style = box.call([&](engine::Engine& e) { return check_known(e, item), e.override_of(item); });
  if (!style) return std::nullopt;
  py::dict named;
  named["colour"] = style->colour ? py::object(py::make_tuple(style->colour->r, style->colour->g, style->colour->b))
                                  : py::object(py::none());
  named["alpha"] = style->alpha;
  named["outline"] = style->outline;
  named["ghost"] = style->ghost;
  return named;
}

// --- the class -------------------------------------------------------------------------------------------------------

using EngineClass = py::class_<EngineBox>;
using namespace py::literals;

void bind_frames(EngineClass& c) {
  c.def("frame", &frame, "view"_a, "cull_view"_a = py::none(),
        "Culls and, with `draw`, draws. `cull_view`: draws from `view` what lies in the volume of this one.")
      .def("frame_into", &frame_into, "view"_a, "target"_a,
           "As frame(view), and puts the image into a framebuffer of the application's context, with the depth test. "
           "The image gets the target's size. Needs `draw` and `get_proc`.")
      .def(
          "frame_views", &frame_views, "views"_a, "targets"_a,
          "As frame_into() for several views at one time, such as the two eyes of a headset. View i goes into target i "
          "and has image i of use_image(); a budget is for all of them together.")
      .def("use_image", &use_image, "number"_a,
           "Shows another one of the engine's images from now on, at first 0. One for each view keeps what the engine "
           "learns from frame to frame: its size, a budget's unfinished image, what was large or seen.")
      .def(
          "forget_image",
          [](EngineBox& b, std::uint32_t number) {
            unwrap(b.call([&](engine::Engine& e) { return e.forget_image(number); }));
          },
          "number"_a, "Frees what the engine has for an image that is not in use.")
      .def("frame_tile", &frame_tile, "whole"_a, "tile"_a,
           "Draws a tile of an image of the view `whole`, which may be larger than any framebuffer: see "
           "image_tiles(). The tile has the engine's size.")
      .def("draw_outline", &draw_outline, "view"_a, "items"_a, "target"_a,
           "Draws a line around items over a framebuffer that shows the last frame's image, of this view and of the "
           "target's size, in the time that these items take alone.")
      .def(
          "loss", &loss, "view"_a,
          "What the last frame, of this view, has left out by `min_projected_area` and `budget_ms`. Waits for the GPU.")
      .def("cull_states", &cull_states, "view"_a,
           "What culling makes of each item in the view. Draws for that: the last frame's image is gone.")
      .def(
          "finish", [](EngineBox& b) { b.call([](engine::Engine& e) { e.finish(); }); },
          "Waits until everything submitted is drawn.")
      .def(
          "finish_levels", [](EngineBox& b) { b.call([](engine::Engine& e) { return e.finish_levels(); }); },
          "Waits until the levels of detail that `lod_error` asks for are built and uploaded.")
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
          "The last frame's image, (height, width, 3) uint8, rows from the top. The array owns it.")
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
      .def(
          "framebuffer", [](EngineBox& b) { return unwrap(b.call([](engine::Engine& e) { return e.framebuffer(); })); },
          "GL's name of the framebuffer with the last frame's image, in the context that the engine draws with.")
      .def("visible_items", &visible_items,
           "Ids of the items that the last frame's culler found in the view volume, uint32, rising. Empty when the GPU "
           "culled.");
}

void bind_queries(EngineClass& c) {
  c.def("pick", &pick, "view"_a, "x"_a, "y"_a, py::kw_only(), "ghosts"_a = false,
        "What the view shows at a point, in pixels from the upper left corner; None where nothing is. `ghosts`: hits "
        "items whose style is ghost, too. The first pick builds the ray tracer, unless prepare_picks() has.")
      .def("pick_ray", &pick_ray, "origin"_a, "direction"_a, py::kw_only(), "t_min"_a = 0.0,
           "t_max"_a = core::kInfiniteFar, "layers"_a = core::kDefaultLayerMask, "ghosts"_a = false,
           "sections"_a = py::none(), "section_mode"_a = "intersection", "cuts"_a = true,
           "What a ray hits first, or None. `sections`: as of a View; `cuts`: what they cut open is a face, otherwise "
           "rays see the insides.")
      .def(
          "prepare_picks", [](EngineBox& b) { b.call([](engine::Engine& e) { e.prepare_picks(); }); },
          "Begins to build the ray tracer in the background, unless there is one. Until then picks wait for it; frames "
          "do not.")
      .def_property_readonly(
          "preparing_picks", [](EngineBox& b) { return b.call([](engine::Engine& e) { return e.preparing_picks(); }); },
          "Whether that is going on, so that a pick would wait.")
      .def("items_in", &items_in, "view"_a, "rectangle"_a, "rule"_a = "crossing",
           "Ids of the items in a rectangle (x0, y0, x1, y1) of the image, hidden or not, uint32, rising. `rule`: "
           "\"crossing\" (any part) or \"wholly\".")
      .def("items_in_planes", &items_in_planes, "planes"_a, "rule"_a = "crossing", py::kw_only(),
           "layers"_a = core::kDefaultLayerMask, "The same for what all planes keep, (N, 4), at most 8.")
      .def("visible_items_in", &visible_items_in, "view"_a, "rectangle"_a, py::kw_only(), "samples"_a = 1,
           "Items that a rectangle of the image shows, by rays: a structured array of `item` and `samples`.")
      .def("fit", &fit, "direction"_a = py::none(), py::kw_only(), "fovy"_a = 0.25 * std::numbers::pi,
           "aspect"_a = py::none(),
           "The view of the whole model along `direction`, which fills nine tenths of the image, without items that "
           "lie too "
           "far from all others. "
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
          "items_below", &items_below, "nodes"_a,
          "Ids of the items that hang on the nodes and on all below them, as of the last commit(), uint32, rising: for "
          "all calls that take items.")
      .def("override_of", &override_of, "item"_a,
           "The style that set_override() gave an item, as its named arguments; None where it shows as the scene says.")
      .def(
          "overridden_items",
          [](EngineBox& b) { return take(b.call([](engine::Engine& e) { return e.overridden_items(); })); },
          "Ids of the items with such a style, uint32, rising.")
      .def("is_hidden", &is_hidden, "item"_a, "Whether hide() or isolate() hides the item.")
      .def(
          "hidden_items", [](EngineBox& b) { return take(b.call([](engine::Engine& e) { return e.hidden_items(); })); },
          "Ids of the items that they hide, uint32, rising.")
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
          "True while a new scene version is made in the background or waits to land.")
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
            b.resize(width, height);
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
      .def_property_readonly("controller", &controller, "What the hybrid's controller has done; None without one.")
      .def_property_readonly(
          "config", [](EngineBox& b) { return to_dict(b.call([](engine::Engine& e) { return e.config(); })); },
          "All settings as they are now: a dict of the constructor's keyword arguments.")
      .def_property_readonly("width", &EngineBox::width, "Of the image, in pixels.")
      .def_property_readonly("height", &EngineBox::height, "Of the image, in pixels.")
      .def_property_readonly("scene", &EngineBox::scene, "The scene that it shows. The engine keeps it alive.");
}

constexpr const char* kEngineDoc =
    "Commits the scene and builds what it needs.\n\n"
    "get_proc: draws in the application's context, which is current in this and all later calls. Finds GL's functions: "
    "a function of a name that returns an address or None, one of ctypes, or its address.\n"
    "progress: called with the share done, 0 to 1; False cancels, and so do exceptions and Ctrl-C.";

void bind_settings(EngineClass& c) {
  const std::string made =
      doc_of<EngineConfig>("__init__", "scene: Scene", "get_proc: object = None, progress: object = None", kEngineDoc);
  const std::string changed =
      doc_of<EngineConfig>("configure", "", "", "Uses other settings from the next frame on; the others stay.", true);
  py::options options;
  options.disable_function_signatures();
  c.def(py::init(&make_engine), "scene"_a.none(false), py::kw_only(), "get_proc"_a = py::none(),
        "progress"_a = py::none(), made.c_str())
      .def("configure", &configure, changed.c_str());
}

void bind_life(EngineClass& c) {
  bind_settings(c);
  c.def("close", &EngineBox::close,
        "Frees everything now. Later calls fail; a second close() does nothing. An engine with `get_proc` that ends "
        "without it leaves to the application's context what it has there.")
      .def_property_readonly("closed", &EngineBox::closed, "Whether close() has been called.")
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](EngineBox& b, const py::args&) { b.close(); });
}

void bind_contexts(EngineClass& c) {
  c.def("drop_context", &EngineBox::drop_context,
        "Frees what the engine has in the application's context, which must be current. Frames are then culled and not "
        "drawn.")
      .def("abandon_context", &EngineBox::abandon_context,
           "The same for a context that is gone with all that was in it: calls no GL.")
      .def(
          "use_context", &EngineBox::use_context, "get_proc"_a, "seconds"_a = py::none(),
          "Makes everything anew in the application's context that is current now, in place of one that was dropped or "
          "abandoned. With `seconds` it works for about so long, and returns whether everything is made; while it is "
          "not, call it again with the same context.");
}

}  // namespace

void bind_engine(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(raytrace::VisibleItem, item, samples);
  bind_controller_config(m);
  bind_reports(m);
  bind_targets(m);
  bind_pick(m);
  EngineClass c(
      m, "Engine",
      "Culls and draws a scene, and answers picks and queries. Calls release the GIL; of several threads that "
      "call one engine, one runs at a time. Usable in a with statement.");
  bind_life(c);
  bind_contexts(c);
  bind_frames(c);
  bind_queries(c);
  bind_overrides(c);
  bind_state(c);
}

}  // namespace sightline::python
