// What the viewer shows of a comparison, against lists kept beside: the copies of removed items, the rows, and a
// session whose user goes on selecting, hiding and undoing meanwhile.
#include "sightline/apps/view/change_list.h"

#include <filesystem>
#include <fstream>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "sightline/apps/common/change_colours.h"
#include "sightline/apps/common/tree_walk.h"
#include "sightline/apps/view/session.h"
#include "sightline/engine/pick.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::apps::change_list_test {
namespace {

using compare::State;
using core::dvec3;
using core::ItemId;
using core::NodeId;
using Random = std::mt19937_64;

constexpr State kStates[] = {State::kUnchanged, State::kAdded, State::kRemoved, State::kMoved, State::kChanged};

/// What a random model is made from, so that it can be made twice with edits between.
struct Part {
  int kind = 0;  // sphere, line, mesh
  double size = 1.0;
  dvec3 at{0.0};
  bool hidden = false;
};
struct Branch {
  std::string name, mark;
  dvec3 moved{0.0};
  int parent = -1;  // of the branches before it; -1: the file
  std::vector<Part> parts;
};
using Plan = std::vector<Branch>;

Plan random_plan(Random& random) {
  Plan plan;
  for (int i = 0; i < 12; ++i) {
    Branch branch{random() % 4 ? "node" + std::to_string(random() % 6) : "",
                  std::to_string(random() % 3),
                  {double(random() % 5), double(i), 0.0},
                  int(random() % unsigned(i + 1)) - 1,
                  {}};
    for (auto n = random() % 5; n > 0; --n)
      branch.parts.push_back({int(random() % 3),
                              0.5 + 0.1 * double(random() % 3),
                              {double(random() % 900), double(random() % 900), double(random() % 900)},
                              random() % 9 == 0});
    plan.push_back(branch);
  }
  return plan;
}

Plan edited(Plan plan, Random& random) {
  for (int edits = 0; edits < 8; ++edits) {
    Branch& branch = plan[random() % plan.size()];
    switch (random() % 5) {
      case 0:
        branch.parts.push_back({int(random() % 3), 1.0, {double(random() % 900), -5.0, 0.0}, false});
        break;
      case 1:
        if (!branch.parts.empty()) branch.parts.erase(branch.parts.begin());
        break;
      case 2:
        branch.moved.x += 0.25;
        break;
      case 3:
        if (!branch.parts.empty()) branch.parts.back().size *= 1.5;
        break;
      default:
        branch.mark += "x";
    }
  }
  return plan;
}

core::Mesh tetrahedron() {
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0.7f, 0}, {0.1f, 0.2f, 0.5f}};
  mesh.indices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  return mesh;
}

Model model_of(const Plan& plan, const std::string& file, const dvec3& offset = dvec3(0.0)) {
  Model model;
  model.scene = std::make_unique<core::Scene>();
  core::Scene& scene = *model.scene;
  scene.set_transform(scene.root(), core::translation(offset));
  model.report.nodes = {scene.add_node(scene.root(), file, core::translation({7.0, 0.0, 0.0}))};
  const core::MeshId mesh = scene.add_mesh(tetrahedron()).value();
  std::vector<NodeId> nodes;
  for (const Branch& branch : plan) {
    const NodeId parent = branch.parent < 0 ? model.report.nodes[0] : nodes[std::size_t(branch.parent)];
    nodes.push_back(scene.add_node(parent, branch.name, core::translation(branch.moved)));
    if (!branch.mark.empty()) scene.set_attribute(nodes.back(), "Mark", branch.mark);
    for (const Part& part : branch.parts) {
      core::Affine place = core::translation(part.at);
      const float size = float(part.size);
      if (part.kind == 2) place.linear *= part.size;
      const ItemId item = part.kind == 0   ? scene.add_primitive(nodes.back(), core::Sphere{size}, place)
                          : part.kind == 1 ? scene.add_primitive(nodes.back(), core::Box{size, 1, 2}, place)
                                           : scene.add_mesh_instance(nodes.back(), mesh, place);
      scene.set_visible(item, !part.hidden);
    }
  }
  EXPECT_TRUE(scene.commit());
  return model;
}

std::unique_ptr<ChangeList> changes_of(Model before, const Model& open) {
  auto found = compare_models(before, open, {});
  EXPECT_TRUE(found);
  return std::make_unique<ChangeList>("/some/old.rvm", std::move(before), std::move(*found));
}

