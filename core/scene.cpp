#include "sightline/core/scene.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "sightline/core/internal/access.h"
#include "sightline/core/internal/contract.h"
#include "sightline/core/internal/prefetch.h"
#include "sightline/core/internal/radix_sort.h"
#include "sightline/core/internal/stored_attributes.h"

namespace sightline::core {
namespace {

/// World coordinates beyond this could overflow single precision in a plane test.
constexpr double kLargestCoordinate = 1e37;

bool publishable(const AabbD& box) {
  if (glm::any(glm::isnan(box.min)) || glm::any(glm::isnan(box.max))) return false;
  if (box.empty()) return true;
  for (int i = 0; i < 3; ++i)
    if (!(box.min[i] > -kLargestCoordinate && box.max[i] < kLargestCoordinate)) return false;
  return true;
}

/// Snapshots keep the linear part and the chunk-relative origin in float.
bool publishable(const Affine& world_from_item) {
  for (const dvec3& v :
       {world_from_item.linear[0], world_from_item.linear[1], world_from_item.linear[2], world_from_item.origin})
    for (int i = 0; i < 3; ++i)
      if (!(std::abs(v[i]) < kLargestCoordinate)) return false;
  return true;
}

/// Whether no point of the box comes near the limit under the map. False for a box that is empty or not finite.
bool surely_publishable(const AabbD& box, const Affine& world_from_item) {
  if (box.empty()) return false;
  const dvec3 reach = glm::max(glm::abs(box.min), glm::abs(box.max));
  dvec3 farthest = glm::abs(world_from_item.origin);
  for (int i = 0; i < 3; ++i) farthest += glm::abs(world_from_item.linear[i]) * reach[i];
  return glm::all(glm::lessThan(farthest, dvec3(0.5 * kLargestCoordinate)));
}

/// Whether each coordinate of a result depends on one of the argument alone: no rotation but by right angles.
bool keeps_axes(const dmat3& m) {
  int most = 0;
  for (int row = 0; row < 3; ++row)
    most = std::max(most, int(m[0][row] != 0.0) + int(m[1][row] != 0.0) + int(m[2][row] != 0.0));
  return most <= 1;
}

/// Bounds of a mesh under a map, by its own. Vertex by vertex where it turns: the box of a rotated box would be up to
/// sqrt(3) too large. Elsewhere rounding is monotone, and the corners of the box give the very same.
AabbD mesh_extent(const Mesh& mesh, const AabbD& bounds, const Affine& world_from_item) {
  const AabbD refused{dvec3(std::numeric_limits<double>::quiet_NaN()), dvec3(0.0)};  // commit() refuses it
  AabbD box;
  const auto grow = [&](const dvec3& p) {
    const dvec3 q = transform_point(world_from_item, p);
    if (is_finite(q)) box.grow(q);
    return is_finite(q);
  };
  if (keeps_axes(world_from_item.linear)) {
    if (!mesh.positions.empty() && !(grow(bounds.min) && grow(bounds.max))) return refused;
  } else {
    for (const vec3& p : mesh.positions)
      if (!grow(dvec3(p))) return refused;
  }
  if (box.empty()) return box;
  constexpr double kPad = 16.0 * std::numeric_limits<double>::epsilon();
  const dvec3 pad = kPad * glm::max(glm::abs(box.min), glm::abs(box.max));
  return {box.min - pad, box.max + pad};
}

}  // namespace

Scene::Scene() {
  nodes_.emplace_back();
  nodes_[0].alive = true;
  nodes_[0].layers = kLayerModel;
  live_nodes_ = 1;
  root_ = {0, 0};
}

// --- nodes -----------------------------------------------------------------------------------------------------------

bool Scene::contains(NodeId node) const {
  return node.index < nodes_.size() && nodes_[node.index].alive && nodes_[node.index].generation == node.generation;
}

Scene::Node& Scene::live(NodeId node) {
  SIGHTLINE_CONTRACT(contains(node), "a node handle that is neither stale nor invalid");
  return nodes_[node.index];
}
const Scene::Node& Scene::live(NodeId node) const {
  SIGHTLINE_CONTRACT(contains(node), "a node handle that is neither stale nor invalid");
  return nodes_[node.index];
}
Scene::Item& Scene::live(ItemId item) {
  SIGHTLINE_CONTRACT(contains_item(item), "an item that is neither removed nor unknown");
  return items_[to_index(item)];
}
const Scene::Item& Scene::live(ItemId item) const {
  SIGHTLINE_CONTRACT(contains_item(item), "an item that is neither removed nor unknown");
  return items_[to_index(item)];
}

NodeId Scene::handle(std::uint32_t index) const {
  return index == kNone ? NodeId{} : NodeId{index, nodes_[index].generation};
}

void Scene::link(std::uint32_t index, std::uint32_t parent) {
  Node& node = nodes_[index];
  Node& above = nodes_[parent];
  node.parent = parent;
  node.previous = above.last_child;
  node.next = kNone;
  if (above.last_child != kNone) nodes_[above.last_child].next = index;
  if (above.first_child == kNone) above.first_child = index;
  above.last_child = index;
}

void Scene::unlink(std::uint32_t index) {
  Node& node = nodes_[index];
  Node& above = nodes_[node.parent];
  (node.previous == kNone ? above.first_child : nodes_[node.previous].next) = node.next;
  (node.next == kNone ? above.last_child : nodes_[node.next].previous) = node.previous;
  node.parent = node.previous = node.next = kNone;
}

NodeId Scene::add_node(NodeId parent, std::string_view name, const Affine& parent_from_node) {
  (void)live(parent);
  std::uint32_t index;
  if (free_nodes_.empty()) {
    index = std::uint32_t(nodes_.size());
    nodes_.emplace_back();
  } else {
    index = free_nodes_.back();
    free_nodes_.pop_back();
    const std::uint32_t generation = nodes_[index].generation;
    nodes_[index] = {};
    nodes_[index].generation = generation;
  }
  nodes_[index].alive = true;
  nodes_[index].transform = parent_from_node;
  link(index, parent.index);
  ++live_nodes_;
  const NodeId node = handle(index);
  set_name(node, name);
  return node;
}

void Scene::remove_node(NodeId node) {
  SIGHTLINE_CONTRACT(node != root_, "a node other than the root, which stays");
  (void)live(node);
  unlink(node.index);
  std::vector<std::uint32_t> subtree{node.index};
  for (std::size_t i = 0; i < subtree.size(); ++i)
    for (std::uint32_t c = nodes_[subtree[i]].first_child; c != kNone; c = nodes_[c].next) subtree.push_back(c);
  for (const std::uint32_t index : subtree) {
    for (ItemId item = nodes_[index].first_item; item != kNoItem; item = items_[to_index(item)].next) erase_item(item);
    if (stored_attributes_ && stored_attributes_->has(index))
      attributes_[index].clear();  // another node may get the index
    else
      attributes_.erase(index);
    dead_name_bytes_ += nodes_[index].name_length;
    nodes_[index].alive = nodes_[index].dirty = false;
    ++nodes_[index].generation;
    free_nodes_.push_back(index);
  }
  live_nodes_ -= subtree.size();
  compact_names();
}

Expected<void> Scene::reparent(NodeId node, NodeId new_parent) {
  SIGHTLINE_CONTRACT(node != root_, "a node other than the root, which stays");
  (void)live(node);
  (void)live(new_parent);
  for (std::uint32_t i = new_parent.index; i != kNone; i = nodes_[i].parent)
    if (i == node.index)
      return fail("node \"" + path(node) + "\": expected a parent outside its subtree, found \"" + path(new_parent) +
                  "\"");
  unlink(node.index);
  link(node.index, new_parent.index);
  touch_node(node.index);
  return {};
}

void Scene::set_transform(NodeId node, const Affine& parent_from_node) {
  live(node).transform = parent_from_node;
  touch_node(node.index);
}
void Scene::set_visible(NodeId node, bool visible) {
  live(node).visible = visible;
  touch_node(node.index);
}
void Scene::set_layers(NodeId node, std::uint32_t layers) {
  live(node).layers = layers;
  touch_node(node.index);
}
void Scene::set_material(NodeId node, MaterialId material) {
  live(node).material = index_of(material);
  touch_node(node.index);
}
void Scene::set_name(NodeId node, std::string_view name) {
  Node& n = live(node);
  if (name.size() <= n.name_length) {
    dead_name_bytes_ += n.name_length - name.size();
    if (!name.empty()) std::char_traits<char>::move(names_.data() + n.name_offset, name.data(), name.size());
  } else {
    assert(names_.size() + name.size() < kNone && "more than 4 GiB of names");
    dead_name_bytes_ += n.name_length;
    n.name_offset = std::uint32_t(names_.size());
    names_.insert(names_.end(), name.begin(), name.end());
  }
  n.name_length = std::uint32_t(name.size());
  compact_names();
}

/// Drops dead bytes when there are at least as many as live ones, and enough to be worth the walk over all nodes.
void Scene::compact_names() {
  constexpr std::size_t kWorthwhile = 4096;
  if (dead_name_bytes_ < nodes_.size() + kWorthwhile || 2 * dead_name_bytes_ < names_.size()) return;
  LargeArray<char> kept;
  kept.reserve(names_.size() - dead_name_bytes_);
  for (Node& n : nodes_) {
    if (!n.alive) continue;
    const std::uint32_t offset = std::uint32_t(kept.size());
    const char* const name = names_.data() + n.name_offset;
    kept.insert(kept.end(), name, name + n.name_length);
    n.name_offset = offset;
  }
  names_ = std::move(kept);
  dead_name_bytes_ = 0;
}
void Scene::set_attribute(NodeId node, std::string_view key, std::string_view value) {
  (void)live(node);
  const auto [entry, fresh] = attributes_.try_emplace(node.index);
  Attributes& list = entry->second;
  if (fresh && stored_attributes_)
    if (const Attributes* stored = stored_attributes_->find(node.index)) list = *stored;
  const auto found = std::find_if(list.begin(), list.end(), [&](const auto& a) { return a.first == key; });
  if (found != list.end()) {
    found->second = value;
  } else {
    list.emplace_back(key, value);
  }
}

std::string_view Scene::name(NodeId node) const {
  const Node& n = live(node);
  return n.name_length == 0 ? std::string_view() : std::string_view(names_.data() + n.name_offset, n.name_length);
}
MaterialId Scene::material(NodeId node) const {
  return material_at(live(node).material);
}

const Scene::Attributes& Scene::attributes(NodeId node) const {
  static const Attributes kNoAttributes;
  (void)live(node);
  if (const auto found = attributes_.find(node.index); found != attributes_.end()) return found->second;
  const Attributes* stored = stored_attributes_ ? stored_attributes_->find(node.index) : nullptr;
  return stored ? *stored : kNoAttributes;
}

void Scene::read_all_attributes() {
  if (!stored_attributes_) return;
  const StoredAttributes& stored = stored_attributes_->stored();
  for (std::size_t i = 0; i < stored.nodes.size(); ++i)
    if (const auto [entry, fresh] = attributes_.try_emplace(stored.nodes[i]); fresh) entry->second = stored.list(i);
  stored_attributes_ = {};
}

Affine Scene::world_from_node(NodeId node) const {
  Affine world = live(node).transform;
  for (std::uint32_t i = nodes_[node.index].parent; i != kNone; i = nodes_[i].parent)
    world = nodes_[i].transform * world;
  return world;
}

std::string Scene::path(NodeId node) const {
  std::vector<std::string> names;
  for (; node.valid() && node != root_; node = parent(node)) {
    std::string label(name(node));
    if (label.empty()) {
      int position = 0;
      for (std::uint32_t i = live(node).previous; i != kNone; i = nodes_[i].previous) ++position;
      label = '#';
      label += std::to_string(position);
    }
    names.push_back(std::move(label));
  }
  std::string path;
  for (auto it = names.rbegin(); it != names.rend(); ++it) path.append(path.empty() ? "" : "/").append(*it);
  return path;
}

/// Prefetches an item's own data, and half as far ahead its node and parameters.
void Scene::prefetch_ahead(std::span<const ItemId> items, std::size_t at) const {
  if (at + kPrefetchAhead < items.size()) prefetch(items_[to_index(items[at + kPrefetchAhead])]);
  if (at + kPrefetchAhead / 2 >= items.size()) return;
  const Item& item = items_[to_index(items[at + kPrefetchAhead / 2])];
  prefetch(nodes_[item.node]);
  if (int(item.kind) < kPrimitiveKindCount) prefetch(parameters_[item.payload]);
}

Scene::Resolved Scene::resolve(const Node& node, const Resolved& above) const {
  const std::uint32_t own = material_at(node.material).index;
  return {above.world * node.transform, node.layers != 0 ? node.layers : above.layers,
          own != kNone ? own : above.material, above.visible && node.visible};
}

Scene::Resolved Scene::resolve_above(NodeId node) const {
  std::vector<std::uint32_t> up;
  for (std::uint32_t i = live(node).parent; i != kNone; i = nodes_[i].parent) up.push_back(i);
  Resolved resolved{{}, kLayerModel, kNone, true};
  for (auto it = up.rbegin(); it != up.rend(); ++it) resolved = resolve(nodes_[*it], resolved);
  return resolved;
}

const Scene::Resolved& Scene::resolve_once(std::uint32_t index, ResolvedNodes& known) const {
  known.place.resize(nodes_.size(), kNone);
  known.path.clear();
  for (std::uint32_t i = index; i != kNone && known.place[i] == kNone; i = nodes_[i].parent) known.path.push_back(i);
  for (auto it = known.path.rbegin(); it != known.path.rend(); ++it) {
    const std::uint32_t parent = nodes_[*it].parent;
    const Resolved above = parent == kNone ? Resolved{{}, kLayerModel, kNone, true} : known.values[known.place[parent]];
    known.place[*it] = std::uint32_t(known.values.size());
    known.values.push_back(resolve(nodes_[*it], above));
  }
  return known.values[known.place[index]];
}

// --- shared resources ------------------------------------------------------------------------------------------------

Expected<MeshId> Scene::add_mesh(Mesh mesh) {
  if (auto valid = validate(mesh); !valid) return tl::unexpected(valid.error());
  AabbD box;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    if (!is_finite(dvec3(mesh.positions[i])))
      return fail("mesh \"" + mesh.name + "\": expected finite positions, found one that is not at vertex " +
                  std::to_string(i));
    box.grow(dvec3(mesh.positions[i]));
  }
  auto shared = std::make_shared<const Mesh>(std::move(mesh));
  if (const auto index = may_reuse() ? free_.meshes.take() : std::nullopt) {
    mesh_table_.set(*index, std::move(shared));
    meshes_[*index] = {box, generation_};
    return mesh_at(*index);
  }
  mesh_table_.push_back(std::move(shared));
  meshes_.push_back({box, generation_});
  return mesh_at(meshes_.size() - 1);
}
MaterialId Scene::add_material(Material material) {
  const auto freed = may_reuse() ? free_.materials.take() : std::nullopt;
  const std::uint32_t index = freed.value_or(std::uint32_t(materials_.size()));
  if (!freed) materials_.emplace_back();
  materials_[index] = {std::move(material), generation_};
  dirty_materials_.push_back(index);
  return material_at(index);
}
void Scene::update_material(MaterialId id, Material as) {
  (void)material(id);
  materials_[id.index].material = std::move(as);
  dirty_materials_.push_back(id.index);
}
void Scene::remove_material(MaterialId id) {
  (void)material(id);
  materials_[id.index] = {{}, kNone};
  removed_materials_.push_back(id.index);
  dirty_materials_.push_back(id.index);
  stored_snapshot_.reset();
}
/// Touches what names a removed material, which no longer has one.
void Scene::forget_removed_materials() {
  if (removed_materials_.empty()) return;
  const auto is_removed = [&](std::uint32_t index) { return index != kNone && materials_[index].generation == kNone; };
  for (std::uint32_t n = 0; n < nodes_.size(); ++n)
    if (nodes_[n].alive && is_removed(nodes_[n].material)) nodes_[n].material = kNone, touch_node(n);
  for (ItemId i{0}; to_index(i) < items_.size(); ++i)
    if (items_[to_index(i)].alive && is_removed(items_[to_index(i)].material))
      items_[to_index(i)].material = kNone, touch_item(i);
}
void Scene::remove_mesh(MeshId id) {
  (void)mesh(id);
  SIGHTLINE_CONTRACT(std::none_of(items_.begin(), items_.end(),
                                  [&](const Item& item) {
                                    return item.alive && int(item.kind) >= kPrimitiveKindCount &&
                                           item.payload == id.index;
                                  }),
                     "a mesh that no item uses");
  meshes_[id.index] = {{}, kNone};
  removed_meshes_.push_back(id.index);
}
bool Scene::contains(MeshId mesh) const {
  return mesh.index < meshes_.size() && mesh_at(mesh.index) == mesh;
}
bool Scene::contains(MaterialId material) const {
  return material.index < materials_.size() && material_at(material.index) == material;
}
MeshId Scene::mesh_at(std::size_t index) const {
  if (index == kNone || meshes_[index].generation == kNone) return {};
  return {std::uint32_t(index), meshes_[index].generation};
}
MaterialId Scene::material_at(std::size_t index) const {
  if (index == kNone || materials_[index].generation == kNone) return {};
  return {std::uint32_t(index), materials_[index].generation};
}
/// kNone for an invalid handle.
std::uint32_t Scene::index_of(MaterialId material) const {
  SIGHTLINE_CONTRACT(!material.valid() || contains(material), "a material handle that is not stale");
  return material.index;
}
const Mesh& Scene::mesh(MeshId mesh) const {
  SIGHTLINE_CONTRACT(contains(mesh), "a mesh handle that is neither stale nor invalid");
  return mesh_table_[mesh.index];
}
const AabbD& Scene::mesh_bounds(MeshId mesh) const {
  SIGHTLINE_CONTRACT(contains(mesh), "a mesh handle that is neither stale nor invalid");
  return meshes_[mesh.index].bounds;
}
const Material& Scene::material(MaterialId material) const {
  SIGHTLINE_CONTRACT(contains(material), "a material handle that is neither stale nor invalid");
  return materials_[material.index].material;
}

