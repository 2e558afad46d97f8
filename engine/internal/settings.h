// What engines make of settings: internal/settings.inc has their ranges, and looks.h the looks. Internal to engine.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <type_traits>

#include "sightline/core/error.h"
#include "sightline/engine/engine_config.h"

namespace sightline::render {
class Renderer;
}

namespace sightline::engine {

struct PagedConfig;

// Bounds in settings.inc.
inline constexpr double kAny = std::numeric_limits<double>::infinity();
inline constexpr double kFinite = std::numeric_limits<double>::max();
inline constexpr double kMostFloat = double(std::numeric_limits<float>::max());

/// What numbers a setting may have; any where `low` is not below `high`.
struct SettingRange {
  const char* name;
  double low, high;
  const char* words;
};

/// Fails on a number out of range, also of a colour, saying what was expected. Other types have no ranges.
template <class T>
core::Expected<void> check_range(const SettingRange& range, const T& value) {
  const auto has = [&](double number) { return number >= range.low && number <= range.high; };
  bool good = true;
  if constexpr (std::is_same_v<T, core::vec3>)
    good = has(value.r) && has(value.g) && has(value.b);
  else if constexpr (std::is_same_v<T, int> || std::is_floating_point_v<T>)
    good = has(double(value));
  if (good || range.low >= range.high) return {};
  return core::fail(std::string("engine: ") + range.name + " must be " + range.words);
}

/// Fails on what is out of range.
core::Expected<void> check_ranges(const EngineConfig& config);
/// Fails also on settings that a paged engine does not have.
core::Expected<void> check_ranges(const PagedConfig& config);

/// Fails on what images by rays do not have.
core::Expected<void> check_rays(const EngineConfig& config);

/// Whether rays draw until the application has given a context.
bool traces_until_context(const EngineConfig& config);

/// The name of a fixed setting in which they differ; null where there is none.
const char* fixed_setting_that_differs(const EngineConfig& a, const EngineConfig& b);

/// The background of some rows of an image: 0 is its upper border, 1 its lower.
inline gpuprims::Background rows_of(const gpuprims::Background& whole, const std::array<double, 2>& rows) {
  return {glm::mix(whole.top, whole.bottom, float(rows[1])), glm::mix(whole.top, whole.bottom, float(rows[0]))};
}
/// Makes a renderer draw with these looks. `rows`: where the image reaches in that of which it is a part, 0 at its
/// upper border and 1 at its lower.
void give_looks(const Looks& looks, render::Renderer& to, const std::array<double, 2>& rows = {0.0, 1.0});

}  // namespace sightline::engine
