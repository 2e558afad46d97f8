// Random edits of a scene against a twin that recomputes everything whenever it is asked.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/tests/core/primitive_samples.h"
#include "sightline/tests/core/scene_samples.h"

namespace sightline::core::scene_twin_test {
namespace {

using tests::children_of;
using tests::Ids;
using tests::items_of;
using tests::kPipe;
using tests::Random;
using tests::triangle;
using tests::uniform;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// A scene kept in the most obvious way: everything is recomputed whenever it is asked.
struct Twin {
  struct Node {
    NodeId handle;
    int parent = -1;
    bool alive = true, visible = true;
    std::uint32_t layers = 0;
    MaterialId material;
    Affine transform;
    std::string name;
    std::vector<int> children;
    Ids items;
  };
  struct Item {
    int node = 0;
    bool alive = true, visible = true, committed = false, touched = true;
    MaterialId material;
    Affine placement;
  };
  std::vector<Node> nodes;
  std::vector<Item> items;
  Ids removed;
  std::set<std::uint32_t> materials;  // touched

  bool within(int node, int top) const {
    for (; node >= 0; node = nodes[std::size_t(node)].parent)
      if (node == top) return true;
    return false;
  }
  void touch_below(int top) {
    for (Item& item : items)
      if (item.alive && within(item.node, top)) item.touched = true;
  }
  void remove(ItemId id) {
    Item& item = items[to_index(id)];
    item.alive = false;
    if (item.committed) removed.push_back(id);
    std::erase(nodes[std::size_t(item.node)].items, id);
  }
  Affine world(int node) const {
    const Node& n = nodes[std::size_t(node)];
    return n.parent < 0 ? n.transform : world(n.parent) * n.transform;
  }
  std::uint32_t layers(int node) const {
    const Node& n = nodes[std::size_t(node)];
    return n.layers != 0 ? n.layers : n.parent < 0 ? kLayerModel : layers(n.parent);
  }
  MaterialId material(int node) const {
    const Node& n = nodes[std::size_t(node)];
    return n.material.valid() || n.parent < 0 ? n.material : material(n.parent);
  }
  bool visible(int node) const {
    const Node& n = nodes[std::size_t(node)];
    return n.visible && (n.parent < 0 || visible(n.parent));
  }
  std::string path(int node) const {
    const Node& n = nodes[std::size_t(node)];
    if (n.parent < 0) return "";
    const auto& siblings = nodes[std::size_t(n.parent)].children;
    const auto place = std::find(siblings.begin(), siblings.end(), node) - siblings.begin();
    const std::string above = path(n.parent);
    return (above.empty() ? "" : above + "/") + (n.name.empty() ? "#" + std::to_string(place) : n.name);
  }
  bool bad(const Item& item) const {
    const Affine world_from_item = world(item.node) * item.placement;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r)
        if (!(std::abs(world_from_item.linear[c][r]) < 1e36)) return true;
    return !(glm::length(world_from_item.origin) < 1e36);
  }
  /// What a commit has to report, nothing when it has to fail; then `worst` names the node.
  bool commit(SceneDelta& delta, std::string& worst) {
    for (ItemId id{0}; to_index(id) < items.size(); ++id)
      if (items[to_index(id)].alive && bad(items[to_index(id)])) {
        worst = path(items[to_index(id)].node);
        return false;
      }
    for (ItemId id{0}; to_index(id) < items.size(); ++id) {
      Item& item = items[to_index(id)];
      if (item.alive && item.touched) (item.committed ? delta.changed : delta.inserted).push_back(id);
      item.touched = false;
      item.committed = true;
    }
    std::sort(removed.begin(), removed.end());
    delta.removed = std::move(removed);
    removed.clear();
    delta.materials.assign(materials.begin(), materials.end());
    materials.clear();
    return true;
  }
};

class RandomEdits {
 public:
  explicit RandomEdits(std::uint64_t seed) : random_(seed) {
    twin_.nodes.emplace_back();
    twin_.nodes[0].handle = scene_.root();
    twin_.nodes[0].layers = kLayerModel;
    for (int i = 0; i < 4; ++i) materials_.push_back(add_material());
    mesh_ = scene_.add_mesh(triangle()).value();
  }

