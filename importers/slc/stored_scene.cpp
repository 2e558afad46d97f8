#include <algorithm>
#include <cmath>
#include <cstring>

#include "sightline/core/internal/hash.h"
#include "sightline/importers/slc/internal/storage.h"
#include "sightline/importers/slc/internal/storage_checks.h"

namespace sightline::importers::storage {

using core::AabbD;
using core::Access;
using core::Affine;
using core::AttributeReader;
using core::dvec3;
using core::Expected;
using core::fail;
using core::ItemId;
using core::Kind;
using core::kKindCount;
using core::kNoItem;
using core::kNone;
using core::kPrimitiveKindCount;
using core::MaterialId;
using core::NodeId;
using core::Scene;
using core::StoredAttributes;

namespace {

/// Numbers below this can be multiplied along any real tree without coming near what commit() refuses.
constexpr double kSurelyFit = 1e9;

bool small(const dvec3& v) {
  return glm::all(glm::lessThanEqual(glm::abs(v), dvec3(kSurelyFit)));
}
bool small(const Affine& a) {
  return small(a.linear[0]) && small(a.linear[1]) && small(a.linear[2]) && small(a.origin);
}

bool is_flag(const bool& flag) {
  unsigned char byte = 0;
  std::memcpy(&byte, &flag, 1);
  return byte <= 1;
}

/// Links are known to agree with each other. What is left are circles that the root does not reach.
bool is_one_tree(const Scene& scene) {
  const auto in = Access::of(scene);
  const auto& nodes = in.nodes();
  const auto rises = [&](std::size_t i) {
    const Access::Node& node = nodes[i];
    return !node.alive || i == 0 || (node.parent < i && node.next > i);  // kNone is above all
  };
  if (first_wrong(nodes.size(), rises) == nodes.size()) return true;
  std::size_t reached = 0;
  std::vector<std::uint32_t> open{0};
  while (!open.empty()) {
    const std::uint32_t at = open.back();
    open.pop_back();
    ++reached;
    for (std::uint32_t c = nodes[at].first_child; c != kNone; c = nodes[c].next) open.push_back(c);
  }
  return reached == nodes.size() - in.free_nodes().size();
}

/// Whether the links of a node that is alive lead to nodes and items that link back.
bool links_hold(const Scene& scene, std::uint32_t i) {
  const auto in = Access::of(scene);
  const auto& nodes = in.nodes();
  const auto alive = [&](std::uint32_t other) { return other < nodes.size() && nodes[other].alive; };
  const Access::Node& node = nodes[i];
  if (i == 0) {
    if (node.parent != kNone || node.previous != kNone || node.next != kNone || node.generation != 0 ||
        node.first_item != kNoItem)
      return false;
  } else {
    if (!alive(node.parent)) return false;
    const Access::Node& parent = nodes[node.parent];
    if (node.previous == kNone
            ? parent.first_child != i
            : !(alive(node.previous) && nodes[node.previous].next == i && nodes[node.previous].parent == node.parent))
      return false;
    if (node.next == kNone
            ? parent.last_child != i
            : !(alive(node.next) && nodes[node.next].previous == i && nodes[node.next].parent == node.parent))
      return false;
  }
  if ((node.first_child == kNone) != (node.last_child == kNone)) return false;
  if (node.first_child != kNone &&
      !(alive(node.first_child) && nodes[node.first_child].parent == i && nodes[node.first_child].previous == kNone))
    return false;
  if (node.last_child != kNone &&
      !(alive(node.last_child) && nodes[node.last_child].parent == i && nodes[node.last_child].next == kNone))
    return false;
  return true;
}

/// Whether what a node that is alive names exists: its items, material and name.
bool content_holds(const Scene& scene, std::uint32_t i) {
  const auto in = Access::of(scene);
  const Access::Node& node = in.nodes()[i];
  const auto holds_item = [&](ItemId item) {
    const std::uint32_t index = to_index(item);
    return index < in.items().size() && in.items()[index].alive && in.items()[index].node == i;
  };
  if ((node.first_item == kNoItem) != (node.last_item == kNoItem)) return false;
  if (node.first_item != kNoItem &&
      !(holds_item(node.first_item) && in.items()[to_index(node.first_item)].previous == kNoItem))
    return false;
  if (node.last_item != kNoItem &&
      !(holds_item(node.last_item) && in.items()[to_index(node.last_item)].next == kNoItem))
    return false;
  if (node.material != kNone &&
      (node.material >= in.materials().size() || in.materials()[node.material].generation == kNone))
    return false;
  return std::uint64_t(node.name_offset) + node.name_length <= in.names().size();
}

Expected<void> check_free_nodes(const Scene& scene) {
  const auto in = Access::of(scene);
  const auto& nodes = in.nodes();
  std::vector<bool> is_free(nodes.size());
  for (const std::uint32_t node : in.free_nodes()) {
    if (node >= nodes.size() || nodes[node].alive || is_free[node])
      return fail("its list of free nodes is inconsistent");
    is_free[node] = true;
  }
  const auto dead = std::count_if(nodes.begin(), nodes.end(), [](const Access::Node& n) { return !n.alive; });
  if (std::size_t(dead) != in.free_nodes().size()) return fail("its list of free nodes is inconsistent");
  return {};
}

Expected<void> check_nodes(const Scene& scene) {
  const auto in = Access::of(scene);
  const auto& nodes = in.nodes();
  const std::size_t count = nodes.size();
  if (count == 0 || count >= kNone || in.items().size() >= kNone || in.names().size() >= kNone)
    return fail("it has no nodes");
  // All flags come first: links are checked by the flags of others, and a byte that is no flag may not be read as one.
  const auto has_flags = [&](std::size_t i) {
    return is_flag(nodes[i].visible) && is_flag(nodes[i].alive) && is_flag(nodes[i].dirty) && !nodes[i].dirty;
  };
  if (const std::size_t wrong = first_wrong(count, has_flags); wrong < count) return inconsistent("node", wrong);
  const auto holds = [&](std::size_t i) {
    return !nodes[i].alive || (links_hold(scene, std::uint32_t(i)) && content_holds(scene, std::uint32_t(i)));
  };
  if (const std::size_t wrong = first_wrong(count, holds); wrong < count) return inconsistent("node", wrong);
  if (!nodes[0].alive) return inconsistent("node", 0);
  if (auto good = check_free_nodes(scene); !good) return good;
  if (!is_one_tree(scene)) return fail("its nodes are no tree");
  return {};
}

Expected<void> check_items(const Scene& scene) {
  const auto in = Access::of(scene);
  const auto& items = in.items();
  const auto holds = [&](std::size_t index) {
    const Access::Item& item = items[index];
    if (!item.alive) return true;
    if (item.node >= in.nodes().size() || !in.nodes()[item.node].alive) return false;
    const Access::Node& node = in.nodes()[item.node];
    // Items of a node come in rising order.
    if (item.previous == kNoItem ? to_index(node.first_item) != index
                                 : !(to_index(item.previous) < index && items[to_index(item.previous)].alive &&
                                     items[to_index(item.previous)].next == ItemId(index) &&
                                     items[to_index(item.previous)].node == item.node))
      return false;
    if (item.next == kNoItem
            ? to_index(node.last_item) != index
            : !(to_index(item.next) > index && to_index(item.next) < items.size() && items[to_index(item.next)].alive &&
                items[to_index(item.next)].previous == ItemId(index) && items[to_index(item.next)].node == item.node))
      return false;
    if (item.material != kNone &&
        (item.material >= in.materials().size() || in.materials()[item.material].generation == kNone))
      return false;
    if (std::uint8_t(item.kind) >= kKindCount) return false;
    if (int(item.kind) < kPrimitiveKindCount)
      return std::uint64_t(item.payload) + std::uint64_t(core::parameter_count(item.kind)) <= in.parameters().size();
    return item.payload < in.meshes().size() && in.meshes()[item.payload].generation != kNone &&
           in.mesh_table()[item.payload].is_facet_group() == (item.kind == Kind::kFacetGroup);
  };
  if (const std::size_t wrong = first_wrong(items.size(), holds); wrong < items.size())
    return inconsistent("item", wrong);
  return {};
}

/// Marks what commit() need not look at because all numbers are small. It looks at the others as ever.
void mark_fit(Scene& scene) {
  const auto in = Access::of(scene);
  std::vector<std::uint8_t> small_node(in.nodes().size());
  scene.for_each_node(scene.root(), [&](NodeId node, const Affine& world, bool, std::uint32_t, MaterialId) {
    small_node[node.index] = small(world);
  });
  std::vector<std::uint8_t> small_mesh(in.meshes().size());
  for (std::size_t i = 0; i < small_mesh.size(); ++i) {
    const AabbD& box = in.meshes()[i].bounds;
    small_mesh[i] = in.mesh_table()[i].positions.empty() || (small(box.min) && small(box.max));
  }
  const auto fit = [&](const Access::Item& item) {
    if (!small_node[item.node] || !small(dvec3(item.linear[0])) || !small(dvec3(item.linear[1])) ||
        !small(dvec3(item.linear[2])) || !small(item.origin))
      return false;
    if (int(item.kind) >= kPrimitiveKindCount) return small_mesh[item.payload] != 0;
    const float* const first = in.parameters().data() + item.payload;
    return std::all_of(first, first + core::parameter_count(item.kind),
                       [](float x) { return std::abs(x) <= kSurelyFit; });
  };
  const std::size_t count = in.items().size();
  in.item_states().resize(count);
  in.dirty_items().reserve(count);
  in.dirty_items().clear();
#pragma omp parallel for schedule(static) if (count > 65536)
  for (std::size_t i = 0; i < count; ++i) {
    const Access::Item& item = in.items()[i];
    if (item.alive) in.item_states()[i] = std::uint8_t(Access::kDirty | (fit(item) ? Access::kFit : 0));
  }
  for (std::size_t i = 0; i < count; ++i)
    if (in.item_states()[i] != 0) in.dirty_items().push_back(ItemId(i));
  in.live_items() = in.dirty_items().size();
  for (std::uint32_t i = 0; i < in.materials().size(); ++i) in.dirty_materials().push_back(i);
  std::sort(in.dirty_materials().begin(), in.dirty_materials().end());
}

}  // namespace

// --- layout ----------------------------------------------------------------------------------------------------------

std::uint64_t layout() {
  using Node = Access::Node;
  using Item = Access::Item;
  const std::uint64_t facts[] = {sizeof(Node),
                                 sizeof(Item),
                                 sizeof(core::Placement),
                                 sizeof(Kind),
                                 std::uint64_t(kKindCount),
                                 std::uint64_t(kPrimitiveKindCount),
                                 core::kBlockSlots,
                                 core::ItemBounds::kPadding,
                                 offsetof(Node, transform),
                                 offsetof(Node, parent),
                                 offsetof(Node, first_item),
                                 offsetof(Node, layers),
                                 offsetof(Node, name_length),
                                 offsetof(Node, visible),
                                 offsetof(Node, alive),
                                 offsetof(Item, linear),
                                 offsetof(Item, origin),
                                 offsetof(Item, node),
                                 offsetof(Item, payload),
                                 offsetof(Item, previous),
                                 offsetof(Item, kind)};
  std::uint64_t hash = 0;
  for (const std::uint64_t fact : facts) hash = core::mixed(hash ^ fact);
  for (int kind = 0; kind < kPrimitiveKindCount; ++kind)
    hash = core::mixed(hash ^ std::uint64_t(core::parameter_count(Kind(kind))));
  return hash;
}

void copy_clean(const Access::Node* values, std::size_t count, std::byte* to) {
  using Node = Access::Node;
  std::memset(to, 0, count * sizeof(Node));
  for (std::size_t i = 0; i < count; ++i) {
    const Node& from = values[i];
    Node& node = reinterpret_cast<Node*>(to)[i];
    node.transform = from.transform;
    node.parent = from.parent, node.first_child = from.first_child, node.last_child = from.last_child;
    node.next = from.next, node.previous = from.previous;
    node.first_item = from.first_item, node.last_item = from.last_item;
    node.layers = from.layers, node.material = from.material, node.generation = from.generation;
    node.name_offset = from.name_offset, node.name_length = from.name_length;
    node.visible = from.visible, node.alive = from.alive;
  }
}

void copy_clean(const Access::Item* values, std::size_t count, std::byte* to) {
  using Item = Access::Item;
  std::memset(to, 0, count * sizeof(Item));
  for (std::size_t i = 0; i < count; ++i) {
    const Item& from = values[i];
    Item& item = reinterpret_cast<Item*>(to)[i];
    item.linear = from.linear, item.origin = from.origin;
    item.node = from.node, item.payload = from.payload, item.material = from.material;
    item.next = from.next, item.previous = from.previous;
    item.kind = from.kind;
    item.alive = from.alive, item.visible = from.visible;
  }
}

// --- scenes ----------------------------------------------------------------------------------------------------------

void add_removed_mesh(Scene& scene) {
  const auto in = Access::of(scene);
  in.mesh_table().push_back(nullptr);
  in.meshes().push_back({{}, kNone});
}

void add_removed_material(Scene& scene) {
  const auto in = Access::of(scene);
  in.materials().push_back({{}, kNone});
}

StoredAttributes attributes(const Scene& scene) {
  const auto in = Access::of(scene);
  std::vector<std::uint32_t> nodes;
  for (const auto& [node, list] : in.attributes()) nodes.push_back(node);
  if (in.stored_attributes())
    for (const std::uint32_t node : in.stored_attributes()->stored().nodes)
      if (!in.attributes().contains(node)) nodes.push_back(node);
  std::sort(nodes.begin(), nodes.end());
  StoredAttributes all;
  for (const std::uint32_t node : nodes)
    if (in.nodes()[node].alive)
      if (const auto& list = scene.attributes(in.handle(node)); !list.empty()) all.add(node, list);
  return all;
}

Expected<void> finish(Scene& scene, std::shared_ptr<const StoredAttributes> attributes) {
  const auto in = Access::of(scene);
  if (auto good = check_nodes(scene); !good) return good;
  if (auto good = check_items(scene); !good) return good;
  const auto& stored = attributes->nodes;
  if (attributes->ends.size() != stored.size()) return fail("its attributes are inconsistent");
  for (std::size_t i = 0; i < stored.size(); ++i)
    if (stored[i] >= in.nodes().size() || !in.nodes()[stored[i]].alive || (i > 0 && stored[i] <= stored[i - 1]))
      return inconsistent("attributes of node", i);
  in.stored_attributes() = std::make_shared<AttributeReader>(std::move(attributes));
  in.live_nodes() = in.nodes().size() - in.free_nodes().size();
  mark_fit(scene);
  return {};
}

std::vector<ItemId> not_surely_fit(const Scene& scene) {
  const auto in = Access::of(scene);
  std::vector<ItemId> found;
  for (const ItemId item : in.dirty_items())
    if ((in.item_states()[to_index(item)] & Access::kFit) == 0) found.push_back(item);
  return found;
}

void set_snapshot(Scene& scene, std::function<bool(core::Snapshot&)> source) {
  Access::of(scene).stored_snapshot() = std::make_shared<const std::function<bool(core::Snapshot&)>>(std::move(source));
}

}  // namespace sightline::importers::storage
