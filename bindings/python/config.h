// Settings of engines as keyword arguments: of the constructor, of configure(), and as they are told.
#pragma once

#include <array>
#include <span>

#include "sightline/bindings/python/convert.h"
#include "sightline/engine/engine.h"

namespace sightline::python {

struct Setting {
  const char* name;
  py::object (*get)(const engine::EngineConfig& config);
  /// Fails, or throws a type_error, on what is no such value.
  void (*set)(engine::EngineConfig& config, const char* name, py::handle value);
};

inline constexpr std::size_t kFixedSettings = 14, kChangeableSettings = 18;
/// Settings that an engine has from its creation on.
extern const std::array<Setting, kFixedSettings> kFixed;
/// Settings that Engine::configure() changes.
extern const std::array<Setting, kChangeableSettings> kChangeable;

/// The default as signatures show it.
py::object default_of(const Setting& setting);
/// Settings whose value is Ellipsis stay as they are.
void set_all(engine::EngineConfig& config, std::span<const Setting> settings, std::span<const py::object> values);
/// All settings by name.
py::dict settings_of(const engine::EngineConfig& config);

void bind_controller_config(py::module_& m);

}  // namespace sightline::python
