#include "sightline/study/parts/recognise/subjects.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::bench {
namespace {

using core::dvec3;

/// Samples of a full circle: prime, so that samples are no corners of the triangles.
constexpr int kSampleSegments = 31;

/// The factor of a similarity; 0 for other maps.
double scale_of(const core::dmat3& linear) {
  const core::dmat3 gram = glm::transpose(linear) * linear;
  const double square = (gram[0][0] + gram[1][1] + gram[2][2]) / 3.0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r)
      if (!(std::fabs(gram[c][r] - (c == r ? square : 0.0)) <= 1e-5 * square)) return 0.0;
  return std::sqrt(square);
}

std::vector<dvec3> samples_of(const core::Primitive& primitive) {
  const core::Mesh mesh = gpuprims::tessellate(primitive, {.fixed_segments = kSampleSegments});
  return {mesh.positions.begin(), mesh.positions.end()};
}

/// Lengths that do not depend on how the primitive is turned. Nothing for pyramids and slanted or eccentric snouts.
std::vector<double> lengths_of(const core::Primitive& primitive, double scale) {
  std::vector<double> lengths;
  for (const float p : core::parameters(primitive)) lengths.push_back(std::fabs(double(p)) * scale);
  switch (core::kind_of(primitive)) {
    case core::Kind::kBox:
      std::sort(lengths.begin(), lengths.end());
      return lengths;
    case core::Kind::kRectangularTorus:
    case core::Kind::kCircularTorus: {
      const float angle = core::parameters(primitive).back();
      const double outermost =
          core::kind_of(primitive) == core::Kind::kCircularTorus ? lengths[0] + lengths[1] : lengths[1];
      lengths.back() = core::sweep_angle(angle) * outermost;
      return lengths;
    }
    case core::Kind::kSnout:
      if (std::any_of(lengths.begin() + 3, lengths.end(), [](double v) { return v != 0.0; })) return {};
      lengths.resize(3);
      std::sort(lengths.begin(), lengths.begin() + 2);
      return lengths;
    case core::Kind::kCylinder:
    case core::Kind::kSphere:
    case core::Kind::kSphericalDish:
    case core::Kind::kEllipticalDish:
      return lengths;
    default:
      return {};
  }
}

}  // namespace

double Original::distance_of(const dvec3& point) const {
  const dvec3 from_origin = point + (origin - world_from_local.origin);
  return distance(glm::transpose(world_from_local.linear) * from_origin / (scale * scale)) * scale;
}

std::vector<Original> originals_of(const core::Scene& scene) {
  std::vector<core::ItemId> items;
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (scene.contains_item(item) && int(scene.kind(item)) < core::kPrimitiveKindCount &&
        scene.kind(item) != core::Kind::kLine && !core::is_degenerate(scene.primitive(item)))
      items.push_back(item);
  std::vector<Original> originals;
  scene.for_each_state(items, [&](core::ItemId item, const core::Scene::ItemState& state) {
    const double scale = scale_of(state.world_from_item.linear);
    if (!(scale > 0.0)) return;
    const core::Primitive primitive = scene.primitive(item);
    const core::AabbD box = core::bounds(primitive, state.world_from_item);
    originals.push_back({item, primitive, state.world_from_item, scale, glm::round(0.5 * (box.min + box.max)),
                         importers::recognition::surface_distance(primitive)});
  });
  return originals;
}

core::Mesh triangles_of(const Original& original, const Fineness& fineness) {
  gpuprims::Tessellation tessellation;
  tessellation.fixed_segments = fineness.segments;
  tessellation.chord_tolerance = fineness.chord / original.scale;
  core::Mesh mesh = gpuprims::tessellate(original.primitive, tessellation);
  const core::dmat3& linear = original.world_from_local.linear;
  const dvec3 shift = original.world_from_local.origin - original.origin;
  for (core::vec3& p : mesh.positions) {
    dvec3 moved = linear * dvec3(p) + shift;
    if (fineness.rounding > 0.0) moved = glm::round(moved / fineness.rounding) * fineness.rounding;
    p = core::vec3(moved);
  }
  for (core::vec3& n : mesh.normals) n = core::vec3(linear * dvec3(n) / original.scale);
  if (glm::determinant(linear) < 0.0)
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) std::swap(mesh.indices[i], mesh.indices[i + 1]);
  return mesh;
}

double error_of_triangles(const Original& original, const core::Mesh& mesh) {
  double most = 0.0;
  const auto add = [&](const dvec3& point) { most = std::max(most, original.distance_of(point)); };
  for (const core::vec3& p : mesh.positions) add(dvec3(p));
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const dvec3 a(mesh.positions[mesh.indices[i]]), b(mesh.positions[mesh.indices[i + 1]]),
        c(mesh.positions[mesh.indices[i + 2]]);
    for (const dvec3& point : {0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (a + b + c) / 3.0}) add(point);
  }
  return most;
}

double error_of_surfaces(const Original& original, const importers::RecognisedMesh& found) {
  double most = 0.0;
  if (found.primitives.size() == 1) {
    const importers::RecognisedPrimitive& one = found.primitives.front();
    for (const dvec3& p : samples_of(one.primitive))
      most = std::max(most, original.distance_of(core::transform_point(one.mesh_from_primitive, p)));
  }
  std::vector<importers::recognition::SurfaceDistance> distances;
  for (const auto& one : found.primitives) distances.push_back(importers::recognition::surface_distance(one.primitive));
  for (const dvec3& p : samples_of(original.primitive)) {
    const dvec3 point = core::transform_point(original.world_from_local, p) - original.origin;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < distances.size(); ++i) {
      const core::Affine& map = found.primitives[i].mesh_from_primitive;
      least = std::min(least, distances[i](glm::transpose(map.linear) * (point - map.origin)));
    }
    most = std::max(most, least);
  }
  return most;
}

std::optional<double> error_of_lengths(const Original& original, const core::Primitive& found) {
  const std::vector<double> wanted = lengths_of(original.primitive, original.scale), have = lengths_of(found, 1.0);
  if (wanted.empty() || wanted.size() != have.size()) return std::nullopt;
  double most = 0.0;
  for (std::size_t i = 0; i < wanted.size(); ++i) most = std::max(most, std::fabs(wanted[i] - have[i]));
  return most;
}

}  // namespace sightline::bench