// --- items -----------------------------------------------------------------------------------------------------------

ItemId Scene::append_item(NodeId node, Item item) {
  Node& owner = live(node);
  const auto freed = may_reuse() ? free_.items.take() : std::nullopt;
  const ItemId id = freed.value_or(ItemId(items_.size()));
  item.node = node.index;
  item.alive = true;
  item.previous = owner.last_item;
  if (!freed) items_.emplace_back(), item_states_.push_back(0);
  items_[to_index(id)] = item;
  item_states_[to_index(id)] &= kDirty;  // it may be in dirty_items_
  (owner.last_item == kNoItem ? owner.first_item : items_[to_index(owner.last_item)].next) = id;
  owner.last_item = id;
  ++live_items_;
  touch_item(id);
  return id;
}

/// Keeps the parameters of an item; returns its payload.
std::uint32_t Scene::store(Kind kind, const float* values) {
  const auto count = std::size_t(parameter_count(kind));
  auto& freed = free_.parameters[std::size_t(kind)];
  if (!may_reuse() || freed.empty()) {
    parameters_.insert(parameters_.end(), values, values + count);
    return std::uint32_t(parameters_.size() - count);
  }
  const std::uint32_t payload = freed.back();
  freed.pop_back();
  std::copy_n(values, count, parameters_.begin() + payload);
  return payload;
}

