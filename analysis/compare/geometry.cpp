#include "sightline/analysis/compare/internal/geometry.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "sightline/core/internal/hash.h"

namespace sightline::compare {
namespace {

constexpr double kFloatRounding = 4e-7;  // of an item's size: placements and vertices are float
constexpr double kDoubleRounding = 64 * std::numeric_limits<double>::epsilon();
constexpr int kDirections = 32;

double largest(const dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

double squared(const dvec3& v) {
  return glm::dot(v, v);
}

dmat3 outer(const dvec3& v) {
  return {v * v.x, v * v.y, v * v.z};
}

LocalShape local_shape(const core::Primitive& primitive) {
  LocalShape shape;
  shape.box = core::bounds(primitive, {});
  shape.centre = shape.box.centre();
  const dvec3 half = 0.5 * shape.box.size();
  for (int axis = 0; axis < 3; ++axis) shape.spread[axis][axis] = half[axis] * half[axis];
  return shape;
}

template <class T>
std::uint64_t hash_of(std::uint64_t seed, const std::vector<T>& values) {
  for (const T value : values) seed = core::mixed(seed ^ std::bit_cast<std::uint32_t>(value));
  return seed;
}

LocalShape local_shape(const core::Mesh& mesh, const core::AabbD& box) {
  LocalShape shape;
  shape.topology = hash_of(mesh.positions.size(), mesh.indices);
  shape.content = shape.topology;
  if (mesh.positions.empty()) {
    shape.box = {dvec3(0.0), dvec3(0.0)};
    return shape;
  }
  shape.box = box;
  const double share = 1.0 / double(mesh.positions.size());
  for (const core::vec3& p : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis)
      shape.content = core::mixed(shape.content ^ std::bit_cast<std::uint32_t>(p[axis] + 0.0f));  // -0 becomes 0
    shape.centre += share * dvec3(p);
  }
  for (const core::vec3& p : mesh.positions) shape.spread += share * outer(dvec3(p) - shape.centre);
  return shape;
}

/// Mean scale of a map.
double scale_of(const dmat3& linear) {
  return std::sqrt((squared(linear[0]) + squared(linear[1]) + squared(linear[2])) / 3.0);
}

/// Whether two maps scale and shear alike, up to their mean scale: a shape of this size then differs by at most `most`.
bool deforms_alike(const dmat3& a, const dmat3& b, double size, double most) {
  const double scale_a = scale_of(a), scale_b = scale_of(b);
  if (scale_a == 0.0 || scale_b == 0.0) return scale_a == scale_b;
  const dmat3 gram_a = glm::transpose(a) * a / (scale_a * scale_a),
              gram_b = glm::transpose(b) * b / (scale_b * scale_b);
  for (int i = 0; i < 3; ++i)
    if (!(0.5 * size * largest(gram_a[i] - gram_b[i]) <= most)) return false;
  return true;
}

/// First parameter that is an angle or the tangent's argument of one; those after it are, too.
int first_angle(core::Kind kind) {
  switch (kind) {
    case core::Kind::kRectangularTorus:
      return 3;
    case core::Kind::kCircularTorus:
      return 2;
    case core::Kind::kSnout:
      return 5;
    default:
      return core::parameter_count(kind);
  }
}

/// Lengths are compared as they are in the world, since a file may come back in other units.
bool parameters_alike(const core::Primitive& a, double scale_a, const core::Primitive& b, double scale_b, double size,
                      double most) {
  const auto values_a = core::parameters(a), values_b = core::parameters(b);
  const int angles = first_angle(core::kind_of(a));
  for (int i = 0; i < int(values_a.size()); ++i) {
    const double x = values_a[std::size_t(i)], y = values_b[std::size_t(i)];
    const double apart = i < angles ? std::abs(x * scale_a - y * scale_b) : size * std::abs(x - y);
    if (!(apart <= most)) return false;
  }
  return true;
}

/// Whether the corners of the boxes, and so everything in them, lie on each other.
bool boxes_agree(const core::AabbD& box_a, const Geometry& a, const core::AabbD& box_b, const Geometry& b,
                 double most) {
  for (int corner = 0; corner < 8; ++corner) {
    const auto at = [corner](const core::AabbD& box) {
      return dvec3(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                   corner & 4 ? box.max.z : box.min.z);
    };
    const dvec3 apart = a.world_from_item.linear * at(box_a) - b.world_from_item.linear * at(box_b) +
                        (a.world_from_item.origin - b.world_from_item.origin);
    if (!(squared(apart) <= most * most)) return false;
  }
  return true;
}

/// Whether the support function tells a primitive of this kind from the same one turned.
bool is_told_by_support(const core::Primitive& primitive) {
  if (const auto* torus = std::get_if<core::RectangularTorus>(&primitive))
    return core::sweep_angle(torus->angle) == core::kFullTurn;
  if (const auto* torus = std::get_if<core::CircularTorus>(&primitive))
    return core::sweep_angle(torus->angle) == core::kFullTurn;
  if (const auto* s = std::get_if<core::Snout>(&primitive))
    return s->bottom_shear_x == 0 && s->bottom_shear_y == 0 && s->top_shear_x == 0 && s->top_shear_y == 0;
  return true;
}

/// Exporters turn a cylinder's frame about its axis, or a box's by a quarter, and nothing has moved. Compares the
/// support functions in directions on a spiral, among which no symmetry of a primitive maps one to another.
bool supports_agree(const core::Primitive& p, const core::Affine& a, const core::Primitive& q, const core::Affine& b,
                    double most) {
  const dmat3 item_from_world_a = glm::transpose(a.linear), item_from_world_b = glm::transpose(b.linear);
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kDirections, flat = std::sqrt(1.0 - z * z), turn = 2.39996322972865332 * i;
    const dvec3 direction(flat * std::cos(turn), flat * std::sin(turn), z);
    const double apart = core::support(p, item_from_world_a * direction) -
                         core::support(q, item_from_world_b * direction) + glm::dot(direction, a.origin - b.origin);
    if (!(std::abs(apart) <= most)) return false;
  }
  return true;
}

bool is_mirrored(const Geometry& a, const Geometry& b) {
  return glm::determinant(a.world_from_item.linear) * glm::determinant(b.world_from_item.linear) < 0.0;
}

Likeness primitives_alike(const Shown& a, const Shown& b, double most, bool centres_agree) {
  const core::Affine &world_a = a.geometry.world_from_item, &world_b = b.geometry.world_from_item;
  const core::Primitive p = a.shapes.scene().primitive(a.item), q = b.shapes.scene().primitive(b.item);
  const double size = a.geometry.size;
  if (!parameters_alike(p, scale_of(world_a.linear), q, scale_of(world_b.linear), size, most) ||
      !deforms_alike(world_a.linear, world_b.linear, size, most))
    return {false, centres_agree};
  if (centres_agree &&
      (boxes_agree(a.shapes.local(a.item).box, a.geometry, b.shapes.local(b.item).box, b.geometry, most) ||
       (is_told_by_support(p) && supports_agree(p, world_a, q, world_b, most))))
    return {true, true};
  // The mirror images of all other primitives are themselves, turned.
  const bool handed = a.geometry.kind == core::Kind::kSnout || a.geometry.kind == core::Kind::kPyramid;
  if (handed && is_mirrored(a.geometry, b.geometry)) return {false, centres_agree};
  return {true, false};
}

/// Vertices of a mesh about its centre, turned and scaled as in the world.
class WorldVertices {
 public:
  WorldVertices(const Shown& shown)
      : mesh_(shown.shapes.scene().mesh(shown.shapes.scene().mesh_of(shown.item))),
        linear_(shown.geometry.world_from_item.linear),
        centre_(shown.shapes.local(shown.item).centre) {}
  std::size_t size() const { return mesh_.positions.size(); }
  dvec3 operator[](std::size_t i) const { return linear_ * (dvec3(mesh_.positions[i]) - centre_); }

