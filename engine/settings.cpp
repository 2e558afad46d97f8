#include "sightline/engine/internal/settings.h"

#include "sightline/core/affine.h"
#include "sightline/engine/paged/paged_engine.h"

namespace sightline::engine {
namespace {

core::Expected<void> check_sun(const core::dvec3& sun) {
  if (core::is_finite(sun) && sun != core::dvec3(0.0)) return {};
  return core::fail("engine: sun must be a finite direction, and not zero");
}

}  // namespace

#define SIGHTLINE_CHECK(path, name, type, change, low, high, range, ...) \
  if (auto good = check_range({#name, low, high, range}, config.path); !good) return good;

core::Expected<void> check_ranges(const EngineConfig& config) {
#define SIGHTLINE_SETTING SIGHTLINE_CHECK
#define SIGHTLINE_ENGINE_SETTING SIGHTLINE_CHECK
#define SIGHTLINE_UNPAGED_SETTING SIGHTLINE_CHECK
#include "sightline/engine/internal/settings.inc"
  return check_sun(config.drawing.looks.sun);
}

core::Expected<void> check_ranges(const PagedConfig& config) {
  const PagedConfig defaults;
#define SIGHTLINE_SETTING SIGHTLINE_CHECK
#define SIGHTLINE_PAGED_SETTING SIGHTLINE_CHECK
#define SIGHTLINE_UNPAGED_SETTING(path, name, ...) \
  if (!(config.path == defaults.path)) return core::fail("engine: a paged engine has no " #name);
#include "sightline/engine/internal/settings.inc"
  if (config.context.application) return core::fail("engine: a paged engine makes its own context");
  return check_sun(config.drawing.looks.sun);
}

core::Expected<void> check_rays([[maybe_unused]] const EngineConfig& config) {
#if SIGHTLINE_HAS_GL && SIGHTLINE_HAS_RAYTRACE
  const CullerChoice culler = config.culling.culler;
  const char* const other = config.drawing.looks.hatching.any()                     ? "hatching"
                            : config.drawing.transparency == Transparency::kBlended ? "blended transparency"
                            : config.drawing.culled_colour                          ? "culled_colour"
                            : config.context.application || config.context.later    ? "the application's context"
                            : culler == CullerChoice::kGpu                          ? "culler gpu"
                            : culler == CullerChoice::kHybrid                       ? "culler hybrid"
                                                                                    : nullptr;
  if (!other) return {};
  return core::fail(std::string("engine: renderer rays has no ") + other + ", which needs renderer gl");
#else
  return core::fail(
      "engine: renderer rays needs a build with the ray tracer and images (SIGHTLINE_RAYTRACE, SIGHTLINE_GL)");
#endif
}

bool traces_until_context([[maybe_unused]] const EngineConfig& config) {
#if SIGHTLINE_HAS_GL && SIGHTLINE_HAS_RAYTRACE
  return config.draw && config.context.later && config.drawing.renderer == Renderer::kAutomatic;
#else
  return false;
#endif
}

const char* fixed_setting_that_differs(const EngineConfig& a, const EngineConfig& b) {
  if (a.context.application != b.context.application) return "context";
  if (a.runner != b.runner) return "runner";
#define SIGHTLINE_DIFFERS_FIXED(path, name) \
  if (!(a.path == b.path)) return #name;
#define SIGHTLINE_DIFFERS_CHANGEABLE(path, name)
#define SIGHTLINE_SETTING(path, name, type, change, ...) SIGHTLINE_DIFFERS_##change(path, name)
#define SIGHTLINE_ENGINE_SETTING SIGHTLINE_SETTING
#define SIGHTLINE_UNPAGED_SETTING SIGHTLINE_SETTING
#include "sightline/engine/internal/settings.inc"
  return nullptr;
}

}  // namespace sightline::engine
