// Engines of scenes that are larger than memory.
#include <cmath>

#include "sightline/bindings/c/internal/engines.h"
#if SIGHTLINE_CAPI_HAS_PAGES
#include "sightline/importers/slc/paged_scene.h"
#include "sightline/render/image/image.h"
#endif

using namespace sightline;
using namespace sightline::capi;

namespace {

/// Runs `run` with the engine while nobody else uses it. It is a generic lambda, which no build without pages compiles.
template <class Run>
sl_status with_pages(const char* function, sl_paged_engine handle, const Run& run) {
  return call(function, [&] {
#if SIGHTLINE_CAPI_HAS_PAGES
    const std::shared_ptr<PagedEngineObject> object = find(handle);
    const PagedEngineUse use(*object);
    run(*object);
#else
    (void)handle, (void)run;
    refuse(SL_ERROR_UNSUPPORTED, "this library was built without drawing or without importers");
#endif
  });
}

#if SIGHTLINE_CAPI_HAS_PAGES

sl_paged_report report_of(const engine::PagedReport& from) {
  sl_paged_report report SL_PAGED_REPORT_INIT;
  report.complete = from.complete;
  report.frame = from.frame;
  report.frame_ms = from.frame_ms;
  report.leaves = from.leaves, report.pending = from.pending;
  report.placeholders = from.placeholders, report.coarse_items = from.coarse_items;
  report.items_drawn = from.items_drawn;
  report.resident = from.resident, report.coarse_resident = from.coarse_resident;
  report.loaded = from.loaded, report.coarse_loaded = from.coarse_loaded;
  report.evicted = from.evicted, report.prefetched = from.prefetched, report.failed = from.failed;
  report.memory = from.memory;
  report.coarseness = from.coarseness, report.earlier = from.earlier;
  return report;
}

core::PagedScene open(const char* path, const sl_paged_config& config) {
  bool cancelled = false;
  const auto told = progress_of(config.progress, config.progress_user);
  const auto progress = [&](double share) {
    cancelled = !told(share);
    return !cancelled;
  };
  auto scene = importers::open_paged_scene(path_of(path), told ? std::function<bool(double)>(progress) : told);
  if (!scene && cancelled) throw Failure{SL_ERROR_CANCELLED, std::move(scene.error().message)};
  return value_of(std::move(scene));
}

#endif

}  // namespace

sl_status sl_paged_engine_create(const char* path, const sl_paged_config* config, sl_paged_engine* engine) {
  return call(__func__, [&] {
#if SIGHTLINE_CAPI_HAS_PAGES
    check_result(engine);
    const sl_paged_config chosen = read(config, sl_paged_config SL_PAGED_CONFIG_INIT);
    auto object = std::make_shared<PagedEngineObject>();
    object->config = config_of(chosen);
    object->engine.emplace(value_of(engine::PagedEngine::create(open(path, chosen), object->config)));
    *engine = add_paged_engine(std::move(object));
#else
    (void)path, (void)config, (void)engine;
    refuse(SL_ERROR_UNSUPPORTED, "this library was built without drawing or without importers");
#endif
  });
}

sl_status sl_paged_engine_destroy(sl_paged_engine handle) {
#if SIGHTLINE_CAPI_HAS_PAGES
  return with_pages(__func__, handle, [&](auto&) { (void)remove(handle); });
#else
  return with_pages(__func__, handle, nullptr);
#endif
}

sl_status sl_paged_engine_frame(sl_paged_engine handle, const sl_view* view, sl_paged_report* report) {
  return with_pages(__func__, handle, [&](auto& object) {
    if (report) check_result(report);
    const auto done = value_of(object.engine->frame(view_of(view)));
    object.drawn = true;
    if (report) write(report, report_of(done));
  });
}

sl_status sl_paged_engine_wait(sl_paged_engine handle, double seconds, int32_t* arrived) {
  return with_pages(__func__, handle, [&](auto& object) {
    check_result(arrived);
    require(!std::isnan(seconds), "seconds, found no number");
    *arrived = object.engine->wait(seconds);
  });
}

sl_status sl_paged_engine_settle(sl_paged_engine handle, const sl_view* view,
                                 int32_t (*progress)(double share, void* user), void* user, sl_paged_report* report) {
  return with_pages(__func__, handle, [&](auto& object) {
    if (report) check_result(report);
    const auto told = progress_of(progress, user);
    const auto step = [&](const auto& so_far) {
      return !told || told(1.0 - double(so_far.pending) / double(std::max<std::int64_t>(1, so_far.leaves)));
    };
    const auto done = value_of(object.engine->settle(view_of(view), step));
    object.drawn = true;
    if (report) write(report, report_of(done));
  });
}

sl_status sl_paged_engine_get(sl_paged_engine handle, sl_paged_info* info) {
  return with_pages(__func__, handle, [&](auto& object) {
    check_result(info);
    const auto& scene = object.engine->scene();
    const auto memory = object.engine->memory();
    write(info, {0, object.config.width, object.config.height, std::uint32_t(scene.pages.size()), scene.items,
                 box_of(scene.fitted.bounds), memory.pages, memory.limit});
  });
}

sl_status sl_paged_engine_renderer(sl_paged_engine handle, sl_text* text) {
  return with_pages(__func__, handle, [&](auto& object) {
    check_text(text);
    write_text(text, object.engine->renderer());
  });
}

sl_status sl_paged_engine_take_errors(sl_paged_engine handle, sl_text* text) {
  return with_pages(__func__, handle, [&](auto& object) {
    check_text(text);
    tell_lines(object.engine->take_errors(), object.errors, text);
  });
}

sl_status sl_paged_engine_take_gl_errors(sl_paged_engine handle, sl_text* text) {
  return with_pages(__func__, handle, [&](auto& object) {
    check_text(text);
    tell_lines(object.engine->take_gl_errors(), object.gl_errors, text);
  });
}

namespace {

/// Runs `read` with an engine that has drawn.
template <class Read>
sl_status read_image(const char* function, sl_paged_engine handle, const Read& read) {
  return with_pages(function, handle, [&](auto& object) {
    if (!object.drawn) refuse(SL_ERROR_BUSY, "there is no image before the first frame");
    read(object);
  });
}

}  // namespace

sl_status sl_paged_engine_read_colour(sl_paged_engine handle, uint8_t* rgb, size_t capacity) {
  return read_image(__func__, handle,
                    [&](auto& object) { write_image(object.engine->read_colour().pixels, rgb, capacity); });
}

sl_status sl_paged_engine_read_ids(sl_paged_engine handle, uint32_t* ids, size_t capacity) {
  return read_image(__func__, handle, [&](auto& object) {
    require(object.config.drawing.ids, "an engine whose drawing.ids is set");
    write_image(object.engine->read_ids().ids, ids, capacity);
  });
}

sl_status sl_paged_engine_read_depth(sl_paged_engine handle, float* metres, size_t capacity) {
  return read_image(__func__, handle,
                    [&](auto& object) { write_image(object.engine->read_depth().metres, metres, capacity); });
}