ItemId Scene::add_primitive(NodeId node, const Primitive& primitive, const Affine& node_from_item,
                            MaterialId material) {
  Item item;
  item.linear = mat3(node_from_item.linear);
  item.origin = node_from_item.origin;
  item.material = index_of(material);
  item.kind = kind_of(primitive);
  item.payload = store(item.kind, parameters(primitive).data());
  return append_item(node, item);
}

ItemId Scene::add_mesh_instance(NodeId node, MeshId mesh_id, const Affine& node_from_item, MaterialId material) {
  Item item;
  item.linear = mat3(node_from_item.linear);
  item.origin = node_from_item.origin;
  item.material = index_of(material);
  item.kind = mesh(mesh_id).is_facet_group() ? Kind::kFacetGroup : Kind::kMesh;
  item.payload = mesh_id.index;
  return append_item(node, item);
}

void Scene::erase_item(ItemId id) {
  Item& item = items_[to_index(id)];
  if (!item.alive) return;
  item.alive = false;
  --live_items_;
  stored_snapshot_.reset();
  item_states_[to_index(id)] &= std::uint8_t(~kFit);
  if (reuses_ids_ && int(item.kind) < kPrimitiveKindCount)
    free_.parameters[std::size_t(item.kind)].push_back(item.payload);
  if (item_states_[to_index(id)] & kCommitted)
    removed_items_.push_back(id);
  else if (reuses_ids_)
    free_.items.remove({&id, 1}, free_.items.kAtOnce);
}

