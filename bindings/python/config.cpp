#include "sightline/bindings/python/config.h"

#include "sightline/bindings/python/setting_values.h"
#include "sightline/engine/internal/settings.h"
#include "sightline/gl/context.h"

namespace sightline::python {
namespace {

using culling::ControllerConfig;
using engine::EngineConfig, engine::PagedConfig;
using engine::kAny, engine::kFinite, engine::kMostFloat;

constexpr const char* kControllerHelp = "When a hybrid lets the CPU cull and when the GPU; None: the defaults";

/// The engine's controller says what follows `draw`.
py::object get_controller(const EngineConfig& config) {
  ControllerConfig told = config.culling.controller;
  told.rendering = true;
  return py::cast(told);
}

void set_controller(EngineConfig& config, const char* name, py::handle value) {
  config.culling.controller = value.is_none() ? ControllerConfig() : cast<ControllerConfig>(name, value);
}

constexpr Setting<EngineConfig> kEngineSettings[] = {
#define SIGHTLINE_SETTING(path, name, type, change, low, high, range, initial, help) \
  SIGHTLINE_ROW(EngineConfig, path, name, change, range, initial, help)
#define SIGHTLINE_UNPAGED_SETTING SIGHTLINE_SETTING
#define SIGHTLINE_ENGINE_SETTING SIGHTLINE_SETTING
#include "sightline/engine/internal/settings.inc"
    {"controller", kControllerHelp, "", true, false, false, get_controller, set_controller}};

constexpr Setting<PagedConfig> kPagedSettings[] = {
#define SIGHTLINE_SETTING(path, name, type, change, low, high, range, initial, help) \
  SIGHTLINE_ROW(PagedConfig, path, name, change, range, initial, help)
#define SIGHTLINE_PAGED_SETTING SIGHTLINE_SETTING
#include "sightline/engine/internal/settings.inc"
};

constexpr Setting<ControllerConfig> kControllerSettings[] = {
#define SIGHTLINE_CONTROLLER_SETTING(path, name, type, change, low, high, range, initial, help) \
  {#name,                                                                                       \
   help,                                                                                        \
   range,                                                                                       \
   true,                                                                                        \
   false,                                                                                       \
   true,                                                                                        \
   [](const ControllerConfig& config) { return get(config.name); },                             \
   [](ControllerConfig& config, const char* argument, py::handle value) {                       \
     auto given = config.name;                                                                  \
     set(given, argument, value);                                                               \
     unwrap(engine::check_range({#name, low, high, range}, given));                             \
     config.name = given;                                                                       \
   }},
#include "sightline/engine/internal/settings.inc"
};

}  // namespace

template <>
std::span<const Setting<EngineConfig>> settings() {
  return kEngineSettings;
}
template <>
std::span<const Setting<PagedConfig>> settings() {
  return kPagedSettings;
}
template <>
std::span<const Setting<ControllerConfig>> settings() {
  return kControllerSettings;
}

py::dict to_dict(const EngineConfig& config) {
  py::dict all;
  for (const auto& setting : settings<EngineConfig>()) all[setting.name] = setting.get(config);
  return all;
}

// --- the controller --------------------------------------------------------------------------------------------------

namespace {

py::tuple state_of_controller(const ControllerConfig& config) {
  py::list numbers;
  for (const auto& setting : settings<ControllerConfig>()) numbers.append(setting.get(config));
  return py::tuple(numbers);
}

ControllerConfig controller_of_state(const py::tuple& state) {
  const auto numbers = settings<ControllerConfig>();
  if (state.size() != numbers.size()) fail("pickle: it is of another version");
  ControllerConfig config;
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i].set(config, numbers[i].name, state[i]);
  return config;
}

}  // namespace

void bind_controller_config(py::module_& m) {
  py::class_<ControllerConfig> c(m, "ControllerConfig", "When a hybrid lets the CPU cull and when the GPU.");
  const std::string doc =
      doc_of<ControllerConfig>("__init__", "", "", "Takes the culler that costs the frame less, by measured times.");
  py::options options;
  options.disable_function_signatures();
  c.def(py::init([](const py::kwargs& given) { return config_of<ControllerConfig>("ControllerConfig", given); }),
        doc.c_str());
  options.enable_function_signatures();
  for (const auto& setting : settings<ControllerConfig>())
    c.def_property(setting.name,
                   py::cpp_function([&setting](const ControllerConfig& config) { return setting.get(config); }),
                   py::cpp_function([&setting](ControllerConfig& config, const py::object& value) {
                     setting.set(config, setting.name, value);
                   }),
                   setting.help);
  c.def(
       "__eq__", [](const ControllerConfig& a, const ControllerConfig& b) { return a == b; }, py::is_operator())
      .def(py::pickle(&state_of_controller, &controller_of_state));
}

}  // namespace sightline::python