std::string path_below(const core::Scene& scene, NodeId node, NodeId top) {
  std::string path;
  for (; node != top; node = scene.parent(node)) path = std::string(scene.name(node)) + "/" + path;
  return path;
}

NodeId removed_node(const core::Scene& scene) {
  for (NodeId node = scene.first_child(scene.root()); node.valid(); node = scene.next_sibling(node))
    if (scene.name(node) == "removed (old.rvm)") return node;
  return {};
}

void expect_copy(const core::Scene& old, NodeId old_top, ItemId item, const core::Scene& now, NodeId top, ItemId copy) {
  EXPECT_EQ(old.kind(item), now.kind(copy));
  const auto was = old.state(item), is = now.state(copy);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(was.world_from_item.linear[c], is.world_from_item.linear[c]);
  EXPECT_NEAR(glm::distance(was.world_from_item.origin, is.world_from_item.origin), 0.0, 1e-9);
  EXPECT_EQ(was.layers, is.layers) << "hidden ones stay hidden";
  const auto a = old.bounds_under(item, was.world_from_item), b = now.bounds_under(copy, is.world_from_item);
  EXPECT_NEAR(glm::distance(a.min, b.min) + glm::distance(a.max, b.max), 0.0, 1e-9);
  EXPECT_EQ(path_below(old, old.node_of(item), old_top), path_below(now, now.node_of(copy), top));
  if (now.node_of(copy) != top) {
    EXPECT_EQ(old.attributes(old.node_of(item)), now.attributes(now.node_of(copy)));
  }
}

TEST(ChangeList, CopiesWhatIsRemovedAndTakesItAway) {
  std::size_t all_removed = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random{seed};
    const Plan plan = random_plan(random);
    const dvec3 offset(seed % 2 ? 5e5 : 0.0, 0.0, 3.0);
    const Model open = model_of(edited(plan, random), "new.rvm", offset);
    auto changes = changes_of(model_of(plan, "old.rvm", offset), open);
    core::Scene& scene = *open.scene;
    const std::size_t items = scene.item_count(), nodes = scene.node_count(), meshes = scene.mesh_slots();
    const auto& found = changes->found();
    const std::size_t removed = found.count(State::kRemoved);
    all_removed += removed;
    ASSERT_TRUE(changes->add_removed(scene));
    ASSERT_TRUE(scene.commit());
    EXPECT_EQ(scene.item_count(), items + removed);
    const NodeId top = removed_node(scene);
    EXPECT_EQ(top.valid(), removed > 0);
    const NodeId old_top = changes->before().first_child(changes->before().root());
    std::set<const compare::Change*> listed;
    for (std::size_t row = 0; row < changes->row_count(); ++row) {
      const std::vector<ItemId> below = items_below(scene, changes->node(scene, row));
      for (const ItemId item : changes->items(scene, row)) {
        EXPECT_TRUE(std::binary_search(below.begin(), below.end(), item)) << "a group stands above its items";
        const compare::Change* change = changes->of(item);
        ASSERT_NE(change, nullptr);
        listed.insert(change);
        if (change->state == State::kRemoved)
          expect_copy(changes->before(), old_top, change->before, scene, top, item);
        else
          EXPECT_EQ(item, change->after);
      }
    }
    for (const compare::Change& change : found.items)
      if (change.state != State::kUnchanged) {
        EXPECT_TRUE(listed.contains(&change));
      }
    const BaseStyles base_styles = changes->base_styles();
    for (ItemId item{0}; to_index(item) < scene.item_slots(); ++item) {
      ASSERT_NE(changes->of(item), nullptr);
      const State state = changes->of(item)->state;
      ASSERT_NE(base_styles.of(item), nullptr);
      EXPECT_EQ(base_styles.of(item)->style.ghost, state == State::kUnchanged);
      EXPECT_EQ(base_styles.of(item)->style.colour, change_colour(state));
    }
    changes->take_removed(scene);
    ASSERT_TRUE(scene.commit());
    EXPECT_EQ(scene.item_count(), items);
    EXPECT_EQ(scene.node_count(), nodes);
    for (std::size_t mesh = meshes; mesh < scene.mesh_slots(); ++mesh) EXPECT_FALSE(scene.mesh_at(mesh).valid());
  }
  EXPECT_GT(all_removed, 30u);
}

