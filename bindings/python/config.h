// Settings of engines, imports and written files as keyword arguments, and as they are told: those of
// internal/settings.inc of engine and importers.
#pragma once

#include <span>
#include <string>

#include "sightline/bindings/python/convert.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/paged/paged_engine.h"

namespace sightline::python {

template <class Config>
struct Setting {
  const char* name;
  const char* help;
  const char* range;  ///< of numbers; may be empty
  bool changeable;    ///< by configure()
  bool required;      ///< there is no default
  bool initial;       ///< signatures show the default; else None
  py::object (*get)(const Config& config);
  /// Fails, or throws a type_error, on what is no such value.
  void (*set)(Config& config, const char* name, py::handle value);
};

/// All of an engine::EngineConfig, an engine::PagedConfig, a culling::ControllerConfig, an importers::ImportOptions or
/// an importers::WriteOptions.
template <class Config>
std::span<const Setting<Config>> settings();

/// Sets those that a call has given; Ellipsis leaves a setting as it is. Throws a type_error on other names.
template <class Config>
void set_given(Config& config, const char* function, const py::kwargs& given, bool only_changeable = false) {
  for (const auto& [key, value] : given) {
    const std::string name = py::str(key);
    const Setting<Config>* found = nullptr;
    for (const Setting<Config>& setting : settings<Config>())
      if (name == setting.name && (setting.changeable || !only_changeable)) found = &setting;
    if (!found) throw py::type_error(std::string(function) + "() has no argument " + name);
    if (!value.is(py::ellipsis())) found->set(config, found->name, value);
  }
}

/// The settings of a constructor's call.
template <class Config>
Config config_of(const char* function, const py::kwargs& given) {
  for (const Setting<Config>& setting : settings<Config>())
    if (setting.required && !given.contains(setting.name))
      throw py::type_error(std::string(function) + "() needs the argument " + setting.name);
  Config config;
  set_given(config, function, given);
  return config;
}

/// The docstring of a function that takes settings, with the signature that pybind11 does not know, as it would write
/// it: `before` and `after` are arguments beside them, as "scene: Scene" and "progress: object = None".
template <class Config>
std::string doc_of(const std::string& function, const std::string& before, const std::string& after,
                   const std::string& text, bool only_changeable = false, const std::string& result = "None") {
  std::string arguments = function + "(self: object, " + before + (before.empty() ? "*" : ", *"), words = text + "\n";
  const Config defaults;
  for (const Setting<Config>& setting : settings<Config>()) {
    if (only_changeable && !setting.changeable) continue;
    arguments += std::string(", ") + setting.name + ": object";
    if (only_changeable)
      arguments += " = Ellipsis";
    else if (!setting.required)
      arguments += " = " + std::string(py::repr(setting.initial ? setting.get(defaults) : py::none()));
    const std::string range = *setting.range ? std::string(" (") + setting.range + ")" : std::string();
    words += std::string("\n") + setting.name + ": " + setting.help + range + ".";
  }
  return arguments + (after.empty() ? "" : ", " + after) + ") -> " + result + "\n\n" + words;
}

/// All settings by name.
py::dict to_dict(const engine::EngineConfig& config);

void bind_controller_config(py::module_& m);

}  // namespace sightline::python
