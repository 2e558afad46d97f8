#include "sightline/importers/tiles/internal/tile_shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sightline/importers/gltf/internal/meshopt_encoding.h"
#include "sightline/importers/internal/tessellated.h"
#include "sightline/lod/coarse_mesh.h"
#include "sightline/lod/stored_levels.h"

namespace sightline::importers {
namespace {

constexpr std::uint64_t kMostVertices = 4'000'000;  // that are kept from tile to tile
constexpr int kFewestSegments = 4;                  // of a full turn, where an error is allowed

/// The share of a level's error that rounding to the grid leaves. Triangles of primitives need none:
/// they are at most 0.6 of the tolerance away (gpuprims/internal/tessellation.h), and rounded twice.
constexpr double kLevelShare = 7.0 / 8.0;

/// A power of two of at most an eighth of an error, so that rounding to its multiples moves points by at most 0.109 of
/// the error.
double grid_of(double error) {
  return std::exp2(std::floor(std::log2(error / 8.0)));
}

void round_to(double grid, std::vector<core::vec3>& points) {
  for (core::vec3& p : points) p = core::vec3(grid * glm::round(core::dvec3(p) / grid));
}

/// The mirror image in x = 0.
core::Mesh mirrored(core::Mesh mesh) {
  for (core::vec3& p : mesh.positions) p.x = -p.x;
  for (core::vec3& n : mesh.normals) n.x = -n.x;
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
  return mesh;
}

core::Mesh line_mesh(const core::Line& line) {
  core::Mesh mesh;
  if (core::is_finite(core::dvec3(line.from, line.to, 0.0))) mesh.positions = {{line.from, 0, 0}, {line.to, 0, 0}};
  return mesh;
}

/// The mesh's triangles without what writers do not need.
core::Mesh plain(const core::Mesh& mesh) {
  core::Mesh copy;
  copy.positions = mesh.positions, copy.normals = mesh.normals, copy.indices = mesh.indices;
  return copy;
}

}  // namespace

TileShapes::Placed TileShapes::place(const TileItem& item, double error) {
  const bool mirrored = glm::determinant(item.state.world_from_item.linear) < 0.0;
  Placed placed =
      item.mesh ? place_mesh(item, error, mirrored) : place_primitive(item, std::max(error, tolerance_), mirrored);
  if (mirrored) placed.world_from_mesh.linear[0] = -placed.world_from_mesh.linear[0];
  return placed;
}

TileShapes::Placed TileShapes::place_primitive(const TileItem& item, double tolerance, bool mirror) {
  const core::Primitive primitive = scene_.primitive(item.id);
  const core::Affine& world = item.state.world_from_item;
  const SharedPrimitive shared = shared_primitive(primitive, world.linear);
  if (shared.empty()) return {};
  const auto [at, added] = primitives_.try_emplace({shared.key, tolerance, mirror});
  Shape& shape = at->second;
  if (added) {
    const auto* line = std::get_if<core::Line>(&shared.primitive);
    shape.mesh = line ? line_mesh(*line) : shared.triangles(tolerance, tolerance > tolerance_ ? kFewestSegments : 8);
    if (shared.curved) shape.chord_error = chord_error(shape.mesh);
    // The ends of a cylinder of size 1, whose length counts for nothing here, are on each grid.
    if (shared.curved) round_to(std::min(0.5, grid_of(tolerance / shared.largest_bend)), shape.mesh.positions);
    if (mirror) shape.mesh = mirrored(std::move(shape.mesh));
    order_for_meshopt(shape.mesh);
    note(shape.mesh);
  }
  Placed placed{&shape.mesh, world, shared.bend * shape.chord_error};
  if (shared.curved) placed.grid = grid_of(tolerance), placed.chord_error += std::sqrt(3.0) * placed.grid;
  for (int c = 0; c < 3; ++c) placed.world_from_mesh.linear[c] *= shared.scale[c];
  return placed;
}

TileShapes::Placed TileShapes::place_mesh(const TileItem& item, double error, bool mirror) {
  const core::Affine& world = item.state.world_from_item;
  // Errors in steps of powers of two, rounded down, so that copies of nearly one scale share their triangles.
  const double scale = largest_scale(world.linear), allowed = scale > 0.0 ? kLevelShare * error / scale : 0.0;
  const lod::MeshLevels* levels = allowed > 0.0 ? &levels_of(*item.mesh) : nullptr;
  const bool exact = !levels || levels->empty();
  if (exact && !mirror) return {item.mesh, world};
  const int step = exact ? kExact : std::clamp(std::ilogb(allowed), -126, 126);
  const auto [at, added] = meshes_.try_emplace({item.mesh, step, mirror});
  if (added) {
    at->second = exact ? plain(*item.mesh) : lod::coarse_within(*item.mesh, *levels, std::ldexp(1.0f, step)).mesh;
    if (mirror) at->second = mirrored(std::move(at->second));
    order_for_meshopt(at->second);
    note(at->second);
  }
  return {&at->second, world, 0.0, exact ? 0.0 : grid_of(error)};
}

const lod::MeshLevels& TileShapes::levels_of(const core::Mesh& mesh) {
  const auto [at, added] = levels_.try_emplace(&mesh);
  if (added && lod::needs_levels(mesh) && lod::builds_levels())
    at->second = lod::levels_of(mesh, lod::LevelRange::kAll);
  return at->second;
}

void TileShapes::trim() {
  if (vertices_ <= kMostVertices) return;
  primitives_.clear(), meshes_.clear();
  vertices_ = 0;
}

}  // namespace sightline::importers
