// Internal to writers of formats that hold triangles alone: the meshes of a model in the world, one after the other.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "sightline/core/error.h"
#include "sightline/core/scene.h"

namespace sightline::importers {

/// What was visited.
struct WorldMeshReport {
  std::array<std::uint64_t, core::kKindCount> items{};  ///< with triangles, by kind
  std::uint64_t left_out = 0;                           ///< hidden, or without triangles, as lines are
  std::uint64_t vertices = 0, triangles = 0;
  bool normals = true;      ///< all meshes have them
  std::uint64_t bytes = 0;  ///< of the file
  double largest_chord_error = 0.0;
};

/// What is below a node, with primitives as triangles within a tolerance, metres.
struct WorldMeshes {
  const core::Scene& scene;
  core::NodeId node;
  double tolerance;
  std::function<bool(double)> progress = {};
};

/// Calls visit(mesh, world_from_item, material) for each item that is neither hidden nor on layers that are hidden by
/// default, primitives as write_obj() has them. Stops with an error where visit() has one, and as `progress` says.
/// Fails on a tolerance that is not above 0.
core::Expected<WorldMeshReport> for_each_world_mesh(
    const WorldMeshes& meshes,
    const std::function<core::Expected<void>(const core::Mesh&, const core::Affine&, std::uint32_t)>& visit);

/// The corners of a triangle, so that mirrored ones face outwards.
inline std::array<std::uint32_t, 3> corners_of(const core::Mesh& mesh, std::size_t triangle, bool mirrored) {
  const std::uint32_t* at = &mesh.indices[3 * triangle];
  return mirrored ? std::array{at[0], at[2], at[1]} : std::array{at[0], at[1], at[2]};
}

}  // namespace sightline::importers
