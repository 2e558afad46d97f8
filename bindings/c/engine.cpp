#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <glm/gtc/type_ptr.hpp>

#include "sightline/bindings/c/internal/engines.h"
#include "sightline/engine/internal/choices.h"
#if SIGHTLINE_HAS_RAYTRACE
#include "sightline/engine/pick.h"
#endif
#if SIGHTLINE_HAS_IMAGE
#include "sightline/render/image/image.h"
#endif

using namespace sightline;
using namespace sightline::capi;

namespace {

constexpr std::int32_t kLargestImage = 65'536;

}  // namespace

namespace sightline::capi {

void check_size(std::int32_t width, std::int32_t height) {
  require(width >= 1 && width <= kLargestImage && height >= 1 && height <= kLargestImage,
          "a width and height of 1 to 65536 pixels");
}

void check_drawing(bool needed) {
  if (needed && !SIGHTLINE_HAS_GL) refuse(SL_ERROR_UNSUPPORTED, "this library was built without drawing");
}

sl_frame_report report_of(const engine::FrameReport& from) {
  sl_frame_report report SL_FRAME_REPORT_INIT;
  report.culler = sl_culler(from.culler);
  report.frame = from.frame;
  report.cull_ms = from.cull_ms, report.draw_ms = from.draw_ms;
  report.wait_ms = from.wait_ms, report.frame_ms = from.frame_ms;
  report.visible = from.visible, report.tested = from.tested;
  report.sampled = from.sampled, report.items_drawn = from.items_drawn;
  report.below_min_area = from.below_min_area, report.splats = from.splats;
  report.pending = from.pending, report.coarseness = from.coarseness, report.earlier = from.earlier;
  report.drawn = from.drawn;
  report.hybrid_state = from.state ? std::int32_t(*from.state) : -1;
  report.triangles = from.triangles;
  return report;
}

gl::ExternalTarget target_of(const sl_external_target* from) {
  const sl_external_target to = read(from, sl_external_target SL_EXTERNAL_TARGET_INIT);
  check_size(to.width, to.height);
  return {to.framebuffer,
          to.x,
          to.y,
          to.width,
          to.height,
          to.near_depth,
          to.far_depth,
          to.clear_colour != 0,
          to.clear_depth != 0,
          to.linear_colour != 0};
}

void tell_lines(const std::vector<std::string>& lines, std::string& not_told, sl_text* text) {
  for (const std::string& line : lines) not_told += line + '\n';
  write_text(text, not_told);
  if (not_told.size() < text->capacity) not_told.clear();
}

std::span<const core::ItemId> items_of(const sl_item* items, std::size_t count) {
  check_array(items, count, core::kNone);
  static_assert(sizeof(core::ItemId) == sizeof(sl_item));
  return {reinterpret_cast<const core::ItemId*>(items), count};
}

}  // namespace sightline::capi

namespace {

/// An engine of the scene, whose progress the caller is told. The scene is in use meanwhile.
engine::Engine make_engine(core::Scene& scene, const engine::EngineConfig& config, const sl_engine_config& from) {
  bool cancelled = false;
  const engine::Engine::Progress told = progress_of(from.progress, from.progress_user);
  const auto progress = [&](double share) {
    cancelled = !told(share);
    return !cancelled;
  };
  auto made = engine::Engine::create(scene, config, told ? engine::Engine::Progress(progress) : told);
  if (!made && cancelled) throw Failure{SL_ERROR_CANCELLED, std::move(made.error().message)};
  return value_of(std::move(made));
}

}  // namespace

// --- engines ---------------------------------------------------------------------------------------------------------

sl_status sl_engine_create(sl_scene handle, const sl_engine_config* config, sl_engine* engine) {
  return call(__func__, [&] {
    check_result(engine);
    const sl_engine_config defaults = SL_ENGINE_CONFIG_INIT;
    const sl_engine_config chosen = read(config ? config : &defaults, defaults);
    engine::EngineConfig translated = config_of(chosen);
    std::shared_ptr<EngineObject> object;  // outlives the use of the scene, which may be its last
    const SceneUse scene(handle, Access::kEdit);
    object = std::make_shared<EngineObject>(share(handle));
#if SIGHTLINE_HAS_GL
    if (chosen.get_proc) {
      object->context =
          std::make_unique<gl::Context>(value_of(gl::Context::adopt(chosen.get_proc, chosen.get_proc_user)));
      translated.context.application = object->context.get();
    }
    object->context_in_use =
        !translated.context.later && (translated.draw || translated.culling.culler == engine::CullerChoice::kGpu ||
                                      translated.culling.culler == engine::CullerChoice::kHybrid);
#endif
    scene.object().committed = true;
    object->engine.emplace(make_engine(*scene, translated, chosen));
    *engine = add_engine(std::move(object));
  });
}

