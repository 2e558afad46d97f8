#include "sightline/core/internal/storage.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "sightline/core/internal/hash.h"

namespace sightline::core {
namespace {

/// Numbers below this can be multiplied along any real tree without coming near what commit() refuses.
constexpr double kSurelyFit = 1e9;

bool small(const dvec3& v) {
  return glm::all(glm::lessThanEqual(glm::abs(v), dvec3(kSurelyFit)));
}
bool small(const Affine& a) {
  return small(a.linear[0]) && small(a.linear[1]) && small(a.linear[2]) && small(a.origin);
}

tl::unexpected<Error> inconsistent(const char* what, std::size_t index) {
  return fail(std::string("its ") + what + " " + std::to_string(index) + " is inconsistent");
}

/// The first index below `count` that does not hold, or `count`. Uses all threads.
template <class Holds>
std::size_t first_wrong(std::size_t count, const Holds& holds) {
  std::size_t wrong = count;
#ifdef _OPENMP
#pragma omp parallel for schedule(static) reduction(min : wrong) if (count > 65536)
#endif
  for (std::size_t i = 0; i < count; ++i)
    if (!holds(i)) wrong = std::min(wrong, i);
  return wrong;
}

bool is_flag(const bool& flag) {
  unsigned char byte = 0;
  std::memcpy(&byte, &flag, 1);
  return byte <= 1;
}

bool is_number(float x) {
  return std::isfinite(x);
}

}  // namespace

// --- layout ----------------------------------------------------------------------------------------------------------

std::uint64_t Storage::layout() {
  using Node = Scene::Node;
  using Item = Scene::Item;
  const std::uint64_t facts[] = {sizeof(Node),
                                 sizeof(Item),
                                 sizeof(Placement),
                                 sizeof(Kind),
                                 std::uint64_t(kKindCount),
                                 std::uint64_t(kPrimitiveKindCount),
                                 kBlockSlots,
                                 ItemBounds::kPadding,
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
  for (const std::uint64_t fact : facts) hash = mixed(hash ^ fact);
  for (int kind = 0; kind < kPrimitiveKindCount; ++kind)
    hash = mixed(hash ^ std::uint64_t(parameter_count(Kind(kind))));
  return hash;
}

void Storage::copy_clean(const Scene::Node* values, std::size_t count, std::byte* to) {
  using Node = Scene::Node;
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

void Storage::copy_clean(const Scene::Item* values, std::size_t count, std::byte* to) {
  using Item = Scene::Item;
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

void Storage::add_removed_mesh(Scene& scene) {
  scene.mesh_table_.push_back(nullptr);
  scene.meshes_.push_back({{}, kNone});
}
void Storage::add_removed_material(Scene& scene) {
  scene.materials_.push_back({{}, kNone});
}

StoredAttributes Storage::attributes(const Scene& scene) {
  std::vector<std::uint32_t> nodes;
  for (const auto& [node, list] : scene.attributes_) nodes.push_back(node);
  if (const StoredAttributes* stored = scene.stored_attributes_.stored())
    for (const std::uint32_t node : stored->nodes)
      if (!scene.attributes_.contains(node)) nodes.push_back(node);
  std::sort(nodes.begin(), nodes.end());
  StoredAttributes all;
  for (const std::uint32_t node : nodes)
    if (scene.nodes_[node].alive)
      if (const auto& list = scene.attributes(scene.handle(node)); !list.empty()) all.add(node, list);
  return all;
}

Expected<void> Storage::finish(Scene& scene, std::shared_ptr<const StoredAttributes> attributes) {
  if (auto good = check_nodes(scene); !good) return good;
  if (auto good = check_items(scene); !good) return good;
  const auto& stored = attributes->nodes;
  if (attributes->ends.size() != stored.size()) return fail("its attributes are inconsistent");
  for (std::size_t i = 0; i < stored.size(); ++i)
    if (stored[i] >= scene.nodes_.size() || !scene.nodes_[stored[i]].alive || (i > 0 && stored[i] <= stored[i - 1]))
      return inconsistent("attributes of node", i);
  scene.stored_attributes_ = AttributeReader(std::move(attributes));
  scene.live_nodes_ = scene.nodes_.size() - scene.free_nodes_.size();
  mark_fit(scene);
  return {};
}

Expected<void> Storage::check_nodes(const Scene& scene) {
  const auto& nodes = scene.nodes_;
  const std::size_t count = nodes.size(), items = scene.items_.size();
  if (count == 0 || count >= kNone || items >= kNone || scene.names_.size() >= kNone) return fail("it has no nodes");
  const auto alive = [&](std::uint32_t i) { return i < count && nodes[i].alive; };
  const auto holds_item = [&](std::uint32_t i, std::uint32_t node) {
    return i < items && scene.items_[i].alive && scene.items_[i].node == node;
  };
  // Of all nodes first: links are checked by the flags of others, and a byte that is no flag may not be read as one.
  const auto has_flags = [&](std::size_t i) {
    return is_flag(nodes[i].visible) && is_flag(nodes[i].alive) && is_flag(nodes[i].dirty) && !nodes[i].dirty;
  };
  if (const std::size_t wrong = first_wrong(count, has_flags); wrong < count) return inconsistent("node", wrong);
  const auto holds = [&](std::size_t index) {
    const Scene::Node& node = nodes[index];
    const auto i = std::uint32_t(index);
    if (!node.alive) return true;
    if (index == 0) {
      if (node.parent != kNone || node.previous != kNone || node.next != kNone || node.generation != 0 ||
          node.first_item != kNone)
        return false;
    } else {
      if (!alive(node.parent)) return false;
      const Scene::Node& parent = nodes[node.parent];
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
    if ((node.first_item == kNone) != (node.last_item == kNone)) return false;
    if (node.first_item != kNone &&
        !(holds_item(node.first_item, i) && scene.items_[node.first_item].previous == kNone))
      return false;
    if (node.last_item != kNone && !(holds_item(node.last_item, i) && scene.items_[node.last_item].next == kNone))
      return false;
    if (node.material != kNone &&
        (node.material >= scene.materials_.size() || scene.materials_[node.material].generation == kNone))
      return false;
    return std::uint64_t(node.name_offset) + node.name_length <= scene.names_.size();
  };
  if (const std::size_t wrong = first_wrong(count, holds); wrong < count) return inconsistent("node", wrong);
  if (!nodes[0].alive) return inconsistent("node", 0);

  std::vector<bool> is_free(count);
  for (const std::uint32_t node : scene.free_nodes_) {
    if (node >= count || nodes[node].alive || is_free[node]) return fail("its list of free nodes is inconsistent");
    is_free[node] = true;
  }
  const auto dead = std::count_if(nodes.begin(), nodes.end(), [](const Scene::Node& n) { return !n.alive; });
  if (std::size_t(dead) != scene.free_nodes_.size()) return fail("its list of free nodes is inconsistent");
  if (!is_one_tree(scene)) return fail("its nodes are no tree");
  return {};
}

/// Links are known to agree with each other. What is left are circles that the root does not reach.
bool Storage::is_one_tree(const Scene& scene) {
  const auto& nodes = scene.nodes_;
  const auto rises = [&](std::size_t i) {
    const Scene::Node& node = nodes[i];
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
  return reached == nodes.size() - scene.free_nodes_.size();
}

Expected<void> Storage::check_items(const Scene& scene) {
  const auto& items = scene.items_;
  const auto holds = [&](std::size_t index) {
    const Scene::Item& item = items[index];
    if (!item.alive) return true;
    if (item.node >= scene.nodes_.size() || !scene.nodes_[item.node].alive) return false;
    const Scene::Node& node = scene.nodes_[item.node];
    // Items of a node come in rising order.
    if (item.previous == kNone ? node.first_item != index
                               : !(item.previous < index && items[item.previous].alive &&
                                   items[item.previous].next == index && items[item.previous].node == item.node))
      return false;
    if (item.next == kNone ? node.last_item != index
                           : !(item.next > index && item.next < items.size() && items[item.next].alive &&
                               items[item.next].previous == index && items[item.next].node == item.node))
      return false;
    if (item.material != kNone &&
        (item.material >= scene.materials_.size() || scene.materials_[item.material].generation == kNone))
      return false;
    if (std::uint8_t(item.kind) >= kKindCount) return false;
    if (int(item.kind) < kPrimitiveKindCount)
      return std::uint64_t(item.payload) + std::uint64_t(parameter_count(item.kind)) <= scene.parameters_.size();
    return item.payload < scene.meshes_.size() && scene.meshes_[item.payload].generation != kNone &&
           scene.mesh_table_[item.payload].is_facet_group() == (item.kind == Kind::kFacetGroup);
  };
  if (const std::size_t wrong = first_wrong(items.size(), holds); wrong < items.size())
    return inconsistent("item", wrong);
  return {};
}

/// Marks what commit() need not look at because all numbers are small. It looks at the others as ever.
void Storage::mark_fit(Scene& scene) {
  std::vector<std::uint8_t> small_node(scene.nodes_.size());
  scene.for_each_node(scene.root(), [&](NodeId node, const Affine& world, bool, std::uint32_t, MaterialId) {
    small_node[node.index] = small(world);
  });
  std::vector<std::uint8_t> small_mesh(scene.meshes_.size());
  for (std::size_t i = 0; i < small_mesh.size(); ++i) {
    const AabbD& box = scene.meshes_[i].bounds;
    small_mesh[i] = scene.mesh_table_[i].positions.empty() || (small(box.min) && small(box.max));
  }
  const auto fit = [&](const Scene::Item& item) {
    if (!small_node[item.node] || !small(dvec3(item.linear[0])) || !small(dvec3(item.linear[1])) ||
        !small(dvec3(item.linear[2])) || !small(item.origin))
      return false;
    if (int(item.kind) >= kPrimitiveKindCount) return small_mesh[item.payload] != 0;
    const float* const first = scene.parameters_.data() + item.payload;
    return std::all_of(first, first + parameter_count(item.kind), [](float x) { return std::abs(x) <= kSurelyFit; });
  };
  const std::size_t count = scene.items_.size();
  scene.item_states_.resize(count);
  scene.dirty_items_.reserve(count);
  scene.dirty_items_.clear();
#ifdef _OPENMP
#pragma omp parallel for schedule(static) if (count > 65536)
#endif
  for (std::size_t i = 0; i < count; ++i) {
    const Scene::Item& item = scene.items_[i];
    if (item.alive) scene.item_states_[i] = std::uint8_t(Scene::kDirty | (fit(item) ? Scene::kFit : 0));
  }
  for (std::size_t i = 0; i < count; ++i)
    if (scene.item_states_[i] != 0) scene.dirty_items_.push_back(ItemId(i));
  scene.live_items_ = scene.dirty_items_.size();
  for (std::uint32_t i = 0; i < scene.materials_.size(); ++i) scene.dirty_materials_.push_back(i);
  std::sort(scene.dirty_materials_.begin(), scene.dirty_materials_.end());
}

std::vector<ItemId> Storage::not_surely_fit(const Scene& scene) {
  std::vector<ItemId> found;
  for (const ItemId item : scene.dirty_items_)
    if ((scene.item_states_[item] & Scene::kFit) == 0) found.push_back(item);
  return found;
}

// --- snapshots -------------------------------------------------------------------------------------------------------

Storage::SnapshotState Storage::state(const Snapshot& snapshot) {
  return {snapshot.bounds_.origin, snapshot.bounds_.extent_, snapshot.chunks_.size(), snapshot.chunks_.origins()};
}

void Storage::set_state(Snapshot& snapshot, SnapshotState state, std::shared_ptr<const StoredJoints> joints) {
  snapshot.stored_joints_ = std::move(joints);
  snapshot.bounds_.origin = state.origin;
  snapshot.bounds_.extent_ = state.extent;
  snapshot.bounds_.size_ = snapshot.kinds_.size();
  snapshot.bounds_.uses_layers_ = !snapshot.bounds_.layers_.empty();
  snapshot.ordered_size_ = snapshot.kinds_.size();
  snapshot.chunks_ = ChunkGrid::restored(state.chunk_size, std::move(state.chunk_origins));
}

void Storage::set_snapshot(Scene& scene, std::function<bool(Snapshot&)> source) {
  scene.stored_snapshot_ = std::make_shared<const std::function<bool(Snapshot&)>>(std::move(source));
}

Expected<void> Storage::try_snapshot(const Scene& scene, const std::function<bool(Snapshot&)>& fill) {
  Snapshot snapshot;
  snapshot.scene_ = &scene;
  snapshot.meshes_ = scene.mesh_table_.list();
  if (!fill(snapshot)) return fail("the arrays of its snapshot have elements of another size");
  return check(scene, snapshot);
}

/// Whether nothing in them leads outside of arrays.
bool Storage::are_safe(const StoredJoints& joints, std::size_t item_slots) {
  const auto& first = joints.first;
  return joints.bits.size() <= item_slots / 32 + 1 && first.size() <= item_slots / 32 + 2 &&
         (first.empty() ? joints.covers.empty() : first.back() == joints.covers.size()) &&
         std::is_sorted(first.begin(), first.end());
}

Expected<void> Storage::check(const Scene& scene, const Snapshot& snapshot) {
  const std::size_t n = snapshot.kinds_.size(), words = n / 64 + 1;
  const ItemBounds& bounds = snapshot.bounds_;
  bool sizes =
      snapshot.index_in_kind_.size() == n && snapshot.items_.size() == n && snapshot.materials_.size() == n &&
      snapshot.slots_.size() == scene.item_slots() && n == scene.item_count() &&
      (bounds.layers_.empty() || bounds.layers_.size() == n) &&
      snapshot.block_sizes_.size() == (n + kBlockSlots - 1) / kBlockSlots && snapshot.ranks_.size() == n / 64 + 1 &&
      (snapshot.vacant_.empty() ? snapshot.vacant_before_.empty()
                                : snapshot.vacant_.size() == words && snapshot.vacant_before_.size() == words + 1);
  for (const auto& c : bounds.coordinates_) sizes &= c.size() == n + ItemBounds::kPadding || (n == 0 && c.empty());
  std::size_t members = 0;
  for (std::size_t k = 0; k < snapshot.kind_items_.size(); ++k) {
    const KindItems& kind = snapshot.kind_items_[k];
    const bool primitive = int(k) < kPrimitiveKindCount;
    const std::size_t values = primitive ? std::size_t(parameter_count(Kind(k))) : 0;
    sizes &= kind.placements.size() == kind.members.size() && kind.parameters.size() == kind.members.size() * values &&
             kind.meshes.size() == (primitive ? 0 : kind.members.size());
    members += kind.members.size();
  }
  if (!sizes || members != n) return fail("the arrays of its snapshot have different sizes");

  if (snapshot.stored_joints_ && !are_safe(*snapshot.stored_joints_, scene.item_slots()))
    return fail("the joints of its snapshot are inconsistent");

  // Slots are far from the order of items: a byte for each item takes less of the cache than the items.
  constexpr std::uint8_t kNoItem = 255;
  std::vector<std::uint8_t> kinds(scene.items_.size());
  for (std::size_t i = 0; i < kinds.size(); ++i)
    kinds[i] = scene.items_[i].alive ? std::uint8_t(scene.items_[i].kind) : kNoItem;

  const std::size_t chunks = snapshot.chunks_.origins().size();
  for (const dvec3& origin : snapshot.chunks_.origins())
    if (!is_finite(origin)) return fail("the chunks of its snapshot are not finite");
  if (!is_finite(bounds.origin) || !(snapshot.chunks_.size() >= 0.0))
    return fail("the origin of its snapshot is not finite");

  const bool any_vacant = !snapshot.vacant_.empty();
  const auto holds = [&](std::size_t s) {
    const Kind kind = snapshot.kinds_[s];
    if (std::uint8_t(kind) >= kKindCount) return false;
    const KindItems& list = snapshot.kind_items_[std::size_t(kind)];
    const std::size_t i = snapshot.index_in_kind_[s];
    const ItemId item = snapshot.items_[s];
    if (i >= list.members.size() || list.members[i] != s || item >= snapshot.slots_.size() ||
        snapshot.slots_[item] != s || kinds[item] != std::uint8_t(kind))
      return false;
    if (list.placements[i].chunk >= chunks) return false;
    if (int(kind) >= kPrimitiveKindCount && list.meshes[i] != scene.items_[item].payload) return false;
    const std::uint32_t material = snapshot.materials_[s];
    if (material != kNone && material >= scene.material_slots()) return false;
    for (int axis = 0; axis < 6; ++axis)
      if (!is_number(bounds.coordinates_[axis][s])) return false;
    const bool vacant = any_vacant && (snapshot.vacant_[s / 64] >> s % 64 & 1) != 0;
    if (vacant != bounds.vacant(s) || (!bounds.layers_.empty() && bounds.layers_[s] == 0)) return false;
    if (vacant) return true;
    const Aabb box = bounds.box(s);
    return !box.empty() && glm::all(glm::lessThanEqual(bounds.extent_.min, box.min)) &&
           glm::all(glm::lessThanEqual(box.max, bounds.extent_.max));
  };
  if (const std::size_t wrong = first_wrong(n, holds); wrong < n) return inconsistent("slot", wrong);
  for (const auto& c : bounds.coordinates_)
    for (std::size_t i = n; i < c.size(); ++i)
      if (std::abs(c[i]) != Aabb::kFar) return fail("the padding of its bounds is inconsistent");
  const auto item_holds = [&](std::size_t item) {
    return kinds[item] != kNoItem ? snapshot.slots_[item] < n : snapshot.slots_[item] == kNone;
  };
  if (const std::size_t wrong = first_wrong(scene.item_slots(), item_holds); wrong < scene.item_slots())
    return inconsistent("slot of item", wrong);

  std::array<std::uint32_t, kKindCount> rank{};
  std::uint32_t vacant = 0;
  for (std::size_t word = 0; word < words; ++word) {
    if (snapshot.ranks_[word] != rank) return inconsistent("rank", word);
    if (any_vacant) {
      std::uint64_t bits = snapshot.vacant_[word];
      if (word + 1 == words && bits >> n % 64 != 0) return inconsistent("word of vacant slots", word);
      if (snapshot.vacant_before_[word] != vacant) return inconsistent("count of vacant slots", word);
      for (; bits != 0; bits &= bits - 1) ++vacant;
    }
    for (std::size_t s = word * 64; s < std::min(n, (word + 1) * 64); ++s) ++rank[std::size_t(snapshot.kinds_[s])];
  }
  if (any_vacant && snapshot.vacant_before_[words] != vacant) return inconsistent("count of vacant slots", words);
  // Within a kind, members rise with the slots: rank() counts on it.
  for (const KindItems& kind : snapshot.kind_items_) {
    const auto& slots = kind.members;
    if (first_wrong(slots.size(), [&](std::size_t i) { return i == 0 || slots[i - 1] < slots[i]; }) < slots.size())
      return fail("the slots of a kind in its snapshot do not rise");
    const auto finite = [&](std::size_t i) {
      const Placement& p = kind.placements[i];
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r)
          if (!is_number(p.linear[c][r])) return false;
      return is_number(p.origin.x) && is_number(p.origin.y) && is_number(p.origin.z);
    };
    if (first_wrong(kind.placements.size(), finite) < kind.placements.size())
      return fail("a placement in its snapshot is not finite");
  }
  return {};
}

}  // namespace sightline::core
