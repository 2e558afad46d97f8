// The retained scene graph: what the model is, never what one camera sees.
//
// A tree of nodes. Each node has a double-precision local transform, a name, attributes, layer bits, a material and a
// visible flag. Items (an analytic primitive or an instance of a shared mesh) hang on nodes. Edits are cheap and take
// effect at commit(), which validates them and reports which items they touched. Snapshots are built and updated from
// that.
//
// Node, mesh and material handles are generational: a handle to something removed never comes to mean something else.
// Using a stale handle breaks the contract: builds with assertions and builds with SIGHTLINE_CHECKED abort. contains()
// tells whether a handle is stale. Ids of items have no generation; see reuse_ids(). Not thread-safe; concurrent reads
// are fine.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "sightline/core/affine.h"
#include "sightline/core/api.h"
#include "sightline/core/detail/free_ids.h"
#include "sightline/core/error.h"
#include "sightline/core/large_array.h"
#include "sightline/core/mesh.h"
#include "sightline/core/mesh_table.h"
#include "sightline/core/primitive.h"
#include "sightline/core/scene_delta.h"

namespace sightline::core {

/// Generational handle; Tag tells node, mesh and material handles apart.
template <class Tag>
struct Handle {
  std::uint32_t index = kNone;
  std::uint32_t generation = 0;
  bool valid() const { return index != kNone; }
  friend bool operator==(const Handle&, const Handle&) = default;
};
using NodeId = Handle<struct NodeTag>;
using MeshId = Handle<struct MeshTag>;
using MaterialId = Handle<struct MaterialTag>;

struct Material {
  std::string name;
  vec3 colour{0.7f, 0.7f, 0.7f};  ///< sRGB, 0…1
  float alpha = 1.0f;             ///< 1 opaque, 0 invisible; drawn by screen-door dithering
  std::uint32_t code = 0;         ///< the source file's own number (RVM colour index), for writing back
};

class AttributeReader;
class Snapshot;

class SIGHTLINE_API Scene {
 public:
  Scene();

  // --- nodes -------------------------------------------------------------------------------------------------------
  NodeId root() const { return root_; }
  bool contains(NodeId node) const;
  /// Appends a child. `parent` must be alive.
  NodeId add_node(NodeId parent, std::string_view name = {}, const Affine& parent_from_node = {});
  /// Removes a node, its subtree and all their items. Not the root.
  void remove_node(NodeId node);
  /// Makes `node`, which must not be the root, the last child of `parent`. Keeps its local transform. Fails and changes
  /// nothing when `parent` lies in the subtree of `node`: a user may ask for that with a drag in a tree.
  Expected<void> reparent(NodeId node, NodeId parent);
  void set_transform(NodeId node, const Affine& parent_from_node);
  void set_visible(NodeId node, bool visible);          ///< hides or shows the whole subtree
  void set_layers(NodeId node, std::uint32_t layers);   ///< for the node's own items; 0 inherits the parent's
  void set_material(NodeId node, MaterialId material);  ///< for items of the subtree without one; invalid inherits
  void set_name(NodeId node, std::string_view name);
  void set_attribute(NodeId node, std::string_view key, std::string_view value);

  std::string_view name(NodeId node) const;  ///< valid until a name is set or a node removed
  const Affine& transform(NodeId node) const { return live(node).transform; }
  bool visible(NodeId node) const { return live(node).visible; }
  std::uint32_t layers(NodeId node) const { return live(node).layers; }             ///< as set: 0 means inherited
  MaterialId material(NodeId node) const;                                           ///< as set: invalid means inherited
  NodeId parent(NodeId node) const { return handle(live(node).parent); }            ///< invalid for the root
  NodeId first_child(NodeId node) const { return handle(live(node).first_child); }  ///< invalid when there is none
  NodeId next_sibling(NodeId node) const { return handle(live(node).next); }
  using Attributes = std::vector<std::pair<std::string, std::string>>;
  const Attributes& attributes(NodeId node) const;  ///< in the order set
  /// Product of the transforms from the root down to `node`.
  Affine world_from_node(NodeId node) const;
  /// "/"-joined names from below the root down to `node`; unnamed nodes show as "#k", k their position among siblings.
  std::string path(NodeId node) const;
  std::size_t node_count() const { return live_nodes_; }

