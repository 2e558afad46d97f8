// Joining scenes: append(), and take_back(), which undoes it.
#include <algorithm>
#include <cassert>
#include <optional>
#include <utility>

#include "sightline/core/scene.h"

namespace sightline::core {

// --- joining ---------------------------------------------------------------------------------------------------------

/// Whether this scene is nothing but a root, so that append() can take the arrays instead of copying them.
bool Scene::takes_over(NodeId parent, const Scene& other) const {
  const bool bare = parent == root_ && nodes_.size() == 1 && items_.empty() && parameters_.empty() && meshes_.empty() &&
                    materials_.empty() && names_.empty() && attributes_.empty() && stored_attributes_ == nullptr &&
                    removed_items_.empty();
  return bare && this != &other;
}

std::vector<NodeId> Scene::take_over(Scene&& other) {
  // What is known of the other's items holds below a root that places and shows them alike.
  const Node root = nodes_[0], left = other.nodes_[0];
  const bool alike = root.transform.linear == left.transform.linear && root.transform.origin == left.transform.origin &&
                     root.layers == left.layers && root.visible == left.visible && left.material == kNone;
  dirty_nodes_.reserve(dirty_nodes_.size() + other.dirty_nodes_.size());
  dirty_materials_.reserve(other.materials_.size());
  std::vector<NodeId> added;
  for (std::uint32_t i = left.first_child; i != kNone; i = other.nodes_[i].next) added.push_back(other.handle(i));

  nodes_ = std::move(other.nodes_);
  nodes_[0] = root;
  nodes_[0].first_child = left.first_child, nodes_[0].last_child = left.last_child;
  free_nodes_ = std::move(other.free_nodes_);
  items_ = std::move(other.items_), item_states_ = std::move(other.item_states_);
  parameters_ = std::move(other.parameters_), names_ = std::move(other.names_);
  mesh_table_ = std::move(other.mesh_table_), removed_meshes_ = std::move(other.removed_meshes_);
  meshes_ = std::move(other.meshes_), materials_ = std::move(other.materials_);
  for (MeshEntry& entry : meshes_)
    if (entry.generation != kNone) entry.generation = generation_;
  for (MaterialEntry& entry : materials_)
    if (entry.generation != kNone) entry.generation = generation_;
  dead_name_bytes_ = other.dead_name_bytes_;
  attributes_ = std::move(other.attributes_), stored_attributes_ = std::move(other.stored_attributes_);
  stored_snapshot_ = alike ? std::move(other.stored_snapshot_) : nullptr;
  if (!alike)
    for (std::uint8_t& state : item_states_) state &= std::uint8_t(~kFit);
  for (const std::uint32_t node : other.dirty_nodes_)
    if (node != 0) dirty_nodes_.push_back(node);
  dirty_items_ = std::move(other.dirty_items_);
  dirty_materials_.clear();
  for (std::uint32_t i = 0; i < materials_.size(); ++i) dirty_materials_.push_back(i);
  removed_materials_ = std::move(other.removed_materials_);
  free_ = std::move(other.free_);
  live_nodes_ = other.live_nodes_, live_items_ = other.live_items_;
  return added;
}

/// Where the things of another scene go: behind those that there are, but for the first, which may get places that are
/// free.
class Scene::NewPlaces {
 public:
  /// Those below `first` do not come along.
  explicit NewPlaces(std::size_t end, std::uint32_t first = 0) : end_(std::uint32_t(end)), first_(first) {}
  /// Takes places for up to `count` things, until `take` has none.
  template <class Take>
  void reuse(std::size_t count, const Take& take) {
    while (reused_.size() < count) {
      const auto place = take();
      if (!place) return;
      reused_.push_back(std::uint32_t(*place));
    }
  }
  std::uint32_t operator()(std::uint32_t index) const {
    if (index == kNone || index < first_) return kNone;
    const std::size_t i = index - first_;
    return i < reused_.size() ? reused_[i] : end_ + std::uint32_t(i - reused_.size());
  }
  ItemId operator()(ItemId item) const { return ItemId{(*this)(to_index(item))}; }