void Scene::remove_item(ItemId id) {
  const Item& item = live(id);
  Node& owner = nodes_[item.node];
  (item.previous == kNoItem ? owner.first_item : items_[to_index(item.previous)].next) = item.next;
  (item.next == kNoItem ? owner.last_item : items_[to_index(item.next)].previous) = item.previous;
  erase_item(id);
}

void Scene::set_placement(ItemId id, const Affine& node_from_item) {
  Item& item = live(id);
  item.linear = mat3(node_from_item.linear);
  item.origin = node_from_item.origin;
  touch_item(id);
}
void Scene::set_visible(ItemId id, bool visible) {
  live(id).visible = visible;
  touch_item(id);
}
void Scene::set_mesh(ItemId id, MeshId mesh_id) {
  Item& item = live(id);
  SIGHTLINE_CONTRACT(item.kind == (mesh(mesh_id).is_facet_group() ? Kind::kFacetGroup : Kind::kMesh),
                     "an item of a mesh of that kind");
  item.payload = mesh_id.index;
  touch_item(id);
}
void Scene::set_material(ItemId id, MaterialId material) {
  live(id).material = index_of(material);
  touch_item(id);
}

Primitive Scene::primitive(ItemId id) const {
  const Item& item = live(id);
  return make_primitive(item.kind,
                        std::span(parameters_).subspan(item.payload, std::size_t(parameter_count(item.kind))));
}
MeshId Scene::mesh_of(ItemId id) const {
  SIGHTLINE_CONTRACT(int(live(id).kind) >= kPrimitiveKindCount, "an item with a mesh");
  return mesh_at(live(id).payload);
}
Affine Scene::placement(ItemId id) const {
  return {dmat3(live(id).linear), live(id).origin};
}
NodeId Scene::node_of(ItemId id) const {
  return handle(live(id).node);
}
MaterialId Scene::item_material(ItemId id) const {
  return material_at(live(id).material);
}

