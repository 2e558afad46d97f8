#include "sightline/bindings/python/config.h"

#include <cmath>

#include "sightline/bindings/python/names.h"
#include "sightline/gl/context.h"

namespace sightline::python {
namespace {

using culling::ControllerConfig;
using engine::EngineConfig;

template <class T>
constexpr const char* kExpected = "a text";
template <>
constexpr const char* kExpected<bool> = "True or False";
template <>
constexpr const char* kExpected<int> = "a whole number";
template <>
constexpr const char* kExpected<float> = "a number";
template <>
constexpr const char* kExpected<double> = "a number";
template <>
constexpr const char* kExpected<std::filesystem::path> = "a path or None";
template <>
constexpr const char* kExpected<std::pair<int, int>> = "two whole numbers";
template <>
constexpr const char* kExpected<ControllerConfig> = "a ControllerConfig or None";

template <class T>
T cast(const char* name, py::handle value) {
  py::detail::make_caster<T> caster;
  if (!caster.load(value, true))
    throw py::type_error(std::string(name) + ": expected " + kExpected<T> + ", found " +
                         std::string(py::str(py::type::of(value).attr("__name__"))));
  return py::detail::cast_op<T>(std::move(caster));
}

/// A field, or a field of a struct that is a field: pointers to members, the outer one first.
template <auto... kPath>
struct Field {
  template <class T>
  static auto& of(T& value) {
    return (value.*....*kPath);
  }
};
template <class F, class T>
using FieldType = std::remove_cvref_t<decltype(F::of(std::declval<T&>()))>;

/// A setting that is a number or a truth.
template <auto... kPath>
constexpr Setting plain(const char* name) {
  using F = Field<kPath...>;
  return {
      name, [](const EngineConfig& c) -> py::object { return py::cast(F::of(c)); },
      [](EngineConfig& c, const char* n, py::handle value) { F::of(c) = cast<FieldType<F, EngineConfig>>(n, value); }};
}

/// One that is one of several names.
template <auto... kPath>
constexpr Setting named(const char* name) {
  using F = Field<kPath...>;
  return {name, [](const EngineConfig& c) -> py::object { return py::str(std::string(name_of(F::of(c)))); },
          [](EngineConfig& c, const char* n, py::handle value) {
            F::of(c) = enumerator_of<FieldType<F, EngineConfig>>(n, cast<std::string>(n, value));
          }};
}

py::object colour(const core::vec3& c) {
  return py::make_tuple(c.x, c.y, c.z);
}

template <auto kColour>
constexpr Setting background(const char* name) {
  return {name, [](const EngineConfig& c) -> py::object { return colour(c.drawing.looks.background.*kColour); },
          [](EngineConfig& c, const char* n, py::handle value) {
            c.drawing.looks.background.*kColour = core::vec3(vector3(value, n));
          }};
}

/// Thresholds and shares.
ControllerConfig checked(const ControllerConfig& config) {
  for (const double number : {config.least_gpu_cull_ms, config.margin, config.dwell_margin, config.probe_share,
                              config.probe_cost, config.presumed_gpu_excess})
    if (!std::isfinite(number) || number < 0.0)
      fail("controller: expected finite numbers from 0 on, found " + std::string(py::repr(py::float_(number))));
  return config;
}

}  // namespace

const std::array<Setting, kFixedSettings> kFixed = {
    plain<&EngineConfig::draw>("draw"),
    plain<&EngineConfig::width>("width"),
    plain<&EngineConfig::height>("height"),
    plain<&EngineConfig::drawing, &engine::DrawingConfig::ids>("ids"),
    plain<&EngineConfig::drawing, &engine::DrawingConfig::samples>("samples"),
    named<&EngineConfig::drawing, &engine::DrawingConfig::transparency>("transparency"),
    Setting{
        "part",
        [](const EngineConfig& c) -> py::object { return py::make_tuple(c.culling.part.index, c.culling.part.count); },
        [](EngineConfig& c, const char* name, py::handle value) {
          const auto [index, count] = cast<std::pair<int, int>>(name, value);
          c.culling.part = {index, count};
        }},
    plain<&EngineConfig::culling, &engine::CullingConfig::rebuild_share>("rebuild_share"),
    Setting{"gpu_pass",
            [](const EngineConfig& c) -> py::object {
              const auto variant = c.culling.gpu_culler.variant;
              return variant ? py::object(py::str(std::string(name_of(*variant)))) : py::none();
            },
            [](EngineConfig& c, const char* name, py::handle value) {
              c.culling.gpu_culler.variant = {};
              if (!value.is_none())
                c.culling.gpu_culler.variant = enumerator_of<culling::GpuVariant>(name, cast<std::string>(name, value));
            }},
    Setting{"context",
            [](const EngineConfig& c) -> py::object { return py::str(std::string(name_of(c.context.platform))); },
            [](EngineConfig& c, const char* name, py::handle value) {
              c.context.platform = unwrap(gl::parse_platform(cast<std::string>(name, value)));
            }},
    plain<&EngineConfig::context, &engine::ContextConfig::later>("context_later"),
    named<&EngineConfig::context, &engine::ContextConfig::gl_state>("gl_state"),
    plain<&EngineConfig::context, &engine::ContextConfig::debug>("gl_debug"),
    Setting{"program_cache", [](const EngineConfig& c) -> py::object { return py::cast(c.context.program_cache); },
            [](EngineConfig& c, const char* name, py::handle value) {
              c.context.program_cache = {};
              if (!value.is_none()) c.context.program_cache = cast<std::filesystem::path>(name, value);
            }},
};

const std::array<Setting, kChangeableSettings> kChangeable = {
    named<&EngineConfig::culling, &engine::CullingConfig::culler>("culler"),
    plain<&EngineConfig::culling, &engine::CullingConfig::sample_test>("sample_test"),
    named<&EngineConfig::culling, &engine::CullingConfig::occlusion>("occlusion"),
    plain<&EngineConfig::losses, &engine::LossConfig::min_projected_area>("min_projected_area"),
    named<&EngineConfig::losses, &engine::LossConfig::contribution_mode>("contribution_mode"),
    plain<&EngineConfig::losses, &engine::LossConfig::budget_ms>("budget_ms"),
    plain<&EngineConfig::losses, &engine::LossConfig::lod_error>("lod_error"),
    Setting{"culled_colour",
            [](const EngineConfig& c) -> py::object {
              return c.drawing.culled_colour ? colour(*c.drawing.culled_colour) : py::none();
            },
            [](EngineConfig& c, const char* name, py::handle value) {
              c.drawing.culled_colour = {};
              if (!value.is_none()) c.drawing.culled_colour = core::vec3(vector3(value, name));
            }},
    Setting{"outline_colour", [](const EngineConfig& c) -> py::object { return colour(c.drawing.outline_colour); },
            [](EngineConfig& c, const char* name, py::handle value) {
              c.drawing.outline_colour = core::vec3(vector3(value, name));
            }},
    plain<&EngineConfig::drawing, &engine::DrawingConfig::looks, &engine::Looks::depth_shading,
          &engine::DepthShading::strength>("depth_shading"),
    plain<&EngineConfig::drawing, &engine::DrawingConfig::looks, &engine::Looks::depth_shading,
          &engine::DepthShading::edge_lines>("edge_lines"),
    plain<&EngineConfig::drawing, &engine::DrawingConfig::looks, &engine::Looks::hatching, &engine::Hatching::strength>(
        "hatching_strength"),
    plain<&EngineConfig::drawing, &engine::DrawingConfig::looks, &engine::Looks::hatching, &engine::Hatching::spacing>(
        "hatching_spacing"),
    named<&EngineConfig::drawing, &engine::DrawingConfig::looks, &engine::Looks::lighting>("lighting"),
    Setting{"sun",
            [](const EngineConfig& c) -> py::object {
              const core::dvec3& sun = c.drawing.looks.sun;
              return py::make_tuple(sun.x, sun.y, sun.z);
            },
            [](EngineConfig& c, const char* name, py::handle value) { c.drawing.looks.sun = vector3(value, name); }},
    background<&core::Background::bottom>("background_bottom"),
    background<&core::Background::top>("background_top"),
    Setting{"controller",
            [](const EngineConfig& c) -> py::object {
              ControllerConfig told = c.culling.controller;
              told.rendering = true;  // the engine's, which follows `draw`
              return py::cast(told);
            },
            [](EngineConfig& c, const char* name, py::handle value) {
              c.culling.controller =
                  value.is_none() ? ControllerConfig() : checked(cast<ControllerConfig>(name, value));
            }},
};

py::object default_of(const Setting& setting) {
  if (std::string_view(setting.name) == "controller") return py::none();
  return setting.get(EngineConfig());
}

void set_all(EngineConfig& config, std::span<const Setting> settings, std::span<const py::object> values) {
  for (std::size_t i = 0; i < settings.size(); ++i)
    if (!values[i].is(py::ellipsis())) settings[i].set(config, settings[i].name, values[i]);
}

py::dict settings_of(const EngineConfig& config) {
  py::dict settings;
  for (const Setting& setting : kFixed) settings[setting.name] = setting.get(config);
  for (const Setting& setting : kChangeable) settings[setting.name] = setting.get(config);
  return settings;
}

// --- the controller --------------------------------------------------------------------------------------------------

namespace {

template <class F>
using NumberOf = FieldType<F, ControllerConfig>;

template <class F>
void bind_number(py::class_<ControllerConfig>& c, const char* name) {
  c.def_property(
      name, [](const ControllerConfig& k) { return F::of(k); },
      [](ControllerConfig& k, NumberOf<F> value) {
        ControllerConfig changed = k;
        F::of(changed) = value;
        k = checked(changed);
      },
      "A number; see culling/hybrid/controller.h.");
}

template <class... F>
py::tuple state_of_controller(const ControllerConfig& k) {
  return py::make_tuple(stored(F::of(k))...);
}

template <class... F>
ControllerConfig controller_of_state(const py::tuple& state) {
  if (state.size() != sizeof...(F)) fail("pickle: it is of another version");
  ControllerConfig k;
  std::size_t i = 0;
  ((F::of(k) = restored<NumberOf<F>>(state[i++])), ...);
  return checked(k);
}

template <class... F>
ControllerConfig make_controller(NumberOf<F>... values) {
  ControllerConfig made;
  ((F::of(made) = values), ...);
  return checked(made);
}

/// Numbers of a controller's configuration: its constructor's arguments, its attributes, and what is pickled of it.
template <class... F>
void bind_numbers(py::class_<ControllerConfig>& c, const std::array<const char*, sizeof...(F)>& names) {
  const ControllerConfig defaults;
  const auto define = [&]<std::size_t... I>(std::index_sequence<I...>) {
    c.def(py::init(&make_controller<F...>), py::kw_only(), (py::arg(names[I]) = F::of(defaults))...,
          "Takes the culler that costs the frame less, by measured times.");
    (bind_number<F>(c, names[I]), ...);
  };
  define(std::index_sequence_for<F...>());
  c.def(
       "__eq__", [](const ControllerConfig& a, const ControllerConfig& b) { return a == b; }, py::is_operator())
      .def(py::pickle(&state_of_controller<F...>, &controller_of_state<F...>));
}

}  // namespace

void bind_controller_config(py::module_& m) {
  py::class_<ControllerConfig> c(m, "ControllerConfig", "When a hybrid lets the CPU cull and when the GPU.");
  bind_numbers<Field<&ControllerConfig::least_gpu_cull_ms>, Field<&ControllerConfig::margin>,
               Field<&ControllerConfig::dwell_margin>, Field<&ControllerConfig::dwell_frames>,
               Field<&ControllerConfig::probe_share>, Field<&ControllerConfig::first_probes>,
               Field<&ControllerConfig::probe_cost>, Field<&ControllerConfig::probe_interval>,
               Field<&ControllerConfig::silent_frames>, Field<&ControllerConfig::presumed_gpu_excess>>(
      c, {"least_gpu_cull_ms", "margin", "dwell_margin", "dwell_frames", "probe_share", "first_probes", "probe_cost",
          "probe_interval", "silent_frames", "presumed_gpu_excess"});
}

}  // namespace sightline::python
