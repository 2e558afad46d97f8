// Joining scenes: append(), and take_back(), which undoes it.
#include <algorithm>
#include <cassert>
#include <utility>

#include "sightline/core/scene.h"

namespace sightline::core {

// --- joining ---------------------------------------------------------------------------------------------------------

/// Whether this scene is nothing but a root, so that append() can take the arrays instead of copying them.
bool Scene::takes_over(NodeId parent, const Scene& other) const {
  const bool bare = parent == root_ && nodes_.size() == 1 && items_.empty() && parameters_.empty() && meshes_.empty() &&
                    materials_.empty() && names_.empty() && attributes_.empty() &&
                    stored_attributes_.stored() == nullptr && removed_items_.empty();
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
  free_ = std::move(other.free_);
  live_nodes_ = other.live_nodes_, live_items_ = other.live_items_;
  return added;
}

std::vector<NodeId> Scene::append(NodeId parent, Scene&& other) {
  assert(other.removed_items_.empty() && other.nodes_[0].first_item == kNone);
  other.forget_removed_materials();
  other.removed_materials_.clear();
  if (takes_over(parent, other)) return take_over(std::move(other));
  other.read_all_attributes();
  stored_snapshot_.reset();
  assert(names_.size() + other.names_.size() < kNone && "more than 4 GiB of names");
  const auto nodes = std::uint32_t(nodes_.size() - 1);  // the other root is left behind, so node i becomes nodes + i
  const auto items = std::uint32_t(items_.size()), values = std::uint32_t(parameters_.size());
  const auto meshes = std::uint32_t(meshes_.size()), materials = std::uint32_t(materials_.size());
  const auto names = std::uint32_t(names_.size());
  const auto shift = [](std::uint32_t& index, std::uint32_t by) {
    if (index != kNone) index += by;
  };

  std::vector<std::uint32_t> tops;
  for (std::uint32_t i = other.nodes_[0].first_child; i != kNone; i = other.nodes_[i].next) tops.push_back(nodes + i);
  // Allocates all memory first, so that running out of memory changes nothing.
  const auto make_room = [](auto& array, const auto& more) {
    const std::size_t size = array.size() + more.size();
    if (size > array.capacity()) array.reserve(std::max(size, 2 * array.capacity()));
  };
  make_room(nodes_, other.nodes_), make_room(items_, other.items_), make_room(parameters_, other.parameters_);
  make_room(item_states_, other.item_states_);
  make_room(meshes_, other.meshes_), make_room(materials_, other.materials_), make_room(names_, other.names_);
  mesh_table_.reserve(mesh_table_.size() + other.mesh_table_.size());
  make_room(removed_meshes_, other.removed_meshes_);
  make_room(free_nodes_, other.free_nodes_), make_room(dirty_nodes_, other.dirty_nodes_);
  make_room(dirty_items_, other.dirty_items_), make_room(dirty_materials_, other.materials_);
  attributes_.reserve(attributes_.size() + other.attributes_.size());
  std::vector<NodeId> added;
  added.reserve(tops.size());

  for (std::size_t i = 1; i < other.nodes_.size(); ++i) {
    Node node = other.nodes_[i];
    for (std::uint32_t* index : {&node.parent, &node.first_child, &node.last_child, &node.next, &node.previous})
      shift(*index, nodes);
    shift(node.first_item, items), shift(node.last_item, items);
    shift(node.material, materials);
    node.name_offset += names;
    nodes_.push_back(node);
  }
  for (Item item : other.items_) {
    shift(item.node, nodes);
    shift(item.next, items), shift(item.previous, items);
    shift(item.material, materials);
    item.payload += int(item.kind) < kPrimitiveKindCount ? values : meshes;
    items_.push_back(item);
  }
  for (const std::uint8_t state : other.item_states_) {
    assert((state & kCommitted) == 0);
    item_states_.push_back(state & kDirty);
  }
  parameters_.insert(parameters_.end(), other.parameters_.begin(), other.parameters_.end());
  const auto move_entry = [&](auto& own, auto& entry) {
    if (entry.generation != kNone) entry.generation = generation_;
    own.push_back(std::move(entry));
  };
  mesh_table_.append(other.mesh_table_);
  for (MeshEntry& entry : other.meshes_) move_entry(meshes_, entry);
  for (const std::uint32_t mesh : other.removed_meshes_) removed_meshes_.push_back(meshes + mesh);
  for (MaterialEntry& entry : other.materials_) {
    dirty_materials_.push_back(std::uint32_t(materials_.size()));
    move_entry(materials_, entry);
  }
  names_.insert(names_.end(), other.names_.begin(), other.names_.end());
  dead_name_bytes_ += other.dead_name_bytes_;
  while (!other.attributes_.empty()) {
    auto entry = other.attributes_.extract(other.attributes_.begin());
    entry.key() += nodes;
    attributes_.insert(std::move(entry));
  }
  for (const std::uint32_t node : other.free_nodes_) free_nodes_.push_back(nodes + node);
  for (const std::uint32_t node : other.dirty_nodes_)
    if (node != 0) dirty_nodes_.push_back(nodes + node);
  for (const ItemId item : other.dirty_items_) dirty_items_.push_back(items + item);
  live_nodes_ += other.live_nodes_ - 1;
  live_items_ += other.live_items_;
  for (const std::uint32_t top : tops) {
    link(top, parent.index);
    added.push_back(handle(top));
  }
  return added;
}

// --- taking back -----------------------------------------------------------------------------------------------------

void Scene::take_back(const Mark& mark, std::span<const NodeId> added) {
  for (const NodeId node : added) remove_node(node);
  assert(std::all_of(items_.begin() + std::ptrdiff_t(mark.items), items_.end(),
                     [](const Item& item) { return !item.alive; }));
  std::erase_if(dirty_items_, [&](ItemId item) { return item >= mark.items; });
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