TEST(ChangeList, RowsAreThoseOfTheStatesThatShow) {
  Random random{3};
  const Plan plan = random_plan(random);
  const Model open = model_of(edited(edited(plan, random), random), "new.rvm");
  auto changes = changes_of(model_of(plan, "old.rvm"), open);
  ASSERT_TRUE(changes->add_removed(*open.scene));
  const auto states = [&] {
    std::vector<State> rows;
    for (std::size_t row = 0; row < changes->row_count(); ++row) rows.push_back(changes->state(row));
    return rows;
  };
  const std::vector<State> all = states();
  for (unsigned set = 0; set < 32; ++set) {
    for (std::size_t i = 0; i < compare::kStateCount; ++i) changes->set_shown(State(i), (set >> i & 1) != 0);
    std::vector<State> expected = all;
    std::erase_if(expected, [&](State state) { return (set >> unsigned(state) & 1) == 0; });
    const std::vector<State> rows = states();
    for (std::size_t row = 0; row < changes->row_count(); ++row) {
      EXPECT_FALSE(changes->name(row).empty());
      EXPECT_FALSE(changes->what(row, {}).empty());
    }
    EXPECT_EQ(rows, expected);
    for (std::size_t i = 0; i < compare::kStateCount; ++i)
      EXPECT_EQ(changes->base_styles().all[i].shown, (set >> i & 1) != 0);
  }
  ASSERT_GT(changes->row_count(), 3u);
  EXPECT_EQ(changes->step(-1), changes->row_count() - 1);
  EXPECT_EQ(changes->step(1), 0u);
  EXPECT_EQ(changes->step(1), 1u);
  const NodeId node = changes->node(*open.scene, 1);
  for (const State state : kStates)
    if (state != changes->state(1)) changes->set_shown(state, false);
  ASSERT_TRUE(changes->current());
  EXPECT_EQ(changes->node(*open.scene, *changes->current()), node) << "it stays the current one";
  changes->set_shown(changes->state(0), false);
  EXPECT_EQ(changes->row_count(), 0u);
  EXPECT_FALSE(changes->current() || changes->step(1));
}

TEST(ChangeList, TellsWhatDiffers) {
  const Plan plan = {{"valve", "A", {0, 0, 0}, -1, {{1, 1.0, {0, 0, 0}, false}}},
                     {"pipe", "A", {9, 0, 0}, -1, {{0, 1.0, {0, 0, 0}, false}}}};
  Plan other = plan;
  other[0].mark = "B";
  other[0].parts[0].size = 2.0;
  other[0].moved = {0.0, 1.5, 0.0};
  const Model open = model_of(other, "new.rvm");
  auto changes = changes_of(model_of(plan, "old.rvm"), open);
  ASSERT_TRUE(changes->add_removed(*open.scene));
  // One item in three groups: its move is left to that of its shape.
  ASSERT_EQ(changes->row_count(), 2u);
  std::vector<std::string> words{changes->what(0, {Units::kMillimetres}), changes->what(1, {Units::kMillimetres})};
  std::sort(words.begin(), words.end());
  EXPECT_EQ(words[0], "1 item (box) changed in attribute Mark from \"A\" to \"B\"");
  EXPECT_EQ(words[1], "1 item (box) changed in shape");
  EXPECT_EQ(changes->name(0), "valve");
  EXPECT_EQ(describe(*changes->of(ItemId{0}), {Units::kMillimetres}), "changed: shape, attributes; moved by 1,500 mm");
  const auto facts = changes->differing_facts(*open.scene, ItemId{0});
  ASSERT_EQ(facts.size(), 4u);
  EXPECT_EQ(facts[0], (FactChange{"along its own x", "1 m", "2 m"}));
  EXPECT_EQ(facts[1].name, "from");
  EXPECT_EQ(facts[3], (FactChange{"Mark", "A", "B"}));
  EXPECT_EQ(differing({{"a", "1"}, {"b", "2"}}, {{"c", "3"}, {"b", "2"}}),
            (std::vector<FactChange>{{"c", "", "3"}, {"a", "1", ""}}));
}

TEST(ChangeList, OfSeveralFilesTheOneOfTheSameNameCounts) {
  Random random{5};
  const Plan plan = random_plan(random);
  Model open = model_of(plan, "a.rvm");
  open.report.nodes.push_back(open.scene->add_node(open.scene->root(), "b.rvm"));
  ASSERT_TRUE(open.scene->commit());
  const auto same = compare_models(model_of(plan, "a.rvm"), open, {});
  ASSERT_TRUE(same);
  EXPECT_TRUE(same->found.same());
  const auto other = compare_models(model_of(plan, "c.rvm"), open, {});
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("c.rvm"), std::string::npos);
  Model attributes;
  attributes.scene = std::make_unique<core::Scene>();
  EXPECT_FALSE(compare_models(attributes, open, {}));
}