 private:
  std::uint32_t end_, first_;
  std::vector<std::uint32_t> reused_;
};

namespace {

std::optional<std::uint32_t> taken_from(LargeArray<std::uint32_t>& free) {
  if (free.empty()) return std::nullopt;
  const std::uint32_t last = free.back();
  free.pop_back();
  return last;
}

template <class Array, class Value>
void put(Array& array, std::uint32_t place, Value&& value) {
  if (place == array.size()) array.emplace_back();
  array[place] = std::forward<Value>(value);
}

}  // namespace

/// Allocates all memory that append() needs, so that running out of it changes nothing.
void Scene::make_room_for(const Scene& other) {
  const auto make_room = [](auto& array, const auto& more) {
    const std::size_t size = array.size() + more.size();
    if (size > array.capacity()) array.reserve(std::max(size, 2 * array.capacity()));
  };
  make_room(nodes_, other.nodes_), make_room(items_, other.items_), make_room(parameters_, other.parameters_);
  make_room(item_states_, other.item_states_);
  make_room(meshes_, other.meshes_), make_room(materials_, other.materials_), make_room(names_, other.names_);
  mesh_table_.reserve(mesh_table_.size() + other.mesh_table_.size());
  make_room(removed_meshes_, other.removed_meshes_), make_room(removed_materials_, other.removed_materials_);
  make_room(free_nodes_, other.free_nodes_), make_room(dirty_nodes_, other.dirty_nodes_);
  make_room(dirty_items_, other.items_), make_room(dirty_materials_, other.materials_);
  attributes_.reserve(attributes_.size() + other.attributes_.size());
}

/// The parameters of primitives come along, in places of their own.
void Scene::append_items(const Scene& other, const NewPlaces& nodes, const NewPlaces& items, const NewPlaces& meshes,
                         const NewPlaces& materials) {
  const bool one_by_one = may_reuse();
  const auto values = std::uint32_t(parameters_.size());
  if (!one_by_one) parameters_.insert(parameters_.end(), other.parameters_.begin(), other.parameters_.end());
  for (ItemId i{0}; to_index(i) < other.items_.size(); ++i) {
    const ItemId id = items(i);
    const std::uint32_t place = to_index(id);
    Item item = other.items_[to_index(i)];
    if (int(item.kind) >= kPrimitiveKindCount)
      item.payload = meshes(item.payload);
    else if (!one_by_one)
      item.payload += values;
    else if (item.alive)
      item.payload = store(item.kind, other.parameters_.data() + item.payload);
    item.node = nodes(item.node);
    item.next = items(item.next), item.previous = items(item.previous);
    item.material = materials(item.material);
    put(items_, place, item);
    if (place == item_states_.size()) item_states_.push_back(0);
    assert((other.item_states_[to_index(i)] & kCommitted) == 0);
    const std::uint8_t pending = item_states_[place] & kDirty;  // a free place may be in dirty_items_
    item_states_[place] = pending | (other.item_states_[to_index(i)] & kDirty);
    if (pending == 0 && item_states_[place] != 0) dirty_items_.push_back(id);
    if (!item.alive && reuses_ids_) free_.items.remove({&id, 1}, free_.items.kAtOnce);
  }
}

void Scene::append_nodes(const Scene& other, const NewPlaces& nodes, const NewPlaces& items,
                         const NewPlaces& materials) {
  const auto names = std::uint32_t(names_.size());
  for (std::uint32_t i = 1; i < other.nodes_.size(); ++i) {
    const std::uint32_t place = nodes(i);
    Node node = other.nodes_[i];
    for (std::uint32_t* index : {&node.parent, &node.first_child, &node.last_child, &node.next, &node.previous})
      *index = nodes(*index);
    node.first_item = items(node.first_item), node.last_item = items(node.last_item);
    node.material = materials(node.material);
    node.name_offset += names;
    if (place < nodes_.size()) node.generation = nodes_[place].generation;
    put(nodes_, place, node);
  }
}

void Scene::append_shared(Scene& other, const NewPlaces& meshes, const NewPlaces& materials) {
  for (std::uint32_t i = 0; i < other.meshes_.size(); ++i) {
    auto mesh = other.mesh_table_.list().share(i);
    if (meshes(i) == mesh_table_.size())
      mesh_table_.push_back(std::move(mesh));
    else
      mesh_table_.set(meshes(i), std::move(mesh));
    MeshEntry entry = other.meshes_[i];
    if (entry.generation != kNone) entry.generation = generation_;
    put(meshes_, meshes(i), entry);
  }
  for (std::uint32_t i = 0; i < other.materials_.size(); ++i) {
    MaterialEntry& entry = other.materials_[i];
    if (entry.generation != kNone) entry.generation = generation_;
    put(materials_, materials(i), std::move(entry));
    dirty_materials_.push_back(materials(i));
  }
  for (const std::uint32_t mesh : other.removed_meshes_) removed_meshes_.push_back(meshes(mesh));
  for (const std::uint32_t material : other.removed_materials_) removed_materials_.push_back(materials(material));
}

std::vector<NodeId> Scene::append(NodeId parent, Scene&& other) {
  assert(other.removed_items_.empty() && other.nodes_[0].first_item == kNoItem);
  other.forget_removed_materials();
  if (takes_over(parent, other)) return take_over(std::move(other));
  other.read_all_attributes();
  stored_snapshot_.reset();
  assert(names_.size() + other.names_.size() < kNone && "more than 4 GiB of names");
  std::vector<std::uint32_t> tops;
  for (std::uint32_t i = other.nodes_[0].first_child; i != kNone; i = other.nodes_[i].next) tops.push_back(i);
  std::vector<NodeId> added;
  added.reserve(tops.size());
  make_room_for(other);

  NewPlaces nodes(nodes_.size(), 1), items(items_.size());  // the other root is left behind
  NewPlaces meshes(meshes_.size()), materials(materials_.size());
  if (may_reuse()) {
    nodes.reuse(other.nodes_.size() - 1, [&] { return taken_from(free_nodes_); });
    items.reuse(other.items_.size(), [&] { return free_.items.take(); });
    meshes.reuse(other.meshes_.size(), [&] { return free_.meshes.take(); });
    materials.reuse(other.materials_.size(), [&] { return free_.materials.take(); });
  }
  append_nodes(other, nodes, items, materials);
  append_items(other, nodes, items, meshes, materials);
  append_shared(other, meshes, materials);
  names_.insert(names_.end(), other.names_.begin(), other.names_.end());
  dead_name_bytes_ += other.dead_name_bytes_;
  for (auto& [node, list] : other.attributes_)
    if (node != 0) attributes_.insert_or_assign(nodes(node), std::move(list));
  for (const std::uint32_t node : other.free_nodes_) free_nodes_.push_back(nodes(node));
  for (const std::uint32_t node : other.dirty_nodes_)
    if (node != 0) dirty_nodes_.push_back(nodes(node));
  live_nodes_ += other.live_nodes_ - 1;
  live_items_ += other.live_items_;
  for (const std::uint32_t top : tops) {
    link(nodes(top), parent.index);
    added.push_back(handle(nodes(top)));
  }
  return added;
}

// --- taking back -----------------------------------------------------------------------------------------------------

void Scene::take_back(const Mark& mark, std::span<const NodeId> added) {
  for (const NodeId node : added) remove_node(node);
  assert(std::all_of(items_.begin() + std::ptrdiff_t(mark.items), items_.end(),
                     [](const Item& item) { return !item.alive; }));
  std::erase_if(dirty_items_, [&](ItemId item) { return to_index(item) >= mark.items; });
  std::erase_if(dirty_materials_, [&](std::uint32_t material) { return material >= mark.materials; });
  std::erase_if(removed_materials_, [&](std::uint32_t material) { return material >= mark.materials; });
  free_.items.truncate(ItemId(mark.items));
  for (auto& list : free_.parameters) std::erase_if(list, [&](std::uint32_t i) { return i >= mark.parameters; });
  items_.resize(mark.items);
  item_states_.resize(mark.items);
  stored_snapshot_.reset();
  parameters_.resize(mark.parameters);
  std::erase_if(removed_meshes_, [&](std::uint32_t mesh) { return mesh >= mark.meshes; });
  mesh_table_.truncate(mark.meshes);
  meshes_.resize(mark.meshes);
  materials_.resize(mark.materials);
  ++generation_;
}

}  // namespace sightline::core