AabbD Scene::bounds_under(ItemId id, const Affine& world_from_item) const {
  const Item& item = live(id);
  if (int(item.kind) < kPrimitiveKindCount) return core::bounds(primitive(id), world_from_item);
  return mesh_extent(mesh_table_[item.payload], meshes_[item.payload].bounds, world_from_item);
}

AabbD Scene::bounds(NodeId top, std::uint32_t mask) const {
  AabbD all;
  for_each_node(top, [&](NodeId node, const Affine& world, bool visible, std::uint32_t layers, MaterialId material) {
    for (ItemId item = first_item(node); item != kNoItem; item = next_item(item))
      if (const ItemState s = state(item, world, visible, layers, material); (s.layers & mask) != 0)
        all.grow(bounds_under(item, s.world_from_item));
  });
  return all;
}

Scene::ItemState Scene::state(ItemId id, const Affine& world_from_node, bool visible, std::uint32_t layers,
                              MaterialId material) const {
  const Item& item = live(id);
  const std::uint32_t own = material_at(item.material).index;
  return {world_from_node * Affine{dmat3(item.linear), item.origin}, visible && item.visible ? layers : 0u,
          own != kNone ? own : material.index};
}

Scene::ItemState Scene::state(ItemId id) const {
  const NodeId node = node_of(id);
  const Resolved here = resolve(live(node), resolve_above(node));
  return state(id, here.world, here.visible, here.layers, material_at(here.material));
}