 private:
  const core::Mesh& mesh_;
  dmat3 linear_;
  dvec3 centre_;
};

/// Three vertices that with the centre span the mesh: the farthest from the centre, from a line, and from a plane.
std::array<std::size_t, 3> spanning(const WorldVertices& vertices) {
  std::array<std::size_t, 3> chosen{};
  const auto farthest = [&](const auto& distance) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < vertices.size(); ++i)
      if (distance(vertices[i]) > distance(vertices[best])) best = i;
    return best;
  };
  chosen[0] = farthest([](const dvec3& v) { return squared(v); });
  const dvec3 line = vertices[chosen[0]];
  chosen[1] = farthest([&](const dvec3& v) { return squared(glm::cross(line, v)); });
  const dvec3 plane = glm::cross(line, vertices[chosen[1]]);
  chosen[2] = farthest([&](const dvec3& v) { return std::abs(glm::dot(plane, v)); });
  return chosen;
}

/// Whether a rotation takes the vertices of one mesh to those of the other, in their order: distances from the centre
/// and three more points tell where a vertex is.
bool are_congruent(const WorldVertices& a, const WorldVertices& b, double size, double most) {
  const auto chosen = spanning(a);
  std::array<dvec3, 4> from_a{}, from_b{};
  for (std::size_t k = 0; k < 3; ++k) from_a[k] = a[chosen[k]], from_b[k] = b[chosen[k]];
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k)
      if (!(std::abs(glm::length(a[i] - from_a[k]) - glm::length(b[i] - from_b[k])) <= 2.0 * most)) return false;
  const double volume_a = glm::dot(from_a[0], glm::cross(from_a[1], from_a[2]));
  const double volume_b = glm::dot(from_b[0], glm::cross(from_b[1], from_b[2]));
  return volume_a * volume_b >= 0.0 || std::abs(volume_a - volume_b) <= most * size * size;
}