  // --- shared resources --------------------------------------------------------------------------------------------
  // Items hold mesh and material indices. The index of a removed mesh or material is not given out again, except after
  // take_back() and by reuse_ids().

  /// Fails as validate() does, and on a position that is not finite, whose vertex the error names; adds nothing then.
  Expected<MeshId> add_mesh(Mesh mesh);
  MaterialId add_material(Material material);
  /// Changes the look of all items with this material. Published by the next commit(), like every edit.
  void update_material(MaterialId material, Material as);
  /// Nodes and items with this material have none from now on: they inherit one, or have the default one. The next
  /// commit() walks over all nodes and items once for all materials that were removed.
  void remove_material(MaterialId material);
  /// No item may use the mesh. Snapshots that still hold a removed item keep its mesh. The next commit() gives back the
  /// scene's share of its memory.
  void remove_mesh(MeshId mesh);
  bool contains(MeshId mesh) const;
  bool contains(MaterialId material) const;
  const Mesh& mesh(MeshId mesh) const;
  const AabbD& mesh_bounds(MeshId mesh) const;  ///< local
  const Material& material(MaterialId material) const;
  std::size_t mesh_slots() const { return meshes_.size(); }         ///< mesh indices lie below this
  std::size_t material_slots() const { return materials_.size(); }  ///< material indices lie below this
  /// `index` must be kNone or below mesh_slots() or material_slots(). Returns an invalid handle for kNone and for the
  /// index of something removed.
  MeshId mesh_at(std::size_t index) const;
  MaterialId material_at(std::size_t index) const;

  // --- items -------------------------------------------------------------------------------------------------------
  /// The placement's linear part is kept in float (relative precision 6e-8 of the item's own size), its origin in
  /// double.
  ItemId add_primitive(NodeId node, const Primitive& primitive, const Affine& node_from_item = {},
                       MaterialId material = {});
  ItemId add_mesh_instance(NodeId node, MeshId mesh, const Affine& node_from_item = {}, MaterialId material = {});
  void remove_item(ItemId item);
  void set_placement(ItemId item, const Affine& node_from_item);
  void set_visible(ItemId item, bool visible);
  void set_material(ItemId item, MaterialId material);
  /// Another mesh for an item of a mesh, or another facet group for one of those. The item keeps its id.
  void set_mesh(ItemId item, MeshId mesh);
  bool contains_item(ItemId item) const { return to_index(item) < items_.size() && items_[to_index(item)].alive; }

  Kind kind(ItemId item) const { return live(item).kind; }
  Primitive primitive(ItemId item) const;  ///< of an item of a primitive kind
  MeshId mesh_of(ItemId item) const;       ///< of a facet group or mesh
  Affine placement(ItemId item) const;     ///< node_from_item
  NodeId node_of(ItemId item) const;
  MaterialId item_material(ItemId item) const;  ///< as set: invalid means the node's
  bool item_visible(ItemId item) const { return live(item).visible; }
  ItemId first_item(NodeId node) const {
    return live(node).first_item;
  }  ///< kNoItem when the node has none; items come in insertion order
  ItemId next_item(ItemId item) const { return live(item).next; }
  std::size_t item_count() const { return live_items_; }
  std::size_t item_slots() const { return items_.size(); }  ///< item ids lie below this
  /// Bounds of the item's geometry under `world_from_item`, which may be any map. Empty for an empty mesh.
  AabbD bounds_under(ItemId item, const Affine& world_from_item) const;