TEST(ChangeList, FindsAttributeFilesBesideTheOlderRevision) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "older_files";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const auto touch = [&](const char* name) { return std::ofstream(folder / name), (folder / name).string(); };
  const std::string old = touch("plant-1.rvm"), named = touch("plant-1.txt");
  EXPECT_EQ(older_files(old, {"/new/plant.rvm"}), (std::vector<std::string>{old}));
  EXPECT_EQ(older_files(old, {"/new/plant.rvm", "/new/plant.txt"}), (std::vector<std::string>{old, named}));
  EXPECT_EQ(older_files(old, {"/new/plant.ATT"}), (std::vector<std::string>{old}));
  const std::string beside = touch("plant.txt");
  EXPECT_EQ(older_files(old, {"/new/plant.txt"}), (std::vector<std::string>{old, beside}));
  std::filesystem::remove_all(folder);
}

TEST(ChangeList, NamesTellFilesApart) {
  using Names = std::pair<std::string, std::string>;
  const std::string slash(1, char(std::filesystem::path::preferred_separator));
  EXPECT_EQ(names_apart("/x/a.rvm", {"/y/b.rvm", "/y/b.txt"}), Names("a.rvm", "b.rvm"));
  EXPECT_EQ(names_apart("/x/b.rvm", {"/y/a.rvm", "/y/b.rvm"}), Names("x" + slash + "b.rvm", "y" + slash + "b.rvm"));
  EXPECT_EQ(names_apart("/x/old/../new/a.rvm", {"/x/older/a.rvm"}),
            Names("new" + slash + "a.rvm", "older" + slash + "a.rvm"));
}

/// A session of spheres, each alone on a ray. Removed ones are part of it while it compares.
class ComparingSession : public ::testing::Test {
 protected:
  static Model row_of(int count, const std::string& file, const std::function<std::optional<dvec3>(int)>& place) {
    Model model;
    model.scene = std::make_unique<core::Scene>();
    model.report.nodes = {model.scene->add_node(model.scene->root(), file)};
    for (int i = 0; i < count; ++i)
      if (const auto at = place(i)) {
        const NodeId node = model.scene->add_node(model.report.nodes[0], "part" + std::to_string(i));
        const float size = 0.3f + 0.005f * float(i);  // no two are alike, as they would count as moved
        const bool changed = i % 7 == 3 && file == "new.rvm";
        model.scene->add_primitive(node, core::Sphere{changed ? size + 0.4f : size}, core::translation(*at));
      }
    EXPECT_TRUE(model.scene->commit());
    return model;
  }
  /// Changes 60 parts: one in five is gone, one in six has moved, one in seven has changed; ten have come.
  void SetUp() override {
    Model open = row_of(70, "new.rvm", [](int i) {
      return i % 5 == 1 && i < 60 ? std::nullopt : std::optional(dvec3(i, 0.0, i % 6 == 2 ? 3.0 : 0.0));
    });
    session = std::move(*Session::open(std::move(open), {}));
    originals = ItemId(session->scene().item_slots());
  }
  core::Expected<void> begin() {
    Model before = row_of(60, "old.rvm", [](int i) { return std::optional(dvec3(i, i == 1 ? 50.0 : 0.0, 0.0)); });
    return session->begin_comparison(changes_of(std::move(before), session->model()));
  }
  bool found(ItemId item) {
    const dvec3 at = session->scene().state(item).world_from_item.origin;
    const auto hit = session->engine.pick(core::Ray{{at.x, -5.0, at.z}, {0.0, 1.0, 0.0}});
    return *hit && (*hit)->item == item;
  }
  /// Rays find what is neither hidden nor faint; with the slider, what is in the revision on that side.
  void expect_picks() {
    if (!session->slider.at()) return expect_picks({});
    ASSERT_TRUE(session->pick({0.4 * session->image.size()[0], 5.0}));
    expect_picks(session->changes()->only_in(Revision::kNewer));
    ASSERT_TRUE(session->pick({0.6 * session->image.size()[0], 5.0}));
    expect_picks(session->changes()->only_in(Revision::kOlder));
  }
  void expect_picks(const std::vector<ItemId>& elsewhere) {
    const Document& document = session->document;
    for (ItemId item{0}; to_index(item) < session->scene().item_slots(); ++item) {
      if (!session->scene().contains_item(item)) continue;
      bool seen = !document.is(item, Document::kHidden), ghost = document.is(item, Document::kGhost);
      if (const ChangeList* changes = session->changes()) {
        const State state = changes->of(item)->state;
        seen &= changes->shown(state);
        ghost |= state == State::kUnchanged && !session->slider.at();
      }
      ASSERT_EQ(document.shown(item), seen) << to_index(item);
      const bool here = !std::binary_search(elsewhere.begin(), elsewhere.end(), item);
      ASSERT_EQ(found(item), here && seen && (!ghost || document.is(item, Document::kSelected))) << to_index(item);
    }
  }
  std::vector<int> flags() const {
    std::vector<int> all;
    for (ItemId item{0}; item < originals; ++item)
      for (const auto flag : {Document::kSelected, Document::kHidden, Document::kGhost})
        all.push_back(session->document.is(item, flag) ? 1 : 0);
    return all;
  }
  void random_step(Random& random) {
    std::vector<ItemId> some;
    for (ItemId item{0}; to_index(item) < session->scene().item_slots(); ++item)
      if (random() % 4 == 0 && session->scene().contains_item(item)) some.push_back(item);
    Document& document = session->document;
    switch (random() % 8) {
      case 0:
        ASSERT_TRUE(document.hide(some));
        break;
      case 1:
        ASSERT_TRUE(document.isolate(some));
        break;
      case 2:
        ASSERT_TRUE(document.ghost_others(some));
        break;
      case 3:
        ASSERT_TRUE(document.show_all());
        break;
      case 4:
        if (!some.empty()) {
          document.hovered = taken_at(session->scene(), some[0], SelectionLevel::kItem);
        }
        break;
      case 5:
        if (ChangeList* changes = session->changes()) {
          if (random() % 2) {
            ASSERT_TRUE(session->set_slider(session->slider.at() ? std::nullopt : std::optional(0.5)));
            break;
          }
          const State state = kStates[random() % 5];
          ASSERT_TRUE(session->show_changes(state, !changes->shown(state)));
          break;
        }
        [[fallthrough]];
      default:
        ASSERT_TRUE(document.select(some, SelectMode(random() % 3)));
    }
  }

