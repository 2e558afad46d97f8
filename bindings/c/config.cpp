// Settings of engines: those of a new one, what they are, and other ones.
#include <cmath>

#include <glm/gtc/type_ptr.hpp>

#include "sightline/bindings/c/internal/engines.h"

using namespace sightline;
using namespace sightline::capi;

namespace sightline::capi {
namespace {

constexpr std::int32_t kGpuVariants = 3;

culling::ControllerConfig controller_of(const sl_controller_config* given) {
  const sl_controller_config from = read(given, sl_controller_config SL_CONTROLLER_CONFIG_INIT);
  for (const double number : {from.least_gpu_cull_ms, from.margin, from.dwell_margin, from.probe_share, from.probe_cost,
                              from.presumed_gpu_excess})
    require(std::isfinite(number) && number >= 0.0, "finite numbers from 0 on in a controller");
  return {.least_gpu_cull_ms = from.least_gpu_cull_ms,
          .margin = from.margin,
          .dwell_margin = from.dwell_margin,
          .dwell_frames = from.dwell_frames,
          .probe_share = from.probe_share,
          .first_probes = from.first_probes,
          .probe_cost = from.probe_cost,
          .probe_interval = from.probe_interval,
          .silent_frames = from.silent_frames,
          .presumed_gpu_excess = from.presumed_gpu_excess};
}

sl_controller_config controller_of(const culling::ControllerConfig& from) {
  return {sizeof(sl_controller_config),
          from.dwell_frames,
          from.least_gpu_cull_ms,
          from.margin,
          from.dwell_margin,
          from.probe_share,
          from.probe_cost,
          from.presumed_gpu_excess,
          from.first_probes,
          from.probe_interval,
          from.silent_frames,
          0};
}

template <class T>
void write_vector(const glm::vec<3, T>& from, T* to) {
  std::copy_n(glm::value_ptr(from), 3, to);
}

sl_engine_config config_of(const engine::EngineConfig& from) {
  sl_engine_config to SL_ENGINE_CONFIG_INIT;
  to.culler = sl_culler(from.culling.culler);
  to.draw = from.draw;
  to.width = from.width, to.height = from.height;
  to.ids = from.drawing.ids;
  to.sample_test = from.culling.sample_test;
  to.occlusion = std::int32_t(from.culling.occlusion);
  to.contribution_mode = std::int32_t(from.losses.contribution_mode);
  to.min_projected_area = from.losses.min_projected_area;
  to.budget_ms = from.losses.budget_ms;
  to.lod_error = from.losses.lod_error;
  to.samples = from.drawing.samples;
  to.use_culled_colour = from.drawing.culled_colour.has_value();
  write_vector(from.drawing.culled_colour.value_or(core::vec3(0.0f)), to.culled_colour);
  to.rebuild_share = float(from.culling.rebuild_share);
  to.gl_state = std::int32_t(from.context.gl_state);
  to.context_platform = std::int32_t(from.context.platform);
  to.transparency = std::int32_t(from.drawing.transparency);
  write_vector(from.drawing.outline_colour, to.outline_colour);
  to.depth_shading = from.drawing.looks.depth_shading.strength,
  to.edge_lines = from.drawing.looks.depth_shading.edge_lines;
  to.hatching_strength = from.drawing.looks.hatching.strength,
  to.hatching_spacing = from.drawing.looks.hatching.spacing;
  to.lighting = std::int32_t(from.drawing.looks.lighting);
  write_vector(from.drawing.looks.sun, to.sun);
  write_vector(from.drawing.looks.background.bottom, to.background_bottom);
  write_vector(from.drawing.looks.background.top, to.background_top);
  to.part_index = from.culling.part.index, to.part_count = from.culling.part.count;
  to.gl_debug = from.context.debug;
  to.context_later = from.context.later;
  const auto variant = from.culling.gpu_culler.variant;
  to.gpu_variant = variant ? SL_GPU_VARIANT_GEOMETRY + std::int32_t(*variant) : SL_GPU_VARIANT_MEASURED;
  return to;
}

}  // namespace

engine::EngineConfig config_of(const sl_engine_config& from, const culling::ControllerConfig& controller) {
  engine::EngineConfig config;
  config.culling.culler = enum_of<engine::CullerChoice>(from.culler, 5, "culler");
  config.draw = from.draw != 0;
  check_size(from.width, from.height);
  config.width = from.width, config.height = from.height;
  config.drawing.ids = from.ids != 0;
  config.culling.sample_test = from.sample_test != 0;
  config.culling.occlusion = enum_of<engine::OcclusionChoice>(from.occlusion, 3, "occlusion");
  config.losses.min_projected_area = from.min_projected_area;
  config.losses.contribution_mode = enum_of<engine::ContributionMode>(from.contribution_mode, 3, "contribution_mode");
  config.losses.budget_ms = from.budget_ms;
  config.losses.lod_error = from.lod_error;
  if (from.use_culled_colour) config.drawing.culled_colour = glm::make_vec3(from.culled_colour);
  config.drawing.samples = from.samples;
  config.context.gl_state = enum_of<engine::GlState>(from.gl_state, 2, "gl_state");
  config.context.platform = enum_of<gl::ContextPlatform>(from.context_platform, 5, "context_platform");
  if (from.program_cache) config.context.program_cache = path_of(from.program_cache);
  config.culling.rebuild_share = double(from.rebuild_share);
  config.drawing.transparency = enum_of<engine::Transparency>(from.transparency, 2, "transparency");
  config.drawing.outline_colour = glm::make_vec3(from.outline_colour);
  config.drawing.looks.depth_shading = {from.depth_shading, from.edge_lines};
  config.drawing.looks.hatching = {from.hatching_strength, from.hatching_spacing};
  config.drawing.looks.lighting = enum_of<core::Lighting>(from.lighting, 3, "lighting");
  config.drawing.looks.sun = glm::make_vec3(from.sun);
  config.drawing.looks.background = {glm::make_vec3(from.background_bottom), glm::make_vec3(from.background_top)};
  config.culling.part = {from.part_index, from.part_count};
  config.context.debug = from.gl_debug != 0;
  config.context.later = from.context_later != 0;
  const auto variant = enum_of<std::int32_t>(from.gpu_variant, kGpuVariants, "gpu_variant");
  if (variant != SL_GPU_VARIANT_MEASURED)
    config.culling.gpu_culler.variant = culling::GpuVariant(variant - SL_GPU_VARIANT_GEOMETRY);
  config.culling.controller = from.controller ? controller_of(from.controller) : controller;
  check_drawing(config.draw || from.get_proc || config.culling.culler == engine::CullerChoice::kGpu ||
                config.culling.culler == engine::CullerChoice::kHybrid);
  return config;
}

}  // namespace sightline::capi

sl_status sl_engine_get_config(sl_engine handle, sl_engine_config* config, sl_controller_config* controller) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    check_result(config);
    if (controller) check_result(controller);
    write(config, config_of(engine->config()));
    if (controller) write(controller, controller_of(engine->config().culling.controller));
  });
}

sl_status sl_engine_configure(sl_engine handle, const sl_engine_config* config) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    const engine::EngineConfig& now = engine->config();
    sl_engine_config chosen = read(config, sl_engine_config SL_ENGINE_CONFIG_INIT);
    chosen.get_proc = nullptr;
    chosen.program_cache = nullptr;
    engine::EngineConfig translated = config_of(chosen, now.culling.controller);
    translated.context.application = now.context.application;
    translated.context.program_cache = now.context.program_cache;
    value_of(engine->configure(translated));
  });
}