  /// World bounds of the visible items of the subtree that lie on any of `layers`; empty when there are none. Walks
  /// over the vertices of meshes.
  AabbD bounds(NodeId node, std::uint32_t layers = kDefaultLayerMask) const;

  /// Whether commit() would accept the item with this world placement.
  bool can_commit(ItemId item, const Affine& world_from_item) const;

  // --- ids of what is gone -----------------------------------------------------------------------------------------
  /// Whether what is added from now on may get ids of items, and indices of meshes and materials, that were removed
  /// after this call. Off at first: then the id of a removed item means nothing for ever, and each item that ever was
  /// takes some 120 bytes. Programs that add and remove for days turn it on, and take as much memory as what they have
  /// at one time.
  ///
  /// An id comes back once its removal was committed and all subscribers have followed it (SceneSubscription::take; an
  /// engine once its commit() has done so). So what an engine says of an item, such as a pick, never is about another
  /// one. Who keeps ids must forget those that it removes: contains_item() may be true of them later. Handles of meshes
  /// and materials never come to mean something else. What is imported into this scene gets new ids all the same; what
  /// is imported into another one and then appended does not.
  void reuse_ids(bool reuse) { reuses_ids_ = reuse; }
  bool reuses_ids() const { return reuses_ids_; }

  // --- joining -----------------------------------------------------------------------------------------------------
  /// Moves everything below `other`'s root to below `parent`, after the children already there. The items get ids after
  /// those of this scene, in the order of their old ids, or with reuse_ids() first those that are free. Returns the
  /// children that `parent` gained. `other`'s ids become meaningless. `other` must never have been committed, and its
  /// root must hold no items.
  std::vector<NodeId> append(NodeId parent, Scene&& other);

  // --- taking back -------------------------------------------------------------------------------------------------
  /// Sizes of the scene's arrays at one moment, for take_back(). While it lives, all that is added gets ids after
  /// these. The scene must stay where it is.
  class Mark {
   public:
    explicit Mark(Scene& scene)
        : items(scene.items_.size()),
          parameters(scene.parameters_.size()),
          meshes(scene.meshes_.size()),
          materials(scene.materials_.size()),
          scene_(scene) {
      ++scene_.marks_;
    }
    Mark(const Mark&) = delete;
    Mark& operator=(const Mark&) = delete;
    ~Mark() { --scene_.marks_; }
    const std::size_t items, parameters, meshes, materials;

   private:
    Scene& scene_;
  };
  Mark mark() { return Mark(*this); }
  /// Removes everything added since the mark: the nodes `added` with their subtrees, and all meshes and materials.
  /// `added` must hold all items added since the mark. Nothing else may refer to the meshes and materials, and no
  /// commit may lie between. The ids are given out again.
  void take_back(const Mark& mark, std::span<const NodeId> added);

  // --- publishing --------------------------------------------------------------------------------------------------
  /// Validates every edit since the last commit and reports what the edits touched. All or nothing: when an item's
  /// parameters, world placement or world bounds are not finite or reach beyond 1e37 m, nothing is published, the edits
  /// stay pending, and the error names the node. Each subscription gets a copy of the returned delta.
  Expected<SceneDelta> commit();
  /// A subscription of one consumer to all commits from now on.
  SceneSubscription subscribe();

  /// Calls visit(node, world_from_node, visible, layers, material) for each node of the subtree, parents first, with
  /// inherited values resolved. Iterative: nesting depth is bounded by memory alone.
  template <class Visit>
  void for_each_node(NodeId top, Visit&& visit) const;

  /// An item with everything it inherits: what a snapshot needs to know of it.
  struct ItemState {
    Affine world_from_item;
    std::uint32_t layers;    ///< 0 when hidden
    std::uint32_t material;  ///< material index, kNone when none is set anywhere above
  };
  ItemState state(ItemId item) const;
  /// The item's state from the values that for_each_node() gave for its node. Cheaper for many items.
  ItemState state(ItemId item, const Affine& world_from_node, bool visible, std::uint32_t layers,
                  MaterialId material) const;