  std::unique_ptr<Session> session;
  ItemId originals{0};
};

TEST_F(ComparingSession, ShowsWhatChangedAndGoesThere) {
  ASSERT_TRUE(begin());
  const ChangeList& changes = *session->changes();
  EXPECT_EQ(changes.found().count(State::kRemoved), 12u);
  EXPECT_EQ(changes.found().count(State::kAdded), 10u);
  EXPECT_GT(changes.found().count(State::kMoved), 5u);
  EXPECT_GT(changes.found().count(State::kChanged), 4u);
  EXPECT_EQ(session->scene().item_count(), to_index(originals) + 12u);
  EXPECT_GT(session->bounds().bounds.max.y, 49.0) << "the whole has a removed part there";
  expect_picks();
  std::size_t removed = 0;
  for (std::size_t row = 0; row < changes.row_count(); ++row) {
    ASSERT_TRUE(go_to_change(*session, row));
    const std::vector<ItemId> items = changes.items(session->scene(), row);
    const auto selection = session->document.selection();
    ASSERT_TRUE(std::equal(selection.begin(), selection.end(), items.begin(), items.end()));
    const core::dmat4 clip_from_world = session->image.view()->clip_from_world();
    for (const ItemId item : items) {
      const core::dvec4 at = clip_from_world * core::dvec4(session->scene().state(item).world_from_item.origin, 1.0);
      EXPECT_LT(std::max(std::abs(at.x), std::abs(at.y)), at.w) << "it lies in the image";
    }
    if (changes.state(row) == State::kRemoved) removed = row;
  }
  ASSERT_TRUE(go_to_change(*session, removed));
  session->tree.find({"part1"});
  EXPECT_EQ(session->tree.match_count(), 11u) << "three of them removed";
  ASSERT_TRUE(session->end_comparison());
  EXPECT_EQ(session->tree.match_count(), 8u);
  EXPECT_EQ(session->scene().item_count(), to_index(originals));
  EXPECT_LT(session->bounds().bounds.max.y, 5.0);
  EXPECT_TRUE(session->document.selection().empty()) << "what was selected is no more";
  expect_picks();
  EXPECT_EQ(apps::items_below(session->scene(), session->scene().root()).size(), to_index(originals));
}

