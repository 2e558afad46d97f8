#include "sightline/apps/common/item_facts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "sightline/core/mesh_extras.h"

namespace sightline::apps {
namespace {

/// By kind, in the order of core::parameters().
const std::array<std::vector<const char*>, core::kPrimitiveKindCount>& parameter_names() {
  static const auto all = [] {
    using enum core::Kind;
    std::array<std::vector<const char*>, core::kPrimitiveKindCount> names;
    const auto of = [&](core::Kind kind) -> auto& {
      return names[std::size_t(kind)];
    };
    of(kPyramid) = {"bottom x", "bottom y", "top x", "top y", "offset x", "offset y", "height"};
    of(kBox) = {"along its own x", "along its own y", "along its own z"};
    of(kRectangularTorus) = {"inner radius", "outer radius", "height", "angle"};
    of(kCircularTorus) = {"bend radius", "tube radius", "angle"};
    of(kEllipticalDish) = of(kSphericalDish) = {"base radius", "height"};
    of(kSnout) = {"bottom radius",  "top radius",     "height",      "offset x",   "offset y",
                  "bottom shear x", "bottom shear y", "top shear x", "top shear y"};
    of(kCylinder) = {"radius", "height"};
    of(kSphere) = {"diameter"};
    of(kLine) = {"from", "to"};
    return names;
  }();
  return all;
}

bool is_angle(std::string_view name) {
  return name.find("angle") != std::string_view::npos || name.find("shear") != std::string_view::npos;
}

/// How much larger a placement makes all lengths; none where it scales some more than others.
std::optional<double> scale_of(const core::Affine& world_from_item) {
  const core::dmat3& m = world_from_item.linear;
  const double x = glm::length(m[0]), least = std::min({x, glm::length(m[1]), glm::length(m[2])}),
               most = std::max({x, glm::length(m[1]), glm::length(m[2])});
  return most - least <= 1e-5 * most ? std::optional(x) : std::nullopt;
}

/// A parameter in the world, or, where an item is stretched, in its own units.
std::string quantity(std::string_view name, double value, const std::optional<double>& scale,
                     const LengthFormat& lengths) {
  if (is_angle(name)) return fmt::format("{:.6g}°", glm::degrees(value));
  return scale ? lengths.text(value * *scale) : fmt::format("{:.6g} units, stretched", value);
}

/// Sizes of the faces whose surfaces the mesh's file states, each once, from small to large.
void add_face_sizes(const core::Mesh& mesh, const std::optional<double>& scale, const LengthFormat& lengths,
                    std::vector<Fact>& facts) {
  using Kind = core::MeshSurface::Kind;
  const auto add = [&](Kind kind, const char* name, double core::MeshSurface::*size, double factor) {
    std::map<std::string, double> sizes;
    for (const core::MeshSurface& surface : core::surfaces_stored_with(mesh)) {
      const double value = std::fabs(factor * (surface.*size));
      if (surface.kind == kind)
        sizes.emplace(quantity(name, is_angle(name) ? std::atan(value) : value, scale, lengths), value);
    }
    std::vector<std::pair<double, std::string>> sorted;
    for (const auto& [text, value] : sizes) sorted.emplace_back(value, text);
    std::sort(sorted.begin(), sorted.end());
    std::string all;
    for (const auto& [value, text] : sorted) all += (all.empty() ? "" : ", ") + text;
    if (!all.empty()) facts.push_back({name, all});
  };
  add(Kind::kCylinder, "diameters of cylindrical faces", &core::MeshSurface::radius, 2.0);
  add(Kind::kCone, "half angles of conical faces", &core::MeshSurface::slope, 1.0);
  add(Kind::kSphere, "diameters of spherical faces", &core::MeshSurface::radius, 2.0);
  add(Kind::kTorus, "tube diameters of toroidal faces", &core::MeshSurface::tube_radius, 2.0);
}

std::vector<Fact> shape_facts(const core::Scene& scene, core::ItemId item, const LengthFormat& lengths) {
  const core::Kind kind = scene.kind(item);
  std::vector<Fact> facts{{"kind", std::string(core::name_of(kind))}};
  if (int(kind) >= core::kPrimitiveKindCount) {
    const core::MeshId mesh = scene.mesh_of(item);
    if (!mesh.valid()) return facts;
    facts.push_back({"triangles", grouped(std::int64_t(scene.mesh(mesh).indices.size() / 3))});
    add_face_sizes(scene.mesh(mesh), scale_of(scene.state(item).world_from_item), lengths, facts);
    return facts;
  }
  const core::Primitive primitive = scene.primitive(item);
  const auto values = core::parameters(primitive);
  const auto& names = parameter_names()[std::size_t(kind)];
  const std::optional<double> scale = scale_of(scene.state(item).world_from_item);
  for (std::size_t i = 0; i < values.size(); ++i)
    facts.push_back({names[i], quantity(names[i], double(values[i]), scale, lengths)});
  return facts;
}

const std::string* value_of(const std::vector<Fact>& facts, const std::string& name) {
  const auto found = std::find_if(facts.begin(), facts.end(), [&](const Fact& fact) { return fact.name == name; });
  return found == facts.end() ? nullptr : &found->value;
}

}  // namespace

std::vector<Fact> item_facts(const core::Scene& scene, core::ItemId item, const LengthFormat& lengths) {
  std::vector<Fact> facts = shape_facts(scene, item, lengths);
  const core::Scene::ItemState state = scene.state(item);
  const core::AabbD box = scene.bounds_under(item, state.world_from_item);
  if (!box.empty()) {
    facts.push_back({"from", lengths.text(box.min)});
    facts.push_back({"to", lengths.text(box.max)});
  }
  if (const core::MaterialId material = scene.material_at(state.material); material.valid())
    facts.push_back({"material", scene.material(material).name});
  return facts;
}

std::vector<Fact> attribute_facts(const core::Scene& scene, core::NodeId node) {
  std::vector<Fact> facts;
  for (const auto& [key, value] : scene.attributes(node)) facts.push_back({key, value});
  return facts;
}

std::vector<FactChange> differing(const std::vector<Fact>& before, const std::vector<Fact>& after) {
  std::vector<FactChange> changes;
  for (const Fact& fact : after) {
    const std::string* old = value_of(before, fact.name);
    if (!old || *old != fact.value) changes.push_back({fact.name, old ? *old : "", fact.value});
  }
  for (const Fact& fact : before)
    if (!value_of(after, fact.name)) changes.push_back({fact.name, fact.value, ""});
  return changes;
}

}  // namespace sightline::apps