  /// Calls visit(item, state) for each item of `items` that is alive, in their order. Resolves every node above them
  /// once, so that many items below one deep chain of nodes cost no more than elsewhere.
  template <class Visit>
  void for_each_state(std::span<const ItemId> items, Visit&& visit) const;

  std::size_t memory_bytes() const;

 private:
  struct Node {
    Affine transform;
    std::uint32_t parent = kNone, first_child = kNone, last_child = kNone, next = kNone, previous = kNone;
    ItemId first_item = kNoItem, last_item = kNoItem;
    std::uint32_t layers = 0, material = kNone, generation = 0, name_offset = 0, name_length = 0;
    bool visible = true, alive = false, dirty = false;
  };
  struct Item {
    mat3 linear{1.0f};
    dvec3 origin{0.0};
    std::uint32_t node = kNone, payload = kNone, material = kNone;
    ItemId next = kNoItem, previous = kNoItem;
    Kind kind = Kind::kMesh;
    bool alive : 1 = false, visible : 1 = true;
  };
  /// Bits of item_states_. They are apart from the items, so that a commit of all items writes no item.
  static constexpr std::uint8_t kDirty = 1, kCommitted = 2;
  static constexpr std::uint8_t kFit = 4;  // commit() would accept it: known from the file that it was stored in
  /// What is known of a mesh, or a material, at its index. Generation kNone: removed.
  struct MeshEntry {
    AabbD bounds;
    std::uint32_t generation = 0;
  };
  struct MaterialEntry {
    Material material;
    std::uint32_t generation = 0;
  };
  /// What is free of a kind of thing, while ids are reused.
  struct Free {
    FreeIds<ItemId> items;
    FreeIds<std::uint32_t> meshes, materials;
    std::array<std::vector<std::uint32_t>, kPrimitiveKindCount> parameters;  // by kind: Item::payload
  };
  /// The inboxes of this scene's subscribers. They belong to the scene object: copying or moving its contents leaves
  /// them behind.
  struct Subscribers {
    std::vector<std::weak_ptr<SceneSubscription::Inbox>> inboxes;
    Subscribers() = default;
    Subscribers(const Subscribers&) {}
    Subscribers& operator=(const Subscribers&) { return *this; }
  };
  struct Resolved {
    Affine world;
    std::uint32_t layers, material;
    bool visible;
  };
  /// Nodes resolved so far. The values of node i are values[place[i]].
  struct ResolvedNodes {
    std::vector<std::uint32_t> place, path;
    std::vector<Resolved> values;
  };

  Node& live(NodeId node);
  const Node& live(NodeId node) const;
  Item& live(ItemId item);
  const Item& live(ItemId item) const;
  NodeId handle(std::uint32_t index) const;
  std::uint32_t index_of(MaterialId material) const;
  Resolved resolve(const Node& node, const Resolved& parent) const;
  Resolved resolve_above(NodeId node) const;
  const Resolved& resolve_once(std::uint32_t node, ResolvedNodes& known) const;
  void prefetch_ahead(std::span<const ItemId> items, std::size_t at) const;
  void link(std::uint32_t node, std::uint32_t parent);
  void unlink(std::uint32_t node);
  void touch_node(std::uint32_t node);
  void touch_item(ItemId item);
  void compact_names();
  void read_all_attributes();
  bool takes_over(NodeId parent, const Scene& other) const;
  std::vector<NodeId> take_over(Scene&& other);
  void erase_item(ItemId item);
  ItemId append_item(NodeId node, Item item);
  Expected<SceneDelta> validated(std::span<const ItemId> items) const;
  bool may_reuse() const { return reuses_ids_ && marks_ == 0; }
  void forget_removed_materials();
  void release_ids();
  std::uint32_t store(Kind kind, const float* values);
  class NewPlaces;
  void make_room_for(const Scene& other);
  void append_nodes(const Scene& other, const NewPlaces& nodes, const NewPlaces& items, const NewPlaces& materials);
  void append_shared(Scene& other, const NewPlaces& meshes, const NewPlaces& materials);
  void append_items(const Scene& other, const NewPlaces& nodes, const NewPlaces& items, const NewPlaces& meshes,
                    const NewPlaces& materials);