Likeness meshes_alike(const Shown& a, const Shown& b, double most, bool centres_agree) {
  const LocalShape local_a = a.shapes.local(a.item), local_b = b.shapes.local(b.item);
  if (local_a.topology != local_b.topology) return {false, centres_agree};
  if (centres_agree && local_a.content == local_b.content &&
      boxes_agree(local_a.box, a.geometry, local_b.box, b.geometry, most))
    return {true, true};
  // An importer may have found another copy to share, so the same mesh may come in other coordinates.
  const WorldVertices vertices_a(a), vertices_b(b);
  if (vertices_a.size() != vertices_b.size()) return {false, centres_agree};
  if (vertices_a.size() == 0) return {true, centres_agree};
  bool agree = centres_agree;
  const dvec3 shift = a.geometry.centre - b.geometry.centre;
  for (std::size_t i = 0; agree && i < vertices_a.size(); ++i)
    agree = squared(vertices_a[i] - vertices_b[i] + shift) <= most * most;
  if (agree) return {true, true};
  if (are_congruent(vertices_a, vertices_b, a.geometry.size, most)) return {true, false};
  return {false, centres_agree};
}

}  // namespace

Geometry Shapes::geometry(core::ItemId item, const core::Affine& world_from_item) {
  const core::Kind kind = scene_->kind(item);
  if (int(kind) >= core::kPrimitiveKindCount) {
    const core::MeshId mesh = scene_->mesh_of(item);
    if (!meshes_[mesh.index]) meshes_[mesh.index] = local_shape(scene_->mesh(mesh), scene_->mesh_bounds(mesh));
  }
  const LocalShape shape = local(item);
  const dmat3& linear = world_from_item.linear;
  const dmat3 spread = linear * shape.spread * glm::transpose(linear);
  const double size = std::sqrt(std::max(0.0, spread[0][0] + spread[1][1] + spread[2][2]));
  return {world_from_item, core::transform_point(world_from_item, shape.centre), size, shape.topology, kind};
}

LocalShape Shapes::local(core::ItemId item) const {
  if (int(scene_->kind(item)) < core::kPrimitiveKindCount) return local_shape(scene_->primitive(item));
  return *meshes_[scene_->mesh_of(item).index];
}

double allowance(const Geometry& geometry, double tolerance) {
  return tolerance + kFloatRounding * geometry.size + kDoubleRounding * largest(geometry.centre);
}

Likeness likeness(const Shown& a, const Shown& b, double tolerance) {
  const double most = allowance(a.geometry, tolerance);
  const bool centres_agree = squared(a.geometry.centre - b.geometry.centre) <= most * most;
  if (a.geometry.kind != b.geometry.kind) return {false, centres_agree};
  if (int(a.geometry.kind) < core::kPrimitiveKindCount) return primitives_alike(a, b, most, centres_agree);
  return meshes_alike(a, b, most, centres_agree);
}

double turn_between(const core::Affine& from, const core::Affine& to) {
  if (glm::determinant(from.linear) == 0.0) return 0.0;
  const dmat3 r = to.linear * glm::inverse(from.linear);
  const dvec3 axis(r[1][2] - r[2][1], r[2][0] - r[0][2], r[0][1] - r[1][0]);
  return std::atan2(glm::length(axis), r[0][0] + r[1][1] + r[2][2] - 1.0);
}

}  // namespace sightline::compare