  void edit() {
    const int node = random_node();
    Twin::Node& n = twin_.nodes[std::size_t(node)];
    if (random_() % 50 == 0) edit_material();
    switch (random_() % 16) {
      case 0:
      case 1:
      case 2:
        return add_node(node);
      case 3:
        if (node != 0 && random_() % 3 == 0) remove_node(node);
        return;
      case 4:
        return reparent(node, random_node());
      case 5:
        n.transform = some_affine();
        scene_.set_transform(n.handle, n.transform);
        return twin_.touch_below(node);
      case 6:
        n.visible = random_() % 2;
        scene_.set_visible(n.handle, n.visible);
        return twin_.touch_below(node);
      case 7:
        n.layers = std::uint32_t(random_() % 4);
        if (node == 0) n.layers |= 1;
        scene_.set_layers(n.handle, n.layers);
        return twin_.touch_below(node);
      case 8:
        n.material = some_material();
        scene_.set_material(n.handle, n.material);
        return twin_.touch_below(node);
      case 9:
        if (node == 0) return;
        n.name = some_name();
        return scene_.set_name(n.handle, n.name);
      case 10:
      case 11:
      case 12:
        return add_item(node);
      default:
        return edit_item();
    }
  }

  /// Puts something no commit may publish somewhere; repair() undoes it.
  void spoil() {
    const double bad[] = {kNan, kInf, -kInf, 1e60, -1e300};
    const int node = random_node();
    Affine transform;
    (random_() % 2 ? transform.origin : transform.linear[int(random_() % 3)])[int(random_() % 3)] = bad[random_() % 5];
    twin_.nodes[std::size_t(node)].transform = transform;
    scene_.set_transform(twin_.nodes[std::size_t(node)].handle, transform);
    twin_.touch_below(node);
    spoiled_.push_back(node);
  }
  void repair() {
    for (const int node : spoiled_) {
      Twin::Node& n = twin_.nodes[std::size_t(node)];
      if (!n.alive) continue;
      n.transform = {};
      scene_.set_transform(n.handle, n.transform);
      twin_.touch_below(node);
    }
    spoiled_.clear();
  }

  /// Commits both; true when both succeed.
  bool commit() {
    SceneDelta expected;
    std::string worst;
    const bool good = twin_.commit(expected, worst);
    const auto delta = scene_.commit();
    EXPECT_EQ(bool(delta), good);
    if (!delta) {
      EXPECT_NE(delta.error().message.find("node \"" + worst + "\""), std::string::npos) << delta.error().message;
    } else if (good) {
      EXPECT_EQ(delta->inserted, expected.inserted);
      EXPECT_EQ(delta->changed, expected.changed);
      EXPECT_EQ(delta->removed, expected.removed);
      EXPECT_EQ(delta->materials, expected.materials);
      published_.push_back(*delta);
      for (Consumer& consumer : consumers_)
        if (random_() % 12 == 0) expect_all_since(consumer);
    }
    return good && delta;
  }

  void compare() const {
    std::size_t nodes = 0, items = 0;
    for (const Twin::Node& n : twin_.nodes) {
      ASSERT_EQ(scene_.contains(n.handle), n.alive);
      nodes += n.alive;
    }
    for (const Twin::Item& i : twin_.items) items += i.alive;
    ASSERT_EQ(scene_.node_count(), nodes);
    ASSERT_EQ(scene_.item_count(), items);
    ASSERT_EQ(scene_.item_slots(), twin_.items.size());
    compare_nodes();
    compare_items();
  }

 private:
  int random_node() {
    int node;
    do node = int(random_() % twin_.nodes.size());
    while (!twin_.nodes[std::size_t(node)].alive);
    return node;
  }
  Affine some_affine() {
    return random_() % 3 == 0 ? translation({uniform(random_, -10, 10), 0, 1})
                              : tests::random_affine(random_, 1.0, 1e3);
  }
  MaterialId some_material() { return random_() % 3 == 0 ? MaterialId{} : materials_[random_() % materials_.size()]; }
  std::string some_name() {
    return random_() % 4 == 0 ? "" : std::string(1 + random_() % 30, char('a' + random_() % 26));
  }

  MaterialId add_material() {
    const MaterialId added = scene_.add_material({});
    twin_.materials.insert(added.index);
    return added;
  }
  void edit_material() {
    MaterialId& material = materials_[random_() % materials_.size()];
    twin_.materials.insert(material.index);
    if (random_() % 2 == 0) return scene_.update_material(material, {.name = some_name()});
    scene_.remove_material(material);
    EXPECT_FALSE(scene_.contains(material));
    for (std::size_t n = 0; n < twin_.nodes.size(); ++n)
      if (twin_.nodes[n].alive && twin_.nodes[n].material == material) {
        twin_.nodes[n].material = {};
        twin_.touch_below(int(n));
      }
    for (Twin::Item& item : twin_.items)
      if (item.alive && item.material == material) item.material = {}, item.touched = true;
    material = add_material();
  }

