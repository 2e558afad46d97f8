#include "sightline/importers/tiles/internal/tile_content.h"

#include <algorithm>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sightline/importers/gltf/internal/gltf_placement.h"
#include "sightline/importers/internal/tessellated.h"
#include "sightline/importers/tiles/internal/tile_parts.h"

namespace sightline::importers {
namespace {

using core::Affine;
using core::dvec3;

/// Vertices that instances must save to be worth a draw call.
constexpr std::size_t kVerticesSaved = 256;

/// An item in the tile's file.
struct Copy {
  Affine file_from_mesh;
  float feature = 0.0f;
  double grid = 0.0;  // TileShapes::Placed::grid
};

/// Copies of one mesh in one material, in the order of the first of each.
struct CopyGroup {
  const core::Mesh* mesh;
  std::uint32_t material;
  std::vector<Copy> copies;
};

/// Meshes of one material as one.
struct Batch {
  std::vector<core::vec3> positions, normals;
  std::vector<std::uint32_t> indices;  // none: lines
  std::vector<float> features;
};

/// Whether floats place a mesh as well as its own extent allows: its coordinates must not cancel the placement's.
bool is_near_its_origin(const core::Mesh& mesh) {
  dvec3 low(mesh.positions[0]), high(low);
  for (const core::vec3& p : mesh.positions) low = glm::min(low, dvec3(p)), high = glm::max(high, dvec3(p));
  return glm::length(0.5 * (low + high)) <= 2.0 * glm::length(high - low);
}

class Content {
 public:
  Content(const core::Scene& scene, core::NodeId top, TileShapes& shapes, GltfOutput& output)
      : scene_(scene), shapes_(shapes), output_(output), parts_(scene, top) {}

  TileCounts write(const TileContent& content) {
    for (const TileItem* item : content.items) add(*item, content.error, content.centre);
    for (const CopyGroup& group : groups_) {
      if (is_worth_instances(group))
        write_instances(group);
      else
        for (const Copy& copy : group.copies) append(*group.mesh, copy, group.material);
    }
    write_batches();
    parts_.write(output_);
    return counts_;
  }

 private:
  void add(const TileItem& item, double error, const dvec3& centre) {
    if (item.size <= error) return;
    const TileShapes::Placed placed = shapes_.place(item, error);
    if (placed.empty()) return;
    Affine world = placed.world_from_mesh;
    world.origin -= centre;
    const Copy copy{kGltfFromWorld * world, float(parts_.row(item.node)), placed.grid};
    counts_.triangles += placed.mesh->indices.size() / 3;
    counts_.largest_chord_error = std::max(counts_.largest_chord_error, placed.chord_error);
    if (placed.mesh->indices.empty() || !is_decomposable(copy.file_from_mesh.linear))
      return append(*placed.mesh, copy, item.state.material);
    const auto [at, added] = group_of_.try_emplace({placed.mesh, item.state.material}, groups_.size());
    if (added) groups_.push_back({placed.mesh, item.state.material, {}});
    groups_[at->second].copies.push_back(copy);
  }

  static bool is_worth_instances(const CopyGroup& group) {
    return (group.copies.size() - 1) * group.mesh->positions.size() >= kVerticesSaved &&
           is_near_its_origin(*group.mesh);
  }

  void append(const core::Mesh& mesh, const Copy& copy, std::uint32_t material) {
    Batch& batch = batches_[{material, mesh.normals.empty(), mesh.indices.empty()}];
    const auto first = std::uint32_t(batch.positions.size());
    for (const core::vec3& p : mesh.positions) {
      const dvec3 place = core::transform_point(copy.file_from_mesh, dvec3(p));
      batch.positions.emplace_back(copy.grid > 0.0 ? copy.grid * glm::round(place / copy.grid) : place);
    }
    const core::dmat3 turn = normal_map(copy.file_from_mesh.linear);
    for (const core::vec3& n : mesh.normals) {
      const dvec3 normal = turn * dvec3(n);
      const double length = glm::length(normal);
      batch.normals.emplace_back(length > 0.0 ? normal / length : dvec3(0, 0, 1));
    }
    for (const std::uint32_t i : mesh.indices) batch.indices.push_back(first + i);
    batch.features.insert(batch.features.end(), mesh.positions.size(), copy.feature);
  }