/// Left of the slider lies the older revision as it was.
TEST_F(ComparingSession, TheSliderHasBothRevisions) {
  ASSERT_TRUE(begin());
  const std::size_t items = session->scene().item_count();
  const auto shapes = [](const core::Scene& scene, const std::vector<ItemId>& list) {
    std::multiset<std::array<long, 4>> all;
    for (const ItemId item : list) {
      const dvec3 at = scene.state(item).world_from_item.origin;
      const double size = scene.bounds_under(item, {}).max.x;
      all.insert({std::lround(1e4 * at.x), std::lround(1e4 * at.y), std::lround(1e4 * at.z), std::lround(1e4 * size)});
    }
    return all;
  };
  const auto all_items = [](const core::Scene& scene) { return items_below(scene, scene.root()); };
  ASSERT_TRUE(session->set_slider(0.5));
  const ChangeList& changes = *session->changes();
  const core::Scene& scene = session->scene();
  const auto& found = changes.found();
  EXPECT_EQ(scene.item_count(), items + found.count(State::kMoved) + found.count(State::kChanged));
  for (const Revision revision : {Revision::kOlder, Revision::kNewer}) {
    const auto others = changes.only_in(revision == Revision::kOlder ? Revision::kNewer : Revision::kOlder);
    std::vector<ItemId> own = all_items(scene);
    std::erase_if(own, [&](ItemId item) { return std::binary_search(others.begin(), others.end(), item); });
    EXPECT_EQ(own.size(), revision == Revision::kOlder ? 60u : to_index(originals));
    if (revision == Revision::kOlder) {
      EXPECT_EQ(shapes(scene, own), shapes(changes.before(), all_items(changes.before())));
    }
    for (const ItemId item : others) EXPECT_NE(changes.of(item), nullptr);
  }
  expect_picks();
  ASSERT_TRUE(session->document.select(changes.only_in(Revision::kOlder)));
  EXPECT_EQ(session->document.selection().size(), changes.only_in(Revision::kOlder).size()) << "whatever is drawn";
  ASSERT_TRUE(session->document.hide(changes.only_in(Revision::kOlder)));
  expect_picks();
  EXPECT_FALSE(session->slider.parts(session->image.drawn_size()[0]).empty());
  ASSERT_TRUE(session->set_slider({}));
  EXPECT_EQ(scene.item_count(), items);
  expect_picks();
  ASSERT_TRUE(session->document.undo());
  expect_picks();
}

/// Undo goes through the whole of a comparison, but for what only its removed items knew of.
TEST_F(ComparingSession, UndoGoesThroughIt) {
  for (unsigned seed = 1; seed <= 25; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    SetUp();
    Random random{seed};
    std::vector<std::vector<int>> states{flags()};
    const auto steps = [&](int count) {
      for (int i = 0; i < count; ++i) {
        random_step(random);
        for (const ItemId item : session->document.selection()) ASSERT_TRUE(session->document.shown(item));
        if (flags() != states.back()) states.push_back(flags());
      }
      expect_picks();
    };
    steps(6);
    for (int comparison = 0; comparison < 2; ++comparison) {
      const auto before = flags();
      ASSERT_TRUE(begin());
      EXPECT_EQ(flags(), before);
      steps(10);
      if (comparison == 1) {
        ASSERT_TRUE(begin()) << "in place of the former one";
        steps(3);
      }
      const auto during = flags();
      ASSERT_TRUE(session->end_comparison());
      EXPECT_EQ(flags(), during);
      EXPECT_EQ(session->scene().item_count(), to_index(originals));
      expect_picks();
    }
    std::size_t hidden = 0, selected = 0;
    for (ItemId item{0}; item < originals; ++item) {
      hidden += session->document.is(item, Document::kHidden);
      selected += session->document.is(item, Document::kSelected);
    }
    EXPECT_EQ(session->document.hidden(), hidden);
    EXPECT_EQ(session->document.selection().size(), selected);
    while (session->document.undo_steps() > 0) {
      ASSERT_TRUE(session->document.undo());
      states.pop_back();
      ASSERT_FALSE(states.empty());
      ASSERT_EQ(flags(), states.back());
    }
    EXPECT_EQ(states.size(), 1u);
    expect_picks();
  }
}

}  // namespace
}  // namespace sightline::apps::change_list_test