  struct Consumer {
    SceneSubscription subscription;
    std::size_t seen = 0;  // of published_
  };
  /// Item by item, through what has happened to it.
  void expect_all_since(Consumer& consumer) {
    std::map<ItemId, char> fate;  // 'i'nserted, 'c'hanged, 'r'emoved, or '-' for what came and went
    std::set<std::uint32_t> materials;
    for (; consumer.seen < published_.size(); ++consumer.seen) {
      const SceneDelta& delta = published_[consumer.seen];
      for (const ItemId item : delta.inserted) fate[item] = 'i';
      for (const ItemId item : delta.changed)
        if (fate[item] != 'i') fate[item] = 'c';
      for (const ItemId item : delta.removed) fate[item] = fate[item] == 'i' ? '-' : 'r';
      materials.insert(delta.materials.begin(), delta.materials.end());
    }
    const auto of = [&](char wanted) {
      Ids ids;
      for (const auto& [item, is] : fate)
        if (is == wanted) ids.push_back(item);
      return ids;
    };
    const SceneDelta all = consumer.subscription.take();
    EXPECT_EQ(all.inserted, of('i'));
    EXPECT_EQ(all.changed, of('c'));
    EXPECT_EQ(all.removed, of('r'));
    EXPECT_TRUE(std::ranges::equal(all.materials, materials));
  }

  void add_node(int parent) {
    Twin::Node n;
    n.parent = parent;
    n.name = some_name();
    n.transform = some_affine();
    n.handle = scene_.add_node(twin_.nodes[std::size_t(parent)].handle, n.name, n.transform);
    twin_.nodes[std::size_t(parent)].children.push_back(int(twin_.nodes.size()));
    twin_.nodes.push_back(n);
  }
  void remove_node(int node) {
    scene_.remove_node(twin_.nodes[std::size_t(node)].handle);
    for (ItemId id{0}; to_index(id) < twin_.items.size(); ++id)
      if (twin_.items[to_index(id)].alive && twin_.within(twin_.items[to_index(id)].node, node)) twin_.remove(id);
    std::erase(twin_.nodes[std::size_t(twin_.nodes[std::size_t(node)].parent)].children, node);
    for (std::size_t n = 0; n < twin_.nodes.size(); ++n)
      if (twin_.nodes[n].alive && twin_.within(int(n), node)) doomed_.push_back(n);
    for (const std::size_t n : doomed_) twin_.nodes[n].alive = false;
    doomed_.clear();
  }
  void reparent(int node, int parent) {
    if (node == 0 || twin_.within(parent, node)) return;
    Twin::Node& n = twin_.nodes[std::size_t(node)];
    EXPECT_TRUE(scene_.reparent(n.handle, twin_.nodes[std::size_t(parent)].handle));
    std::erase(twin_.nodes[std::size_t(n.parent)].children, node);
    n.parent = parent;
    twin_.nodes[std::size_t(parent)].children.push_back(node);
    twin_.touch_below(node);
  }
  void add_item(int node) {
    Twin::Item item;
    item.node = node;
    item.placement = some_affine();
    item.material = some_material();
    const NodeId handle = twin_.nodes[std::size_t(node)].handle;
    const ItemId id = random_() % 3 == 0 ? scene_.add_mesh_instance(handle, mesh_, item.placement, item.material)
                                         : scene_.add_primitive(handle, kPipe, item.placement, item.material);
    EXPECT_EQ(to_index(id), twin_.items.size());
    item.placement.linear = dmat3(mat3(item.placement.linear));
    twin_.nodes[std::size_t(node)].items.push_back(id);
    twin_.items.push_back(item);
  }
  void edit_item() {
    if (twin_.items.empty()) return;
    const ItemId id = ItemId(random_() % twin_.items.size());
    Twin::Item& item = twin_.items[to_index(id)];
    if (!item.alive) return;
    switch (random_() % 4) {
      case 0:
        scene_.remove_item(id);
        return twin_.remove(id);
      case 1:
        item.placement = some_affine();
        scene_.set_placement(id, item.placement);
        item.placement.linear = dmat3(mat3(item.placement.linear));
        break;
      case 2:
        item.visible = random_() % 2;
        scene_.set_visible(id, item.visible);
        break;
      default:
        item.material = some_material();
        scene_.set_material(id, item.material);
    }
    item.touched = true;
  }

  static void expect_close(const Affine& a, const Affine& b) {
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) ASSERT_NEAR(a.linear[c][r], b.linear[c][r], 1e-9 * (1 + std::abs(b.linear[c][r])));
    for (int r = 0; r < 3; ++r) ASSERT_NEAR(a.origin[r], b.origin[r], 1e-9 * (1 + glm::length(b.origin)));
  }