sl_status sl_engine_destroy(sl_engine handle) {
  return call(__func__, [&] {
    std::shared_ptr<EngineObject> gone;
    const EngineUse engine(handle, Access::kDestroy);
    gone = remove(handle);
  });
}

sl_status sl_engine_frame(sl_engine handle, const sl_view* view, const sl_view* cull_view, sl_frame_report* report) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    if (report) check_result(report);
    const core::View drawn = view_of(view);
    std::optional<core::View> culled_by;
    if (cull_view) culled_by = view_of(cull_view);
    const engine::FrameReport done =
        value_of(engine->frame({.view = drawn, .cull_view = culled_by ? &*culled_by : nullptr}));
    if (report) write(report, report_of(done));
  });
}

sl_status sl_engine_frame_into(sl_engine handle, const sl_view* view, const sl_external_target* target,
                               sl_frame_report* report) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    if (report) check_result(report);
    check_drawing(true);
    const gl::ExternalTarget to = target_of(target);
    const engine::FrameReport done = value_of(engine->frame(view_of(view), to));
    if (report) write(report, report_of(done));
  });
}

sl_status sl_engine_frame_views(sl_engine handle, const sl_view* const* views, const sl_external_target* const* targets,
                                size_t count, sl_frame_report* const* reports) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    check_array(views, count, kMostListed);
    check_array(targets, count, kMostListed);
    check_drawing(true);
    std::vector<core::View> seen;
    std::vector<gl::ExternalTarget> into;
    for (std::size_t i = 0; i < count; ++i) {
      if (reports) check_result(reports[i]);
      seen.push_back(view_of(views[i]));
      into.push_back(target_of(targets[i]));
    }
    const auto done = value_of(engine->frame(seen, into));
    for (std::size_t i = 0; reports && i < count; ++i) write(reports[i], report_of(done[i]));
  });
}

sl_status sl_engine_use_image(sl_engine handle, uint32_t number) {
  return with_engine(__func__, handle, Access::kEdit,
                     [&](const EngineUse& engine) { value_of(engine->use_image(number)); });
}

sl_status sl_engine_forget_image(sl_engine handle, uint32_t number) {
  return with_engine(__func__, handle, Access::kEdit,
                     [&](const EngineUse& engine) { value_of(engine->forget_image(number)); });
}

sl_status sl_engine_late_report(sl_engine handle, sl_late_report* report) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    check_result(report);
    const auto late = engine->take_late_report();
    write(report, late ? sl_late_report{0, 1, late->frame, late->visible, late->items_drawn, late->gpu_cull_ms}
                       : sl_late_report SL_LATE_REPORT_INIT);
  });
}

sl_status sl_engine_commit(sl_engine handle) {
  return with_engine(__func__, handle, Access::kEdit, [](const EngineUse& engine) { value_of(engine->commit()); });
}

sl_status sl_engine_commit_for(sl_engine handle, double seconds, int32_t* complete) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    require(complete != nullptr, "complete, found null");
    *complete = value_of(engine->commit(seconds));
  });
}

sl_status sl_engine_rebuild(sl_engine handle) {
  return with_engine(__func__, handle, Access::kEdit, [](const EngineUse& engine) { value_of(engine->rebuild()); });
}

sl_status sl_engine_set_culler(sl_engine handle, sl_culler culler) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    const auto choice =
        enum_of<engine::CullerChoice>(culler, std::int32_t(engine::kChoices<engine::CullerChoice>.size()), "culler");
    check_drawing(choice == engine::CullerChoice::kGpu || choice == engine::CullerChoice::kHybrid);
    value_of(engine->set_culler(choice));
  });
}

sl_status sl_engine_resize(sl_engine handle, int32_t width, int32_t height) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    check_size(width, height);
    value_of(engine->resize(width, height));
  });
}