  friend class Access;
  friend class Snapshot;

  LargeArray<Node> nodes_;
  LargeArray<std::uint32_t> free_nodes_;
  LargeArray<Item> items_;
  LargeArray<std::uint8_t> item_states_;
  LargeArray<float> parameters_;  // of primitives, at Item::payload
  MeshTable mesh_table_;
  std::vector<MeshEntry> meshes_;              // of mesh_table_
  std::vector<std::uint32_t> removed_meshes_;  // since the last commit
  std::vector<MaterialEntry> materials_;
  std::vector<std::uint32_t> removed_materials_;  // since the last commit: nodes and items may still name them
  std::uint32_t generation_ = 0;                  // given to meshes and materials added from now on
  LargeArray<char> names_;
  std::size_t dead_name_bytes_ = 0;                           // bytes of names_ that no node uses any more
  std::unordered_map<std::uint32_t, Attributes> attributes_;  // hide those that are stored
  std::shared_ptr<AttributeReader> stored_attributes_;        // null: none are stored
  /// Makes a new snapshot what Snapshot(scene) would build. False: it cannot. Null: nothing is stored, or the scene was
  /// edited since.
  std::shared_ptr<const std::function<bool(Snapshot&)>> stored_snapshot_;
  std::vector<std::uint32_t> dirty_nodes_;
  std::vector<ItemId> dirty_items_, removed_items_;  // removed_items_: only those that a commit had published
  std::vector<std::uint32_t> dirty_materials_;
  Subscribers subscribers_;
  Free free_;
  bool reuses_ids_ = false;
  int marks_ = 0;
  std::uint64_t commits_ = 1;  // the number of the last one that published anything; above kAtOnce of FreeIds
  NodeId root_;
  std::size_t live_nodes_ = 0, live_items_ = 0;
};

/// Returns the part that people say a node belongs to: the nearest node at or above it that has a name. The root and
/// nodes directly below it, which stand for files, are none; invalid where there is no other. The part above a part,
/// its assembly, is part_of(scene, scene.parent(part)).
SIGHTLINE_API NodeId part_of(const Scene& scene, NodeId node);

// ---------------------------------------------------------------------------------------------------------------------

template <class Visit>
void Scene::for_each_node(NodeId top, Visit&& visit) const {
  // Each entry stands for a node and its later siblings, so the stack is as deep as the tree and no wider.
  std::vector<std::pair<std::uint32_t, Resolved>> stack{{top.index, resolve_above(top)}};
  while (!stack.empty()) {
    const std::uint32_t index = stack.back().first;
    const Node& node = nodes_[index];
    const Resolved here = resolve(node, stack.back().second);
    if (index != top.index && node.next != kNone) {
      stack.back().first = node.next;
    } else {
      stack.pop_back();
    }
    visit(handle(index), here.world, here.visible, here.layers, material_at(here.material));
    if (node.first_child != kNone) stack.emplace_back(node.first_child, here);
  }
}

template <class Visit>
void Scene::for_each_state(std::span<const ItemId> items, Visit&& visit) const {
  constexpr std::size_t kFew = 64;  // walking up from each is then cheaper than a table of all nodes
  ResolvedNodes known;
  for (std::size_t i = 0; i < items.size(); ++i) {
    prefetch_ahead(items, i);
    const ItemId item = items[i];
    if (!contains_item(item)) continue;
    if (items.size() <= kFew) {
      visit(item, state(item));
      continue;
    }
    const Resolved& node = resolve_once(live(item).node, known);
    visit(item, state(item, node.world, node.visible, node.layers, material_at(node.material)));
  }
}

}  // namespace sightline::core
