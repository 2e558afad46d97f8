#include "sightline/importers/tiles/internal/tile_items.h"

#include <algorithm>
#include <bit>
#include <span>
#include <unordered_map>

#include "sightline/core/block_order.h"
#include "sightline/lod/internal/part_of_mesh.h"

namespace sightline::importers {
namespace {

using core::dvec3;

bool is_drawable(const core::Mesh& mesh) {
  return !mesh.indices.empty() &&
         std::ranges::all_of(mesh.positions, [](const core::vec3& p) { return core::is_finite(dvec3(p)); });
}

/// The mesh's triangles in parts that lie together, each of at most so many.
void divide(const core::Mesh& mesh, std::uint32_t most, std::deque<core::Mesh>& parts) {
  const std::size_t triangles = mesh.indices.size() / 3;
  std::vector<core::Aabb> boxes(triangles);
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const core::vec3& p = mesh.positions[mesh.indices[i]];
    boxes[i / 3].grow({p, p});
  }
  const std::uint32_t block = std::bit_floor(most);
  const std::vector<std::uint32_t> order = core::block_order(boxes, {.smallest_block = block});
  lod::PartOfMesh vertices(mesh);
  for (std::size_t first = 0; first < triangles; first += block) {
    core::Mesh& part = parts.emplace_back();
    for (std::size_t i = first; i < std::min<std::size_t>(first + block, triangles); ++i)
      for (std::size_t k = 0; k < 3; ++k) vertices.add(mesh.indices[3 * std::size_t(order[i]) + k], part);
    vertices.clear();
  }
}

core::AabbD box_of(const core::Mesh& mesh, const core::Affine& world) {
  core::AabbD box;
  for (const core::vec3& p : mesh.positions) box.grow(core::transform_point(world, dvec3(p)));
  return box;
}

class Collector {
 public:
  Collector(const core::Scene& scene, std::uint32_t most_triangles) : scene_(scene), most_triangles_(most_triangles) {}

  void add(core::NodeId node, core::ItemId id, const core::Scene::ItemState& state) {
    TileItem item{id, node, state};
    const core::Kind kind = scene_.kind(id);
    const bool shows = (state.layers & core::kDefaultLayerMask) != 0 && core::is_finite(state.world_from_item);
    if (shows && int(kind) >= core::kPrimitiveKindCount) return add_mesh(item);
    add(item, shows ? scene_.bounds_under(id, state.world_from_item) : core::AabbD());
    ++(item.size > 0.0 ? found_.of_kind[std::size_t(kind)] : found_.left_out);
  }
  TileItems take() { return std::move(found_); }

 private:
  using Parts = std::vector<const core::Mesh*>;

  void add_mesh(TileItem& item) {
    const core::MeshId id = scene_.mesh_of(item.id);
    const auto [known, is_new] = parts_.try_emplace(id.index);
    if (is_new) known->second = parts_of(scene_.mesh(id));
    const Parts& parts = known->second;
    const bool divided = parts.size() > 1;
    bool shows = false;
    for (const core::Mesh* part : parts) {
      item.mesh = part;
      add(item, divided ? box_of(*part, item.state.world_from_item)
                        : scene_.bounds_under(item.id, item.state.world_from_item));
      shows = shows || item.size > 0.0;
    }
    ++(shows ? found_.of_kind[std::size_t(scene_.kind(item.id))] : found_.left_out);
    found_.divided += divided;
  }

  Parts parts_of(const core::Mesh& mesh) {
    if (!is_drawable(mesh)) return {};
    if (most_triangles_ == 0 || mesh.indices.size() / 3 <= most_triangles_) return {&mesh};
    const std::size_t before = found_.pieces.size();
    divide(mesh, most_triangles_, found_.pieces);
    Parts parts;
    for (std::size_t i = before; i < found_.pieces.size(); ++i) parts.push_back(&found_.pieces[i]);
    return parts;
  }

  void add(TileItem& item, const core::AabbD& box) {
    constexpr double kOutwards = 1.0 + 1e-9;
    item.box = box;
    item.size = core::is_finite(box.min) && core::is_finite(box.max) ? kOutwards * glm::length(box.size()) : 0.0;
    if (item.size > 0.0 && std::isfinite(item.size)) found_.items.push_back(item);
  }

  const core::Scene& scene_;
  std::uint32_t most_triangles_;
  std::unordered_map<std::uint32_t, Parts> parts_;  // by mesh
  TileItems found_;
};

}  // namespace

TileItems collect_tile_items(const core::Scene& scene, core::NodeId top, std::uint32_t most_triangles,
                             const std::function<bool(double)>& proceed) {
  Collector collector(scene, most_triangles);
  std::uint64_t done = 0;
  const double step = 1.0 / double(std::max<std::size_t>(1, scene.item_count()));
  bool on = true;
  scene.for_each_node(top, [&](core::NodeId node, const core::Affine& world, bool visible, std::uint32_t layers,
                               core::MaterialId material) {
    for (core::ItemId id = scene.first_item(node); id != core::kNoItem && on; id = scene.next_item(id)) {
      on = proceed(step * double(done++));
      collector.add(node, id, scene.state(id, world, visible, layers, material));
    }
  });
  return collector.take();
}

}  // namespace sightline::importers