sl_status sl_engine_paused(sl_engine handle) {
  return with_engine(__func__, handle, Access::kEdit, [](const EngineUse& engine) { engine->paused(); });
}

sl_status sl_engine_finish(sl_engine handle) {
  return with_engine(__func__, handle, Access::kEdit, [](const EngineUse& engine) { engine->finish(); });
}

sl_status sl_engine_finish_levels(sl_engine handle) {
  return with_engine(__func__, handle, Access::kEdit,
                     [](const EngineUse& engine) { value_of(engine->finish_levels()); });
}

sl_status sl_engine_get(sl_engine handle, sl_engine_info* info) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    const engine::MemoryReport memory = engine->memory();
    sl_engine_info found SL_ENGINE_INFO_INIT;
    found.culler = sl_culler(engine->plan().culler);
    found.rebuilding = engine->rebuilding();
#if SIGHTLINE_HAS_RAYTRACE
    found.preparing_picks = engine->preparing_picks();
#endif
    found.scene_bytes = memory.scene, found.snapshot_bytes = memory.snapshot;
    found.hierarchy_bytes = memory.bvh, found.gpu_bytes = memory.gpu, found.tracer_bytes = memory.tracer;
    found.scratch_bytes = memory.scratch, found.levels_bytes = memory.levels;
    write(info, found);
  });
}

sl_status sl_engine_get_controller(sl_engine handle, sl_controller_info* info) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    sl_controller_info found SL_CONTROLLER_INFO_INIT;
    if (const culling::Controller* controller = engine->controller())
      found = {0,
               1,
               std::int32_t(controller->state()),
               0,
               controller->frames(),
               controller->switches(),
               controller->probes()};
    write(info, found);
  });
}

sl_status sl_engine_explain(sl_engine handle, sl_text* text) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    check_text(text);
    std::string lines;
    for (const engine::PlanEntry& entry : engine->plan().entries)
      lines += entry.feature + (entry.used ? ": used: " : ": left out: ") + entry.why + '\n';
    const std::string renderer = engine->renderer();
    write_text(text, lines + "renderer: " + (renderer.empty() ? "none" : renderer) + '\n');
  });
}

sl_status sl_engine_renderer(sl_engine handle, sl_text* text) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    check_text(text);
    write_text(text, engine->renderer());
  });
}

sl_status sl_engine_take_gl_errors(sl_engine handle, sl_text* text) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    check_text(text);
    tell_lines(engine->take_gl_errors(), engine.object().gl_errors, text);
  });
}

sl_status sl_engine_visible(sl_engine handle, sl_item* items, size_t capacity, size_t* count) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    check_buffer(items, capacity);
    check_result(count);
    const core::Snapshot& snapshot = engine->snapshot();
    const core::VisibleSet& visible = engine->visible();
    if (visible.count() > 0 && visible.generation != snapshot.generation())
      refuse(SL_ERROR_BUSY, "a new scene version has landed since the last frame");
    std::size_t found = 0;
    visible.for_each_slot([&](core::Slot slot) {
      if (snapshot.vacant(slot)) return;
      if (found < capacity) items[found] = to_index(snapshot.item(slot));
      ++found;
    });
    *count = found;
  });
}

// --- contexts --------------------------------------------------------------------------------------------------------

sl_status sl_engine_drop_context(sl_engine handle) {
  return with_engine(__func__, handle, Access::kEdit, [](const EngineUse& engine) {
    engine->drop_context();
#if SIGHTLINE_HAS_GL
    engine.object().context_in_use = false;
    engine.object().next_context.reset();
#endif
  });
}

sl_status sl_engine_abandon_context(sl_engine handle) {
  return with_engine(__func__, handle, Access::kEdit, [](const EngineUse& engine) {
#if SIGHTLINE_HAS_GL
    engine.object().context.reset();  // shares of it are lost from now on: they free nothing
    engine.object().next_context.reset();
    engine.object().context_in_use = false;
#endif
    engine->drop_context();
  });
}