// --- publishing ------------------------------------------------------------------------------------------------------

void Scene::touch_node(std::uint32_t index) {
  stored_snapshot_.reset();
  if (nodes_[index].dirty) return;
  nodes_[index].dirty = true;
  dirty_nodes_.push_back(index);
}

void Scene::touch_item(ItemId id) {
  stored_snapshot_.reset();
  std::uint8_t& state = item_states_[to_index(id)];
  state &= std::uint8_t(~kFit);
  if (state & kDirty) return;
  state |= kDirty;
  dirty_items_.push_back(id);
}

bool Scene::can_commit(ItemId item, const Affine& world_from_item) const {
  if (!publishable(world_from_item)) return false;
  // Tests the box first, so as not to walk a mesh once for each of its instances: nearly all boxes lie well within the
  // limit.
  if (const Item& it = live(item); int(it.kind) >= kPrimitiveKindCount)
    if (surely_publishable(meshes_[it.payload].bounds, world_from_item)) return true;
  return publishable(bounds_under(item, world_from_item));
}

Expected<SceneDelta> Scene::validated(std::span<const ItemId> items) const {
  SceneDelta delta;
  ItemId bad = kNoItem;
  const auto accept = [&](ItemId id) {
    (item_states_[to_index(id)] & kCommitted ? delta.changed : delta.inserted).push_back(id);
  };
  if (std::all_of(items.begin(), items.end(), [&](ItemId id) { return (item_states_[to_index(id)] & kFit) != 0; })) {
    delta.inserted.reserve(items.size());
    for (const ItemId id : items) accept(id);  // not removed since: that would have taken its bit
    return delta;
  }
  for_each_state(items, [&](ItemId id, const ItemState& state) {
    if (bad != kNoItem) return;
    if (item_states_[to_index(id)] & kFit || can_commit(id, state.world_from_item)) {
      accept(id);
    } else {
      bad = id;
    }
  });
  if (bad == kNoItem) return delta;
  return fail("node \"" + path(node_of(bad)) + "\": item " + std::to_string(to_index(bad)) + " (" +
              std::string(name_of(kind(bad))) +
              ") has parameters, a placement or bounds that are not finite or reach beyond 1e37 m");
}

