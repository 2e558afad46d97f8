// The analytic primitives, each as a class with its parameters as attributes.
#include <array>
#include <span>
#include <utility>

#include "sightline/bindings/python/module.h"
#include "sightline/bindings/python/values.h"
#include "sightline/core/primitive.h"

namespace sightline::python {
namespace {

using core::Primitive;

std::string repr_of(const Primitive& primitive, std::span<const char* const> names, const std::string& type) {
  std::string text = type + "(";
  const auto values = core::parameters(primitive);
  for (std::size_t i = 0; i < values.size(); ++i)
    text += std::string(i == 0 ? "" : ", ") + names[i] + "=" + std::string(py::repr(py::float_(values[i])));
  return text + ")";
}

template <auto Field>
using FloatOf = float;

template <class T, float T::*... kFields>
void bind_primitive(py::module_& m, const char* type, const char* doc,
                    const std::array<const char*, sizeof...(kFields)>& names) {
  py::class_<T> bound(m, type, doc);
  const auto define = [&]<std::size_t... I>(std::index_sequence<I...>) {
    bound.def(py::init([](FloatOf<kFields>... values) { return T{values...}; }), py::arg(names[I])...,
              "Lengths in local units, which an item's placement scales to metres; angles in radians.");
    (bound.def_readwrite(names[I], kFields, "A parameter; see the class."), ...);
  };
  define(std::make_index_sequence<sizeof...(kFields)>());
  bound
      .def_property_readonly(
          "kind", [](const T& p) { return std::string(name_of(core::kind_of(p))); }, "Its name in files and messages.")
      .def_property_readonly(
          "parameters",
          [](const T& p) {
            const Primitive primitive = p;
            const auto values = core::parameters(primitive);
            return py::array_t<float>(Shape{py::ssize_t(values.size())}, values.data());
          },
          "All parameters in the order of the constructor, float32.")
      .def_property_readonly(
          "degenerate", [](const T& p) { return core::is_degenerate(p); }, "Whether it has no volume, or no length.")
      .def(
          "bounds",
          [](const T& p, const py::object& world_from_item) {
            return to_array(core::bounds(p, affine(world_from_item, "world_from_item")));
          },
          py::arg("world_from_item") = py::none(), "[[min], [max]] under a 4 x 4 matrix, tight.")
      .def("__repr__", [names, type](const T& p) { return repr_of(p, names, type); });
  bind_value<kFields...>(bound);
}

}  // namespace

void bind_primitives(py::module_& m) {
  using namespace core;
  bind_primitive<Pyramid, &Pyramid::bottom_x, &Pyramid::bottom_y, &Pyramid::top_x, &Pyramid::top_y, &Pyramid::offset_x,
                 &Pyramid::offset_y, &Pyramid::height>(
      m, "Pyramid",
      "Frustum of a rectangular pyramid: bottom at z = -height/2 around -offset/2, top at height/2 around offset/2.",
      {"bottom_x", "bottom_y", "top_x", "top_y", "offset_x", "offset_y", "height"});
  bind_primitive<Box, &Box::size_x, &Box::size_y, &Box::size_z>(m, "Box", "A box about the origin.",
                                                                {"size_x", "size_y", "size_z"});
  bind_primitive<RectangularTorus, &RectangularTorus::inner_radius, &RectangularTorus::outer_radius,
                 &RectangularTorus::height, &RectangularTorus::angle>(
      m, "RectangularTorus", "A rectangle swept about z by `angle` from +x towards +y.",
      {"inner_radius", "outer_radius", "height", "angle"});
  bind_primitive<CircularTorus, &CircularTorus::major_radius, &CircularTorus::tube_radius, &CircularTorus::angle>(
      m, "CircularTorus", "A disc swept about z by `angle` from +x towards +y: an elbow.",
      {"major_radius", "tube_radius", "angle"});
  bind_primitive<EllipticalDish, &EllipticalDish::base_radius, &EllipticalDish::height>(
      m, "EllipticalDish", "Half an ellipsoid of revolution: base circle at z = 0, pole at z = height.",
      {"base_radius", "height"});
  bind_primitive<SphericalDish, &SphericalDish::base_radius, &SphericalDish::height>(
      m, "SphericalDish", "Cap of a sphere: base circle at z = 0, pole at z = height.", {"base_radius", "height"});
  bind_primitive<Snout, &Snout::bottom_radius, &Snout::top_radius, &Snout::height, &Snout::offset_x, &Snout::offset_y,
                 &Snout::bottom_shear_x, &Snout::bottom_shear_y, &Snout::top_shear_x, &Snout::top_shear_y>(
      m, "Snout", "Truncated cone, eccentric by `offset` and with ends slanted by the angles `shear`.",
      {"bottom_radius", "top_radius", "height", "offset_x", "offset_y", "bottom_shear_x", "bottom_shear_y",
       "top_shear_x", "top_shear_y"});
  bind_primitive<Cylinder, &Cylinder::radius, &Cylinder::height>(m, "Cylinder", "A cylinder about z, centred.",
                                                                 {"radius", "height"});
  bind_primitive<Sphere, &Sphere::diameter>(m, "Sphere", "A sphere about the origin.", {"diameter"});
  bind_primitive<Line, &Line::from, &Line::to>(m, "Line", "A segment of the x axis, drawn one pixel wide.",
                                               {"start", "stop"});
  py::list kinds;
  for (int kind = 0; kind < kKindCount; ++kind) kinds.append(std::string(name_of(Kind(kind))));
  m.attr("KINDS") = py::tuple(kinds);
}

}  // namespace sightline::python