sl_status sl_engine_use_context(sl_engine handle, sl_get_proc get_proc, void* user) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    check_drawing(true);
#if SIGHTLINE_HAS_GL
    require(get_proc != nullptr, "get_proc, found null");
    EngineObject& object = engine.object();
    if (object.context_in_use) refuse(SL_ERROR_BUSY, "the former context is in use: drop or abandon it first");
    auto context = std::make_unique<gl::Context>(value_of(gl::Context::adopt(get_proc, user)));
    value_of(engine->use_context(*context));
    object.context = std::move(context);
    object.next_context.reset();
    object.context_in_use = true;
#else
    (void)engine, (void)get_proc, (void)user;
#endif
  });
}

sl_status sl_engine_use_context_for(sl_engine handle, sl_get_proc get_proc, void* user, double seconds,
                                    int32_t* complete) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    check_drawing(true);
    check_result(complete);
    require(!std::isnan(seconds), "seconds, found no number");
#if SIGHTLINE_HAS_GL
    EngineObject& object = engine.object();
    if (object.context_in_use) refuse(SL_ERROR_BUSY, "the former context is in use: drop or abandon it first");
    if (!object.next_context) {
      require(get_proc != nullptr, "get_proc, found null");
      object.next_context = std::make_unique<gl::Context>(value_of(gl::Context::adopt(get_proc, user)));
    }
    const auto done = engine->use_context(*object.next_context, seconds);
    if (!done) object.next_context.reset();
    const bool taken = value_of(done);
    if (taken) {
      object.context = std::move(object.next_context);
      object.context_in_use = true;
    }
    *complete = taken;
#else
    (void)engine, (void)get_proc, (void)user;
#endif
  });
}

// --- images ----------------------------------------------------------------------------------------------------------

sl_status sl_engine_read_colour(sl_engine handle, uint8_t* rgb, size_t capacity) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    check_drawing(true);
#if SIGHTLINE_HAS_GL
    write_image(value_of(engine->read_colour()).pixels, rgb, capacity);
#else
    (void)engine, (void)rgb, (void)capacity;
#endif
  });
}

sl_status sl_engine_read_ids(sl_engine handle, uint32_t* ids, size_t capacity) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    check_drawing(true);
#if SIGHTLINE_HAS_GL
    write_image(value_of(engine->read_ids()).ids, ids, capacity);
#else
    (void)engine, (void)ids, (void)capacity;
#endif
  });
}

sl_status sl_engine_read_depth(sl_engine handle, const sl_view* view, float* metres, size_t capacity) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    check_drawing(true);
#if SIGHTLINE_HAS_GL
    write_image(value_of(engine->read_depth(view_of(view))).metres, metres, capacity);
#else
    (void)engine, (void)view, (void)metres, (void)capacity;
#endif
  });
}

sl_status sl_write_png(const char* path, int32_t width, int32_t height, const uint8_t* rgb) {
  return call(__func__, [&] {
#if SIGHTLINE_HAS_IMAGE
    check_size(width, height);
    require(rgb != nullptr, "pixels, found null");
    const std::size_t bytes = std::size_t(width) * std::size_t(height) * 3;
    value_of(image::write_png({width, height, {rgb, rgb + bytes}}, path_of(path)));
#else
    (void)path, (void)width, (void)height, (void)rgb;
    refuse(SL_ERROR_UNSUPPORTED, "this library was built without PNG files");
#endif
  });
}

// --- overrides -------------------------------------------------------------------------------------------------------

sl_status sl_engine_set_override(sl_engine handle, const sl_item* items, size_t item_count,
                                 const sl_item_style* style) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    const sl_item_style from = read(style, sl_item_style SL_ITEM_STYLE_INIT);
    engine::ItemStyle to;
    if (from.use_colour) to.colour = glm::make_vec3(from.colour);
    to.alpha = from.alpha;
    to.outline = from.outline != 0;
    to.ghost = from.ghost != 0;
    value_of(engine->set_override(items_of(items, item_count), to));
  });
}

sl_status sl_engine_clear_override(sl_engine handle, const sl_item* items, size_t item_count) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    const auto some = items_of(items, item_count);
    value_of(items ? engine->clear_override(some) : engine->clear_overrides());
  });
}

sl_status sl_engine_set_hidden(sl_engine handle, const sl_item* items, size_t item_count, int32_t hidden) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    const auto some = items_of(items, item_count);
    value_of(hidden ? engine->hide(some) : engine->show(some));
  });
}