  void compare_nodes() const {
    std::vector<int> order;  // parents first, children in their order
    for (std::vector<int> stack{0}; !stack.empty();) {
      const int node = stack.back();
      stack.pop_back();
      order.push_back(node);
      const auto& children = twin_.nodes[std::size_t(node)].children;
      stack.insert(stack.end(), children.rbegin(), children.rend());
    }
    std::size_t place = 0;
    scene_.for_each_node(scene_.root(),
                         [&](NodeId handle, const Affine& world, bool visible, std::uint32_t layers, MaterialId m) {
                           ASSERT_LT(place, order.size());
                           const int node = order[place++];
                           ASSERT_EQ(handle, twin_.nodes[std::size_t(node)].handle);
                           ASSERT_NO_FATAL_FAILURE(expect_close(world, twin_.world(node)));
                           ASSERT_EQ(visible, twin_.visible(node));
                           ASSERT_EQ(layers, twin_.layers(node));
                           ASSERT_EQ(m, twin_.material(node));
                         });
    ASSERT_EQ(place, order.size());
    for (const int node : order) {
      const Twin::Node& n = twin_.nodes[std::size_t(node)];
      ASSERT_EQ(scene_.name(n.handle), n.name);
      ASSERT_EQ(scene_.path(n.handle), twin_.path(node));
      ASSERT_NO_FATAL_FAILURE(expect_close(scene_.world_from_node(n.handle), twin_.world(node)));
      ASSERT_EQ(items_of(scene_, n.handle), n.items);
      std::vector<NodeId> children;
      for (const int c : n.children) children.push_back(twin_.nodes[std::size_t(c)].handle);
      ASSERT_EQ(children_of(scene_, n.handle), children);
      ASSERT_EQ(scene_.parent(n.handle), n.parent < 0 ? NodeId{} : twin_.nodes[std::size_t(n.parent)].handle);
    }
  }
  void expect_state(ItemId id, const Scene::ItemState& state) const {
    const Twin::Item& item = twin_.items[to_index(id)];
    const MaterialId material = item.material.valid() ? item.material : twin_.material(item.node);
    ASSERT_EQ(state.layers, item.visible && twin_.visible(item.node) ? twin_.layers(item.node) : 0u);
    ASSERT_EQ(state.material, material.index);
    ASSERT_NO_FATAL_FAILURE(expect_close(state.world_from_item, twin_.world(item.node) * item.placement));
  }
  void compare_items() const {
    Ids alive;
    for (ItemId id{0}; to_index(id) < twin_.items.size(); ++id) {
      ASSERT_EQ(scene_.contains_item(id), twin_.items[to_index(id)].alive);
      if (!twin_.items[to_index(id)].alive) continue;
      alive.push_back(id);
      ASSERT_EQ(scene_.node_of(id), twin_.nodes[std::size_t(twin_.items[to_index(id)].node)].handle);
      ASSERT_NO_FATAL_FAILURE(expect_state(id, scene_.state(id)));
    }
    std::size_t visited = 0;
    scene_.for_each_state(alive, [&](ItemId id, const Scene::ItemState& state) {
      ASSERT_EQ(id, alive[visited++]);
      ASSERT_NO_FATAL_FAILURE(expect_state(id, state));
    });
    ASSERT_EQ(visited, alive.size());
  }

  Random random_;
  Scene scene_;
  Twin twin_;
  std::vector<MaterialId> materials_;
  MeshId mesh_;
  std::vector<int> spoiled_;
  std::vector<SceneDelta> published_;
  std::array<Consumer, 3> consumers_{{{scene_.subscribe()}, {scene_.subscribe()}, {scene_.subscribe()}}};
  std::vector<std::size_t> doomed_;
};

TEST(Scene, RandomEditsMatchASlowTwin) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    RandomEdits edits(seed);
    for (int i = 0; i < 1000; ++i) {
      edits.edit();
      if (i % 7 == 0 && i % 3 == 0) {
        ASSERT_TRUE(edits.commit());
      }
      if (i % 50 == 0) {
        ASSERT_NO_FATAL_FAILURE(edits.compare());
      }
      if (testing::Test::HasFailure()) return;
    }
  }
}

TEST(Scene, FailedCommitsPublishNothingUntilRepaired) {
  int refused = 0;
  for (std::uint64_t seed = 1000; seed < 1100; ++seed) {
    SCOPED_TRACE(seed);
    RandomEdits edits(seed);
    Random random(seed);
    for (int i = 0; i < 1000; ++i) {
      edits.edit();
      if (random() % 40 == 0) edits.spoil();
      if (random() % 20 != 0) continue;
      if (!edits.commit()) {
        ++refused;
        edits.edit();
        edits.commit();  // fails again, or the bad node is gone
        edits.repair();
        ASSERT_TRUE(edits.commit());
        ASSERT_NO_FATAL_FAILURE(edits.compare());
      }
      if (testing::Test::HasFailure()) return;
    }
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace sightline::core::scene_twin_test
