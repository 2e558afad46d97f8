#include "sightline/apps/report/heavy_parts.h"

#include <algorithm>
#include <set>

#include "sightline/apps/common/numbers.h"
#include "sightline/apps/common/tree_walk.h"

namespace sightline::apps {
namespace {

using core::ItemId;
using core::NodeId;

constexpr double kPrimitiveTriangles = 12.0;
constexpr double kSplitAbove = 0.1;                // of the model's weight
constexpr std::uint64_t kManyTriangles = 100'000;  // of a part: levels of detail are worth their memory
constexpr std::uint64_t kManyPerItem = 5'000;      // triangles
constexpr std::size_t kManyItems = 1'000;

bool is_primitive(const core::Scene& scene, ItemId item) {
  return int(scene.kind(item)) < core::kPrimitiveKindCount;
}

std::uint64_t bytes_of(const core::Mesh& mesh) {
  return mesh.positions.size() * sizeof(core::vec3) + mesh.normals.size() * sizeof(core::vec3) +
         mesh.indices.size() * sizeof(std::uint32_t);
}

/// Weights of all nodes with what is below them, by their index.
std::vector<double> weights_of(const core::Scene& scene) {
  std::vector<double> weights;
  std::vector<NodeId> order;
  scene.for_each_node(scene.root(), [&](NodeId node, const core::Affine&, bool visible, std::uint32_t layers, auto) {
    weights.resize(std::max<std::size_t>(weights.size(), node.index + 1));
    order.push_back(node);
    if (!visible || (layers & core::kDefaultLayerMask) == 0) return;
    for (ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item))
      if (scene.item_visible(item))
        weights[node.index] += is_primitive(scene, item) ? kPrimitiveTriangles
                                                         : double(scene.mesh(scene.mesh_of(item)).indices.size() / 3);
  });
  for (auto node = order.rbegin(); node != order.rend(); ++node)
    if (const NodeId parent = scene.parent(*node); parent.valid()) weights[parent.index] += weights[node->index];
  return weights;
}

HeavyPart part_at(const core::Scene& scene, NodeId node, double weight) {
  HeavyPart part{node, {}, 0, 0, weight};
  std::set<std::uint32_t> meshes;
  for (const ItemId item : items_below(scene, node)) {
    if ((scene.state(item).layers & core::kDefaultLayerMask) == 0) continue;
    part.items.push_back(item);
    if (is_primitive(scene, item)) continue;
    const core::MeshId mesh = scene.mesh_of(item);
    part.triangles += scene.mesh(mesh).indices.size() / 3;
    if (meshes.insert(mesh.index).second) part.mesh_bytes += bytes_of(scene.mesh(mesh));
  }
  return part;
}

}  // namespace

std::vector<HeavyPart> heavy_parts(const core::Scene& scene, std::size_t most) {
  const std::vector<double> weights = weights_of(scene);
  const double all = weights[scene.root().index];
  const auto lighter = [&](NodeId a, NodeId b) { return weights[a.index] < weights[b.index]; };
  std::vector<NodeId> heap{scene.root()}, found;  // the heap's heaviest node is its first
  while (!heap.empty() && found.size() < most) {
    std::pop_heap(heap.begin(), heap.end(), lighter);
    const NodeId node = heap.back();
    heap.pop_back();
    if (weights[node.index] == 0.0) break;
    std::vector<NodeId> children = children_of(scene, node);
    std::erase_if(children, [&](NodeId child) { return weights[child.index] == 0.0; });
    const bool whole = scene.parent(node) == core::NodeId() || scene.parent(node) == scene.root();
    if (children.empty() || (!whole && weights[node.index] <= kSplitAbove * all)) {
      found.push_back(node);
      continue;
    }
    // Its own items are a part only together with what is below it.
    double below = 0.0;
    for (const NodeId child : children) below += weights[child.index];
    if (below < 0.5 * weights[node.index]) {
      found.push_back(node);
      continue;
    }
    for (const NodeId child : children) {
      heap.push_back(child);
      std::push_heap(heap.begin(), heap.end(), lighter);
    }
  }
  std::vector<HeavyPart> parts;
  for (const NodeId node : found) parts.push_back(part_at(scene, node, weights[node.index] / all));
  return parts;
}

std::string advice_for(const core::Scene& scene, const HeavyPart& part, bool from_surfaces) {
  const std::size_t meshes = std::size_t(
      std::count_if(part.items.begin(), part.items.end(), [&](ItemId item) { return !is_primitive(scene, item); }));
  const bool fine = meshes > 0 && part.triangles > kManyPerItem * meshes;
  if (fine && from_surfaces)
    return "coarser triangles (--chord-tolerance, --chord-angle), or levels of detail (--lod-error 0.5)";
  if (part.triangles > kManyTriangles || fine) return "levels of detail (--lod-error 0.5); made while it is shown";
  if (meshes > part.items.size() / 2 && !from_surfaces)
    return "primitives in its meshes, if there are any (--recognise)";
  if (part.items.size() > kManyItems) return "leave out what is below a pixel (--min-projected-area 1)";
  return "nothing: it is as light as it can be";
}

}  // namespace sightline::apps