namespace {

std::vector<core::NodeId> nodes_of(const EngineUse& engine, const sl_node* nodes, std::size_t count) {
  check_array(nodes, count, kMostPerScene);
  std::vector<core::NodeId> ids;
  for (std::size_t i = 0; i < count; ++i) ids.push_back(engine.scene().id(nodes[i]));
  return ids;
}

/// Refuses what set_override() and hide() do.
core::ItemId known_item(const EngineUse& engine, sl_item item) {
  if (engine->snapshot().slot(core::ItemId{item}) == core::kNone)
    throw Failure{SL_ERROR_FAILED, "engine: no item " + std::to_string(item) + " as of the last commit"};
  return core::ItemId{item};
}

void write_items(std::span<const core::ItemId> from, sl_item* items, std::size_t capacity, std::size_t* count) {
  check_buffer(items, capacity);
  check_result(count);
  const auto written = from.first(std::min(capacity, from.size()));
  std::transform(written.begin(), written.end(), items, core::to_index);
  *count = from.size();
}

}  // namespace

sl_status sl_engine_isolate(sl_engine handle, const sl_node* nodes, size_t node_count) {
  return with_engine(__func__, handle, Access::kEdit,
                     [&](const EngineUse& engine) { value_of(engine->isolate(nodes_of(engine, nodes, node_count))); });
}

sl_status sl_engine_show_all(sl_engine handle) {
  return with_engine(__func__, handle, Access::kEdit, [](const EngineUse& engine) { value_of(engine->show_all()); });
}

sl_status sl_engine_get_override(sl_engine handle, sl_item item, int32_t* there, sl_item_style* style) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    require(there != nullptr, "there, found null");
    check_result(style);
    const auto found = engine->override_of(known_item(engine, item));
    sl_item_style to SL_ITEM_STYLE_INIT;
    if (found) {
      to.use_colour = found->colour.has_value();
      for (int i = 0; found->colour && i < 3; ++i) to.colour[i] = (*found->colour)[i];
      to.alpha = found->alpha;
      to.outline = found->outline, to.ghost = found->ghost;
    }
    write(style, to);
    *there = found.has_value();
  });
}

sl_status sl_engine_overridden_items(sl_engine handle, sl_item* items, size_t capacity, size_t* count) {
  return with_engine(__func__, handle, Access::kRead,
                     [&](const EngineUse& engine) { write_items(engine->overridden_items(), items, capacity, count); });
}

sl_status sl_engine_is_hidden(sl_engine handle, sl_item item, int32_t* hidden) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    require(hidden != nullptr, "hidden, found null");
    *hidden = engine->is_hidden(known_item(engine, item));
  });
}

sl_status sl_engine_hidden_items(sl_engine handle, sl_item* items, size_t capacity, size_t* count) {
  return with_engine(__func__, handle, Access::kRead,
                     [&](const EngineUse& engine) { write_items(engine->hidden_items(), items, capacity, count); });
}

sl_status sl_engine_items_below(sl_engine handle, const sl_node* nodes, size_t node_count, sl_item* items,
                                size_t capacity, size_t* count) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    write_items(value_of(engine->items_below(nodes_of(engine, nodes, node_count))), items, capacity, count);
  });
}

// --- picks and regions -----------------------------------------------------------------------------------------------

namespace {

[[maybe_unused]] [[noreturn]] void refuse_picking() {
  refuse(SL_ERROR_UNSUPPORTED, "this library was built without the ray tracer");
}

engine::PixelRectangle rectangle_of(const double rectangle[4]) {
  require(rectangle != nullptr, "a rectangle, found null");
  return {rectangle[0], rectangle[1], rectangle[2], rectangle[3]};
}

#if SIGHTLINE_HAS_RAYTRACE
void write_pick(const std::optional<engine::Pick>& from, sl_pick* pick) {
  sl_pick found SL_PICK_INIT;
  if (from) {
    found.item = to_index(from->item);
    found.node = handle_of(from->node);
    found.t = from->t;
    for (int i = 0; i < 3; ++i) found.point[i] = from->point[i], found.normal[i] = from->normal[i];
    found.triangle = from->triangle;
    found.face = std::int32_t(from->face);
  }
  write(pick, found);
}

raytrace::RayFilter filter_of(const sl_ray& ray) {
  raytrace::RayFilter filter;
  filter.layers = ray.layers;
  filter.cuts = ray.leave_out_cuts == 0;
  filter.section_mode = enum_of<core::SectionMode>(ray.section_mode, 2, "section_mode");
  require(ray.section_count <= SL_MAX_SECTIONS, "at most SL_MAX_SECTIONS sections");
  std::transform(ray.sections, ray.sections + ray.section_count, std::back_inserter(filter.sections), plane_of);
  return filter;
}
#endif

}  // namespace