/// Frees the ids whose removal all subscribers have followed. What gets one of these indices has a new generation.
void Scene::release_ids() {
  std::uint64_t followed = commits_;
  for (const auto& subscriber : subscribers_.inboxes)
    if (const auto inbox = subscriber.lock()) followed = std::min(followed, inbox->followed);
  free_.items.release(followed);
  const bool meshes = free_.meshes.release(followed), materials = free_.materials.release(followed);
  if ((meshes || materials) && ++generation_ == kNone) generation_ = 0;
}

namespace {

constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

/// Takes up to `most` off the end of a list. They come sorted.
template <class Id>
std::vector<Id> take_last(std::vector<Id>& list, std::size_t most) {
  std::vector<Id> taken;
  if (most >= list.size()) {
    taken = std::exchange(list, {});
  } else {
    taken.assign(list.end() - std::ptrdiff_t(most), list.end());
    list.resize(list.size() - most);
  }
  if (!std::is_sorted(taken.begin(), taken.end())) radix_sort(taken);
  return taken;
}

}  // namespace

/// Returns the touched items in rising order, removed ones included. Everything below a touched node becomes a touched
/// item. Linear time: a node is entered once, no matter how many nodes above it were touched.
std::vector<ItemId> Access::touched_items(Scene& s) {
  const auto stored_snapshot = s.stored_snapshot_;  // edits have dropped it where they had to
  std::vector<std::uint32_t> below;
  std::vector<bool> entered(s.dirty_nodes_.empty() ? 0 : s.nodes_.size());
  const auto enter = [&](std::uint32_t node) {
    if (!entered[node]) below.push_back(node);
    entered[node] = true;
  };
  for (const std::uint32_t node : s.dirty_nodes_)
    if (s.nodes_[node].dirty) enter(node);  // else removed since, and another node may have its index
  for (std::size_t i = 0; i < below.size(); ++i) {
    const Node& node = s.nodes_[below[i]];
    for (std::uint32_t c = node.first_child; c != kNone; c = s.nodes_[c].next) enter(c);
    for (ItemId item = node.first_item; item != kNoItem; item = s.items_[to_index(item)].next) s.touch_item(item);
  }
  s.stored_snapshot_ = stored_snapshot;
  std::vector<ItemId> items = s.dirty_items_;
  if (!std::is_sorted(items.begin(), items.end())) radix_sort(items);
  return items;
}

/// Makes items below touched nodes touched ones, until there are so many. A node waits for touched ones above it, which
/// lead to it again.
void Access::touch_items_below(Scene& s, std::size_t wanted) {
  constexpr int kSteps = 64;                        // upwards, at most: beyond, a node may be entered again
  const auto stored_snapshot = s.stored_snapshot_;  // edits have dropped it where they had to
  while (s.dirty_items_.size() < wanted && !s.dirty_nodes_.empty()) {
    const std::uint32_t index = s.dirty_nodes_.back();
    s.dirty_nodes_.pop_back();
    Node& node = s.nodes_[index];
    if (!std::exchange(node.dirty, false)) continue;  // removed since, and another node may have its index
    std::uint32_t above = node.parent;
    for (int step = 0; step < kSteps && above != kNone && !s.nodes_[above].dirty; ++step)
      above = s.nodes_[above].parent;
    if (above != kNone && s.nodes_[above].dirty) continue;
    for (std::uint32_t c = node.first_child; c != kNone; c = s.nodes_[c].next) s.touch_node(c);
    for (ItemId item = node.first_item; item != kNoItem; item = s.items_[to_index(item)].next) s.touch_item(item);
  }
  s.stored_snapshot_ = stored_snapshot;
}