  std::uint32_t material(std::uint32_t index) {
    const auto [at, added] = materials_.try_emplace(index, 0);
    if (added)
      at->second =
          output_.material(index == core::kNone ? core::Material{} : scene_.material(scene_.material_at(index)));
    return at->second;
  }

  /// Members of a primitive: what it is drawn from.
  std::string geometry(std::span<const core::vec3> positions, std::span<const core::vec3> normals,
                       std::span<const std::uint32_t> indices, std::uint32_t look, const std::string& attributes) {
    std::string text = fmt::format("\"attributes\":{{\"POSITION\":{}", output_.positions(positions));
    if (!normals.empty()) text += fmt::format(",\"NORMAL\":{}", output_.normals(normals));
    text += attributes + '}';
    if (indices.empty()) text += ",\"mode\":1";
    if (!indices.empty()) text += fmt::format(",\"indices\":{}", output_.indices(indices, positions.size()));
    return text + fmt::format(",\"material\":{}", material(look));
  }

  void write_instances(const CopyGroup& group) {
    const core::Mesh& mesh = *group.mesh;
    const std::uint32_t number = output_.mesh(
        "\"primitives\":[{" + geometry(mesh.positions, mesh.normals, mesh.indices, group.material, "") + "}]");
    std::vector<Affine> placements;
    std::vector<float> features;
    for (const Copy& copy : group.copies) placements.push_back(copy.file_from_mesh), features.push_back(copy.feature);
    counts_.instances += group.copies.size();
    const std::string attributes = instance_attributes(output_, placements);
    output_.node(core::kNone,
                 fmt::format("\"mesh\":{},\"extensions\":{{\"EXT_mesh_gpu_instancing\":{{\"attributes\":{{{},"
                             "\"_FEATURE_ID_0\":{}}}}},\"EXT_instance_features\":{}}}",
                             number, attributes, output_.numbers(features, 1), TileParts::feature_ids(features)));
    output_.use_extension("EXT_mesh_gpu_instancing", true);
    output_.use_extension("EXT_instance_features", false);
  }

  void write_batches() {
    std::string primitives;
    for (const auto& [key, batch] : batches_) {
      const std::string attributes = fmt::format(",\"_FEATURE_ID_0\":{}", output_.features(batch.features));
      primitives += primitives.empty() ? "{" : ",{";
      primitives += geometry(batch.positions, batch.normals, batch.indices, std::get<0>(key), attributes);
      primitives += ",\"extensions\":{\"EXT_mesh_features\":" + TileParts::feature_ids(batch.features) + "}}";
    }
    if (primitives.empty()) return;
    output_.use_extension("EXT_mesh_features", false);
    output_.node(core::kNone, fmt::format("\"mesh\":{}", output_.mesh("\"primitives\":[" + primitives + "]")));
  }

  const core::Scene& scene_;
  TileShapes& shapes_;
  GltfOutput& output_;
  TileParts parts_;
  TileCounts counts_;
  std::vector<CopyGroup> groups_;
  std::map<std::pair<const core::Mesh*, std::uint32_t>, std::size_t> group_of_;
  std::map<std::tuple<std::uint32_t, bool, bool>, Batch> batches_;  // material, without normals, lines
  std::map<std::uint32_t, std::uint32_t> materials_;
};

}  // namespace

TileCounts write_tile_content(const core::Scene& scene, core::NodeId top, const TileContent& content,
                              TileShapes& shapes, GltfOutput& output) {
  return Content(scene, top, shapes, output).write(content);
}

}  // namespace sightline::importers