sl_status sl_engine_pick(sl_engine handle, const sl_view* view, double x, double y, sl_pick* pick) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
#if SIGHTLINE_HAS_RAYTRACE
    check_result(pick);
    write_pick(value_of(engine->pick(view_of(view), x, y)), pick);
#else
    (void)engine, (void)view, (void)x, (void)y, (void)pick;
    refuse_picking();
#endif
  });
}

sl_status sl_engine_pick_ghosts(sl_engine handle, const sl_view* view, double x, double y, sl_pick* pick) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
#if SIGHTLINE_HAS_RAYTRACE
    check_result(pick);
    write_pick(value_of(engine->pick(view_of(view), x, y, engine::Ghosts::kHit)), pick);
#else
    (void)engine, (void)view, (void)x, (void)y, (void)pick;
    refuse_picking();
#endif
  });
}

sl_status sl_engine_prepare_picks(sl_engine handle) {
  return with_engine(__func__, handle, Access::kEdit, [](const EngineUse& engine) {
#if SIGHTLINE_HAS_RAYTRACE
    engine->prepare_picks();
#else
    (void)engine;
    refuse_picking();
#endif
  });
}

sl_status sl_engine_pick_ray(sl_engine handle, const sl_ray* from, sl_pick* pick) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
#if SIGHTLINE_HAS_RAYTRACE
    check_result(pick);
    const sl_ray ray = read(from, sl_ray SL_RAY_INIT);
    const auto ghosts = ray.hit_ghosts ? engine::Ghosts::kHit : engine::Ghosts::kPassed;
    write_pick(
        value_of(engine->pick({short_vector_of(ray.origin), short_vector_of(ray.direction), ray.t_min, ray.t_max},
                              filter_of(ray), ghosts)),
        pick);
#else
    (void)engine, (void)from, (void)pick;
    refuse_picking();
#endif
  });
}

sl_status sl_engine_items_in(sl_engine handle, const sl_view* view, const double rectangle[4], int32_t rule,
                             sl_item* items, size_t capacity, size_t* count) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    check_buffer(items, capacity);
    check_result(count);
    write_list(value_of(engine->items_in(view_of(view), rectangle_of(rectangle),
                                         enum_of<culling::RegionRule>(rule, 2, "rule"))),
               items, capacity, count);
  });
}

sl_status sl_engine_items_in_planes(sl_engine handle, const sl_plane* planes, size_t plane_count, int32_t rule,
                                    uint32_t layers, sl_item* items, size_t capacity, size_t* count) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    check_buffer(items, capacity);
    check_result(count);
    check_array(planes, plane_count, SL_MAX_SECTIONS);
    std::vector<core::Plane> translated(plane_count);
    std::transform(planes, planes + plane_count, translated.begin(), plane_of);
    write_list(value_of(engine->items_in(std::move(translated), enum_of<culling::RegionRule>(rule, 2, "rule"), layers)),
               items, capacity, count);
  });
}

sl_status sl_engine_visible_items_in(sl_engine handle, const sl_view* view, const double rectangle[4], int32_t samples,
                                     sl_visible_item* items, size_t capacity, size_t* count) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
#if SIGHTLINE_HAS_RAYTRACE
    check_buffer(items, capacity);
    check_result(count);
    require(samples >= 1 && samples <= 1024, "1 to 1024 samples a pixel");
    write_list(value_of(engine->visible_items_in(view_of(view), rectangle_of(rectangle), samples)), items, capacity,
               count, [](const raytrace::VisibleItem& item) {
                 return sl_visible_item{to_index(item.item), 0, item.samples};
               });
#else
    (void)engine, (void)view, (void)rectangle, (void)samples, (void)items, (void)capacity, (void)count;
    refuse_picking();
#endif
  });
}