Expected<SceneDelta> Scene::commit() {
  return Access::publish(*this, kAll);
}

Expected<SceneDelta> Access::publish(Scene& s, std::size_t most) {
  if (!s.removed_materials_.empty()) most = kAll;  // all items are walked over once
  s.forget_removed_materials();
  const std::size_t removals = std::min(most, s.removed_items_.size());
  std::vector<ItemId> items;
  if (most == kAll) {
    items = touched_items(s);
  } else {
    touch_items_below(s, most - removals);
    items = take_last(s.dirty_items_, most - removals);
  }
  auto delta = s.validated(items);
  if (!delta) {
    if (most != kAll) s.dirty_items_.insert(s.dirty_items_.end(), items.begin(), items.end());
    return delta;
  }
  for (const ItemId id : items) s.item_states_[to_index(id)] = Scene::kCommitted;
  if (most == kAll) {
    for (const std::uint32_t node : s.dirty_nodes_) s.nodes_[node].dirty = false;
    s.dirty_items_ = {};
    s.dirty_nodes_.clear();
  }
  delta->removed = take_last(s.removed_items_, removals);
  delta->materials = take_last(s.dirty_materials_, kAll);
  delta->materials.erase(std::unique(delta->materials.begin(), delta->materials.end()), delta->materials.end());
  announce(s, *delta);
  return delta;
}

/// Counts what is published as a commit, frees ids, and tells all subscribers.
void Access::announce(Scene& s, const SceneDelta& delta) {
  s.commits_ += !delta.empty();
  if (s.reuses_ids_) s.free_.items.remove(delta.removed, s.commits_);
  if (s.dirty_items_.empty() && s.dirty_nodes_.empty() && s.removed_items_.empty()) {
    s.mesh_table_.remove(s.removed_meshes_);
    if (s.reuses_ids_) s.free_.meshes.remove(s.removed_meshes_, s.commits_);
    s.removed_meshes_.clear();
  }
  if (s.reuses_ids_) s.free_.materials.remove(s.removed_materials_, s.commits_);
  s.removed_materials_.clear();
  if (!delta.empty())
    for (const auto& subscriber : s.subscribers_.inboxes)
      if (const auto inbox = subscriber.lock()) inbox->push(delta, s.commits_);
  s.release_ids();
}

SceneSubscription Scene::subscribe() {
  SceneSubscription subscription;
  subscription.inbox_ = std::make_shared<SceneSubscription::Inbox>(commits_);
  std::erase_if(subscribers_.inboxes, [](const auto& inbox) { return inbox.expired(); });
  subscribers_.inboxes.push_back(subscription.inbox_);
  return subscription;
}

std::size_t Scene::memory_bytes() const {
  std::size_t bytes = nodes_.capacity() * sizeof(Node) + items_.capacity() * (sizeof(Item) + sizeof(item_states_[0])) +
                      parameters_.capacity() * sizeof(float) + names_.capacity() +
                      dirty_items_.capacity() * sizeof(ItemId) + free_.items.memory_bytes() +
                      free_.meshes.memory_bytes() + free_.materials.memory_bytes();
  for (const auto& list : free_.parameters) bytes += list.capacity() * sizeof(list[0]);
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const Mesh& m = mesh_table_[i];
    bytes +=
        sizeof(MeshEntry) + sizeof(Mesh) + (m.positions.capacity() + m.normals.capacity()) * sizeof(vec3) +
        (m.indices.capacity() + m.contour_sizes.capacity() + m.polygon_contours.capacity()) * sizeof(std::uint32_t);
  }
  for (const auto& [node, list] : attributes_)
    for (const auto& [key, value] : list) bytes += sizeof(Attributes::value_type) + key.size() + value.size();
  return bytes;
}

NodeId part_of(const Scene& scene, NodeId node) {
  for (; node.valid() && node != scene.root() && scene.parent(node) != scene.root(); node = scene.parent(node))
    if (!scene.name(node).empty()) return node;
  return {};
}

}  // namespace sightline::core
