// Settings of engines: those of a new one, what they are, and other ones. The structs of C have the members of C++.
#include "sightline/bindings/c/internal/engines.h"
#include "sightline/bindings/c/internal/settings.h"

using namespace sightline;
using namespace sightline::capi;

namespace sightline::capi {

using engine::kAny, engine::kFinite, engine::kMostFloat;

engine::EngineConfig config_of(const sl_engine_config& from) {
  check_size(from.width, from.height);
  engine::EngineConfig to;
#define SIGHTLINE_SETTING(path, name, ...) take(#name, from.path, to.path);
#define SIGHTLINE_UNPAGED_SETTING SIGHTLINE_SETTING
#define SIGHTLINE_ENGINE_SETTING SIGHTLINE_SETTING
#define SIGHTLINE_CONTROLLER_SETTING(path, name, type, change, low, high, range, ...) \
  take({#name, low, high, range}, from.path, to.path);
#include "sightline/engine/internal/settings.inc"
  check_drawing(to.draw || from.get_proc || to.culling.culler == engine::CullerChoice::kGpu ||
                to.culling.culler == engine::CullerChoice::kHybrid);
  return to;
}

engine::PagedConfig config_of(const sl_paged_config& from) {
  check_size(from.width, from.height);
  require(from.memory_limit > 0, "a memory_limit above 0");
  engine::PagedConfig to;
#define SIGHTLINE_SETTING(path, name, ...) take(#name, from.path, to.path);
#define SIGHTLINE_UNPAGED_SETTING SIGHTLINE_SETTING
#define SIGHTLINE_PAGED_SETTING SIGHTLINE_SETTING
#include "sightline/engine/internal/settings.inc"
  return to;
}

}  // namespace sightline::capi

sl_status sl_engine_get_config(sl_engine handle, sl_engine_config* config) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    check_result(config);
    const engine::EngineConfig& from = engine->config();
    sl_engine_config to SL_ENGINE_CONFIG_INIT;
#define SIGHTLINE_SETTING(path, ...) give(from.path, to.path);
#define SIGHTLINE_UNPAGED_SETTING SIGHTLINE_SETTING
#define SIGHTLINE_ENGINE_SETTING SIGHTLINE_SETTING
#define SIGHTLINE_CONTROLLER_SETTING SIGHTLINE_SETTING
#include "sightline/engine/internal/settings.inc"
    write(config, to);
  });
}

sl_status sl_engine_configure(sl_engine handle, const sl_engine_config* config) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    sl_engine_config chosen = read(config, sl_engine_config SL_ENGINE_CONFIG_INIT);
    chosen.get_proc = nullptr;
    chosen.context.program_cache = nullptr;
    engine::EngineConfig translated = config_of(chosen);
    translated.context.application = engine->config().context.application;
    translated.context.program_cache = engine->config().context.program_cache;
    value_of(engine->configure(translated));
  });
}
