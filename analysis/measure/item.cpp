#include "sightline/analysis/measure/item.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "sightline/analysis/measure/internal/item_data.h"

namespace sightline::measure {
namespace {

constexpr double kSmoothCosine = 0.93969262078590838;  // 20 degrees

bool comes_before(const dvec3& a, const dvec3& b) {
  return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
}

/// For each corner the number of its position.
std::vector<std::uint32_t> number_positions(const std::vector<dvec3>& points) {
  std::vector<std::uint32_t> order(points.size()), numbers(points.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return comes_before(points[a], points[b]); });
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i > 0 && points[order[i]] != points[order[i - 1]]) ++count;
    numbers[order[i]] = count;
  }
  return numbers;
}

/// Side `corner` of a triangle, from that corner (an index of the shape's points) to the next one.
struct Side {
  std::uint32_t low, high;  ///< positions
  std::uint32_t corner;
  bool rising;  ///< from low to high
};

dvec3 triangle_normal(const Shape& mesh, std::size_t triangle) {
  const dvec3* p = &mesh.points[3 * triangle];
  const dvec3 n = glm::cross(p[1] - p[0], p[2] - p[0]);
  const double size = glm::length(n);
  return size > 0.0 ? n / size : dvec3(0.0);
}

std::uint32_t next_corner(std::uint32_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}

/// `sides` are those of one edge.
bool is_sharp(const Shape& mesh, std::span<const Side> sides) {
  if (sides.size() != 2) return true;
  const double turn = glm::dot(triangle_normal(mesh, sides[0].corner / 3), triangle_normal(mesh, sides[1].corner / 3));
  return (sides[0].rising == sides[1].rising ? -turn : turn) < kSmoothCosine;
}

}  // namespace

std::vector<TriangleFeatures> find_triangle_features(const Shape& mesh) {
  const std::vector<std::uint32_t> numbers = number_positions(mesh.points);
  std::vector<Side> sides;
  for (std::uint32_t corner = 0; corner < mesh.points.size(); ++corner) {
    const std::uint32_t a = numbers[corner], b = numbers[next_corner(corner)];
    if (a != b && triangle_normal(mesh, corner / 3) != dvec3(0.0))
      sides.push_back({std::min(a, b), std::max(a, b), corner, a < b});
  }
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return std::pair(a.low, a.high) < std::pair(b.low, b.high); });
  /// Sharp edges that meet at a position: a corner unless they are two in one line.
  struct Meeting {
    int count = 0;
    dvec3 first{0.0};
    bool straight = false;
  };
  std::vector<Meeting> meetings(mesh.points.size());
  std::vector<TriangleFeatures> found(mesh.points.size() / 3);
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && sides[end].low == sides[begin].low && sides[end].high == sides[begin].high) ++end;
    const std::span<const Side> edge(&sides[begin], end - begin);
    if (!is_sharp(mesh, edge)) continue;
    for (const Side& side : edge) found[side.corner / 3].edges[side.corner % 3] = true;
    const std::uint32_t ends[2] = {edge[0].corner, next_corner(edge[0].corner)};
    for (int i = 0; i < 2; ++i) {
      const dvec3 away = glm::normalize(mesh.points[ends[1 - i]] - mesh.points[ends[i]]);
      Meeting& meeting = meetings[numbers[ends[i]]];
      if (++meeting.count == 1) meeting.first = away;
      meeting.straight = meeting.count == 2 && glm::dot(meeting.first, away) < -kSmoothCosine;
    }
  }
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Meeting& meeting = meetings[numbers[i]];
    found[i / 3].corners[i % 3] = meeting.count > 0 && !meeting.straight;
  }
  return found;
}

core::Expected<Item> Item::create(const core::Primitive& primitive, const core::Affine& world_from_item) {
  auto found = measure::features(primitive, world_from_item);
  if (!found) return tl::unexpected(found.error());
  auto sizes = measure::dimensions(primitive, world_from_item);
  if (!sizes) return tl::unexpected(sizes.error());
  return Item(std::make_shared<const Data>(Data{
      core::kind_of(primitive), make_shape(primitive, world_from_item), std::move(*found), std::move(*sizes), {}, {}}));
}

core::Expected<Item> Item::create(const core::Mesh& mesh, const core::Affine& world_from_item) {
  if (auto valid = core::validate(mesh); !valid) return tl::unexpected(valid.error());
  if (!core::is_finite(world_from_item)) return core::fail("measure: mesh: expected a finite placement");
  Data data{mesh.is_facet_group() ? core::Kind::kFacetGroup : core::Kind::kMesh,
            make_shape(mesh, world_from_item),
            {},
            {},
            {},
            {}};
  data.triangles = find_triangle_features(data.shape);
  data.faces = find_mesh_faces(mesh, world_from_item, data.shape);
  return Item(std::make_shared<const Data>(std::move(data)));
}

core::Expected<Item> Item::create(const core::Scene& scene, core::ItemId item) {
  const core::Affine world_from_item = scene.state(item).world_from_item;
  return int(scene.kind(item)) < core::kPrimitiveKindCount ? create(scene.primitive(item), world_from_item)
                                                           : create(scene.mesh(scene.mesh_of(item)), world_from_item);
}

core::Kind Item::kind() const {
  return data_->kind;
}

std::span<const Feature> Item::features() const {
  return data_->features;
}

}  // namespace sightline::measure
