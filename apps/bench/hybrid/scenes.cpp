#include "sightline/apps/bench/hybrid/scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sightline/apps/bench/models/aircraft.h"
#include "sightline/importers/plant/plant_generator.h"

namespace sightline::bench {
namespace {

using core::Affine;
using core::dvec3;

// --- platforms -------------------------------------------------------------------------------------------------------

struct Place {
  core::Primitive primitive;
  Affine box_from_item;
};

/// A primitive along the longest side of `box`, as thick as the mean of the other two sides.
Place fitting(Mix mix, const core::AabbD& box) {
  const dvec3 size = box.size();
  const int along = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const int next = (along + 1) % 3, last = (along + 2) % 3;
  const double length = size[along], radius = 0.25 * (size[next] + size[last]);
  Affine place = core::translation(box.centre());
  const auto axes = [&](int x, int y, int z) {
    place.linear = core::dmat3(0.0);
    place.linear[0][x] = place.linear[1][y] = place.linear[2][z] = 1.0;
  };
  if (mix == kTori) {
    constexpr double kAngle = 0.5;
    const double major = length / kAngle;
    axes(last, along, next);
    Affine middle = core::translation({-major, 0.0, 0.0});  // from the middle of the arc to the centre
    const double c = std::cos(0.5 * kAngle), s = std::sin(0.5 * kAngle);
    middle.linear[0] = {c, -s, 0.0};
    middle.linear[1] = {s, c, 0.0};
    return {core::CircularTorus{float(major), float(std::min(radius, 0.5 * major)), float(kAngle)}, place * middle};
  }
  axes(next, last, along);
  const auto r = float(radius), h = float(length);
  if (mix == kCones) return {core::Snout{r, 0.6f * r, h, 0, 0, 0, 0, 0, 0}, place};
  return {core::Cylinder{r, h}, place};
}

// --- the aircraft ----------------------------------------------------------------------------------------------------

/// A flat-shaded prism with `sides` sides along z that fills the unit cube around the origin.
core::Mesh prism(int sides) {
  core::Mesh mesh;
  mesh.name = "prism of " + std::to_string(sides);
  const auto add = [&](std::initializer_list<core::vec3> corners, const core::vec3& normal) {  // a convex polygon
    const auto first = std::uint32_t(mesh.positions.size());
    for (const core::vec3& corner : corners) {
      mesh.positions.push_back(corner);
      mesh.normals.push_back(normal);
    }
    for (std::uint32_t i = 2; i < corners.size(); ++i)
      for (const std::uint32_t index : {first, first + i - 1, first + i}) mesh.indices.push_back(index);
  };
  const double step = 2.0 * std::numbers::pi / sides, reach = 0.5 / std::cos(0.5 * step);
  const auto corner = [&](int i, float z) {
    const double angle = step * (i + 0.5);
    return core::vec3(std::clamp(reach * std::cos(angle), -0.5, 0.5), std::clamp(reach * std::sin(angle), -0.5, 0.5),
                      z);
  };
  for (int i = 0; i < sides; ++i) {
    const core::vec3 a = corner(i, -0.5f), b = corner(i + 1, -0.5f), c = corner(i + 1, 0.5f), d = corner(i, 0.5f);
    add({a, b, c, d}, glm::normalize(core::vec3(a.x + b.x, a.y + b.y, 0.0f)));
    add({{0, 0, 0.5f}, d, c}, {0, 0, 1});
    add({{0, 0, -0.5f}, b, a}, {0, 0, -1});
  }
  return mesh;
}

}  // namespace

core::Expected<void> make_platform_scene(const Platform& platform, double scale, core::Scene& scene) {
  Platform primitives = platform;
  primitives.counts[kMeshes] = 0;
  importers::PlantOptions config;
  config.items = scaled(platform.primitives(), scale);
  config.seed = platform.primitives();
  if (auto made = importers::generate_plant(config, scene); !made) return made;
  std::vector<std::uint8_t> kinds;
  const auto count = core::ItemId(scene.item_slots());
  kinds.reserve(to_index(count));
  for (core::ItemId item{0}; item < count; ++item) kinds.push_back(mix_of(scene.kind(item)));
  mix_kinds(primitives, kinds);
  for (core::ItemId item{0}; item < count; ++item) {
    const auto mix = Mix(kinds[to_index(item)]);
    if (mix == kMeshes || mix == mix_of(scene.kind(item))) continue;
    const Place place = fitting(mix, scene.bounds_under(item, Affine()));
    scene.add_primitive(scene.node_of(item), place.primitive, scene.placement(item) * place.box_from_item,
                        scene.item_material(item));
    scene.remove_item(item);
  }
  return {};
}

void make_aircraft_scene(double scale, core::Scene& scene) {
  const std::array<core::MeshId, 4> shapes = {scene.add_mesh(prism(4)).value(), scene.add_mesh(prism(6)).value(),
                                              scene.add_mesh(prism(8)).value(), scene.add_mesh(prism(12)).value()};
  const std::vector<core::Aabb> boxes = make_aircraft(scaled(kAircraftMeshes, scale));
  constexpr std::size_t kPerNode = 1000;
  core::NodeId node;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (i % kPerNode == 0) node = scene.add_node(scene.root(), "part " + std::to_string(i / kPerNode));
    const dvec3 low(boxes[i].min), high(boxes[i].max);
    Affine place = core::translation(0.5 * (low + high));
    for (int k = 0; k < 3; ++k) place.linear[k][k] = high[k] - low[k];
    scene.add_mesh_instance(node, shapes[i % shapes.size()], place);
  }
}

}  // namespace sightline::bench
