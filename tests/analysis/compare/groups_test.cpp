// Groups of equal changes against a twin that walks the whole tree for each of them, and cases made by hand.
#include "sightline/analysis/compare/groups.h"

#include <cmath>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/tests/core/primitive_samples.h"

namespace sightline::tests::compare_groups_test {
namespace {

using compare::Change;
using compare::Comparison;
using compare::Group;
using compare::Groups;
using compare::Way;
using core::dvec3;
using core::NodeId;
using core::Scene;

struct Pair {
  Scene before, after;

  Comparison found() const { return compare::revisions({&before, before.root()}, {&after, after.root()}).value(); }
  Groups grouped(const Comparison& found) const {
    return compare::grouped({&before, before.root()}, {&after, after.root()}, found, 1e-4);
  }
  Groups grouped() const { return grouped(found()); }
};

/// "moved /a/b 3/4" for each group, in their order.
std::vector<std::string> lines(const Pair& pair, const Groups& groups) {
  std::vector<std::string> out;
  for (const Group& g : groups.all)
    out.push_back(std::string(compare::name_of(g.way)) + " /" +
                  (g.way == Way::kRemoved ? pair.before : pair.after).path(g.node) + " " + std::to_string(g.size()) +
                  "/" + std::to_string(g.of));
  return out;
}
using Lines = std::vector<std::string>;

// --- the twin --------------------------------------------------------------------------------------------------------

/// What the twin says of a group: way, node, members, of.
using Expected = std::set<std::tuple<int, std::uint32_t, std::vector<std::uint32_t>, std::size_t>>;

class Twin {
 public:
  Twin(const Pair& pair, const Comparison& found) : pair_(pair), found_(found) {}

  Expected groups() {
    for (const Way way : {Way::kAdded, Way::kRemoved, Way::kMoved, Way::kShape, Way::kMaterial}) {
      std::set<std::string> kinds;
      for (const Change& change : found_.items) kinds.insert(kind(way, change));
      kinds.erase("");
      const Scene& scene = way == Way::kRemoved ? pair_.before : pair_.after;
      for (const std::string& kind : kinds) split(way, kind, scene, scene.root());
    }
    return out_;
  }

 private:
  /// Equal for equal changes, empty where an item did not change so.
  std::string kind(Way way, const Change& c) const {
    const bool added = c.before == core::kNoItem, removed = c.after == core::kNoItem;
    if (way == Way::kAdded) return added ? "added" : "";
    if (way == Way::kRemoved) return removed ? "removed" : "";
    if (added || removed) return "";
    if (way == Way::kShape) return c.differences & compare::kShape ? "shape" : "";
    if (way == Way::kMaterial)
      return c.differences & compare::kMaterial ? std::to_string(pair_.after.state(c.after).material) + "!" : "";
    if (!(c.differences & compare::kPlace) || c.differences & compare::kShape) return "";
    std::string text;
    for (int axis = 0; axis < 3; ++axis) text += std::to_string(std::lround(c.offset[axis] * 100)) + " ";
    return text;
  }
  bool may(Way way, const Change& c) const {
    const bool added = c.before == core::kNoItem, removed = c.after == core::kNoItem;
    if (way == Way::kRemoved) return !added;
    if (way == Way::kAdded) return !removed;
    return !added && !removed && !(way == Way::kMoved && c.differences & compare::kShape);
  }
  struct Counted {
    std::vector<std::uint32_t> members;
    std::size_t of = 0;
  };
  Counted count(Way way, const std::string& kind_wanted, const Scene& scene, NodeId top, bool deep) const {
    Counted out;
    scene.for_each_node(top, [&](NodeId node, const auto&...) {
      if (!deep && node != top) return;
      for (core::ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item))
        for (std::uint32_t i = 0; i < found_.items.size(); ++i) {
          const Change& c = found_.items[i];
          if ((way == Way::kRemoved ? c.before : c.after) != item) continue;
          out.of += may(way, c) ? 1 : 0;
          if (kind(way, c) == kind_wanted) out.members.push_back(i);
        }
    });
    return out;
  }
  void split(Way way, const std::string& kind, const Scene& scene, NodeId node) {
    const Counted all = count(way, kind, scene, node, true);
    if (all.members.empty()) return;
    const Counted own = count(way, kind, scene, node, false);
    std::vector<NodeId> filled;
    for (NodeId child = scene.first_child(node); child.valid(); child = scene.next_sibling(child))
      if (!count(way, kind, scene, child, true).members.empty()) filled.push_back(child);
    const bool branches = filled.size() + (own.members.empty() ? 0 : 1) > 1 || filled.empty();
    if (all.members.size() == all.of || (branches && 10 * all.members.size() >= 9 * all.of))
      return void(out_.emplace(int(way), node.index, all.members, all.of));
    // Own items and those of leaves stay together; a single holder has them alone.
    std::vector<std::pair<NodeId, Counted>> holders;
    if (!own.members.empty()) holders.emplace_back(node, own);
    for (const NodeId child : filled)
      if (!scene.first_child(child).valid())
        holders.emplace_back(child, count(way, kind, scene, child, true));
      else
        split(way, kind, scene, child);
    if (holders.empty()) return;
    if (holders.size() == 1)
      return void(out_.emplace(int(way), holders[0].first.index, holders[0].second.members, holders[0].second.of));
    std::vector<std::uint32_t> members;
    for (const auto& [holder, counted] : holders)
      members.insert(members.end(), counted.members.begin(), counted.members.end());
    out_.emplace(int(way), node.index, members, all.of);
  }

  const Pair& pair_;
  const Comparison& found_;
  Expected out_;
};

/// Adds the same random subtree to both scenes, with changes to parts of the later one.
class RandomPair {
 public:
  RandomPair(Random& random, Pair& pair) : random_(random), pair_(pair) {
    for (int i = 0; i < 3; ++i)
      for (Scene* scene : {&pair.before, &pair.after})
        materials_.push_back(scene->add_material({"m" + std::to_string(i), {0.5f, 0.5f, 0.5f}, 1.0f, 0}));
    grow(pair.before.root(), pair.after.root(), {}, 4);
  }

 private:
  struct Edit {
    dvec3 offset{0.0};
    std::size_t material = 0;
    bool removed = false, added = false;
  };
  bool one_in(int n) { return random_() % std::uint64_t(n) == 0; }
  Edit edited(Edit edit) {
    if (one_in(8)) edit.offset += dvec3(double(random_() % 3), double(random_() % 2), 0.5);
    if (one_in(10)) edit.material = random_() % 3;
    if (one_in(14)) edit.removed = true;
    if (one_in(14)) edit.added = true;
    return edit;
  }
  void add_item(NodeId before, NodeId after, const Edit& inherited) {
    const Edit edit = edited(inherited);
    // All lie in a row far apart, so that none is taken for another one.
    const dvec3 at(0.0, 0.0, 100.0 * double(items_++));
    const float size = float(1 + items_ % 7) * 0.1f, now = one_in(16) ? 2.0f * size : size;
    if (!edit.added || edit.removed)
      pair_.before.add_primitive(before, core::Sphere{size}, core::translation(at), materials_[0]);
    if (!edit.removed)
      pair_.after.add_primitive(after, core::Sphere{now}, core::translation(at + edit.offset),
                                materials_[2 * edit.material + 1]);
  }
  void grow(NodeId before, NodeId after, const Edit& inherited, int depth) {
    const Edit edit = edited(inherited);
    for (auto n = random_() % 6; n > 0; --n) add_item(before, after, edit);
    for (auto n = depth == 0 ? 0 : random_() % 4; n > 0; --n) {
      const std::string name = "n" + std::to_string(nodes_++);
      grow(pair_.before.add_node(before, name), pair_.after.add_node(after, name), edit, depth - 1);
    }
  }

  Random& random_;
  Pair& pair_;
  std::vector<core::MaterialId> materials_;
  std::size_t items_ = 0, nodes_ = 0;
};

TEST(CompareGroups, AreWhatTheTwinFinds) {
  std::map<int, std::size_t> seen;
  std::size_t with_exceptions = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    Pair pair;
    RandomPair made(random, pair);
    const Comparison found = pair.found();
    const Groups groups = pair.grouped(found);
    Expected got;
    for (const Group& g : groups.all) {
      if (g.way > Way::kMaterial) continue;
      const std::vector<std::uint32_t> members(groups.members.begin() + g.begin, groups.members.begin() + g.end);
      got.emplace(int(g.way), g.node.index, members, g.of);
      ++seen[int(g.way)];
      with_exceptions += g.size() < g.of ? 1 : 0;
    }
    ASSERT_EQ(got, Twin(pair, found).groups());
    for (std::size_t i = 1; i < groups.all.size(); ++i) EXPECT_GE(groups.all[i - 1].size(), groups.all[i].size());
  }
  for (const Way way : {Way::kAdded, Way::kRemoved, Way::kMoved, Way::kShape, Way::kMaterial})
    EXPECT_GT(seen[int(way)], 100u) << int(way);
  EXPECT_GT(with_exceptions, 100u);
}

// --- by hand ---------------------------------------------------------------------------------------------------------

/// Lines of ten boxes each below "plant", each box below a node of its own.
struct Plant {
  explicit Plant(Scene& to) : scene(to), top(to.add_node(to.root(), "plant")) {
    for (int line = 0; line < 3; ++line) {
      lines.push_back(scene.add_node(top, "line-" + std::to_string(line)));
      for (int i = 0; i < 10; ++i) {
        const NodeId part = scene.add_node(lines.back(), "part-" + std::to_string(i));
        parts.push_back(part);
        items.push_back(scene.add_primitive(part, core::Box{1, 2, 3 + 0.1f * float(i)},
                                            core::translation({5.0 * i, 20.0 * line, 0})));
      }
    }
  }
  Scene& scene;
  NodeId top;
  std::vector<NodeId> lines, parts;
  std::vector<core::ItemId> items;
};

struct Plants : Pair {
  Plant old{before}, now{after};

  /// One part has an attribute in both, so that others are compared.
  void begin_attributes() {
    before.set_attribute(old.parts.back(), "Type", "flange");
    after.set_attribute(now.parts.back(), "Type", "flange");
  }
};

TEST(CompareGroups, NothingChangedIsNoGroup) {
  EXPECT_TRUE(Plants().grouped().all.empty());
}

TEST(CompareGroups, AModelThatMovedIsOneGroup) {
  Plants p;
  p.after.set_transform(p.now.top, core::translation({1, 0, 0}));
  const Groups groups = p.grouped();
  EXPECT_EQ(lines(p, groups), Lines{"moved / 30/30"});
  EXPECT_NEAR(glm::length(groups.all[0].offset - dvec3(1, 0, 0)), 0.0, 1e-9);
  EXPECT_EQ(groups.all[0].turn, 0.0);
  EXPECT_NEAR(groups.all[0].box.min.x, 0.5, 1e-6);
  EXPECT_NEAR(groups.all[0].box.max.x, 46.5, 1e-6);
}

TEST(CompareGroups, ALineThatTurnedIsOneGroupWithItsAxis) {
  Plants p;
  const double angle = 0.3;
  const core::dmat3 spin{{std::cos(angle), std::sin(angle), 0}, {-std::sin(angle), std::cos(angle), 0}, {0, 0, 1}};
  p.after.set_transform(p.now.lines[1], {spin, {0, 0, 2}});
  const Groups groups = p.grouped();
  ASSERT_EQ(lines(p, groups), Lines{"moved /plant/line-1 10/10"});
  EXPECT_NEAR(groups.all[0].turn, angle, 1e-6);
  EXPECT_NEAR(glm::length(groups.all[0].axis - dvec3(0, 0, 1)), 0.0, 1e-6);
  EXPECT_NEAR(groups.all[0].offset.z, 2.0, 1e-6);
}

TEST(CompareGroups, DisplacementsWithinTheToleranceAreOneGroup) {
  Plants p;
  p.after.set_transform(p.now.lines[0], core::translation({1, 0, 0}));
  p.after.set_transform(p.now.lines[1], core::translation({1, 0, 0.00005}));
  p.after.set_transform(p.now.lines[2], core::translation({1, 0, -0.00005}));
  EXPECT_EQ(lines(p, p.grouped()), Lines{"moved / 30/30"});
  p.after.set_transform(p.now.lines[2], core::translation({1.01, 0, 0}));
  EXPECT_EQ(p.grouped().all.size(), 3u);
}

TEST(CompareGroups, DisplacementsInTurnAreStillTwoGroups) {
  Pair p;
  for (int i = 0; i < 12; ++i) {
    const dvec3 at(10.0 * i, 0, 0), offset(i % 2 ? dvec3(1, 0, i % 4 == 1 ? 5e-5 : -5e-5) : dvec3(0, 2, 0));
    p.before.add_primitive(p.before.root(), core::Box{1, 2, 1 + 0.1f * float(i)}, core::translation(at));
    p.after.add_primitive(p.after.root(), core::Box{1, 2, 1 + 0.1f * float(i)}, core::translation(at + offset));
  }
  EXPECT_EQ(lines(p, p.grouped()), (Lines{"moved / 6/12", "moved / 6/12"}));
}

TEST(CompareGroups, AnItemThatChangedInTwoWaysIsInTwoGroups) {
  Plants p;
  p.begin_attributes();
  p.after.set_transform(p.now.lines[0], core::translation({0, 0, 1}));
  p.after.set_material(p.now.items[3], p.after.add_material({"red", {1, 0, 0}, 1, 0}));
  p.after.set_attribute(p.now.parts[3], "Spec", "B");
  EXPECT_EQ(lines(p, p.grouped()), (Lines{"moved /plant/line-0 10/10", "changed /plant/line-0/part-3 1/1",
                                          "changed /plant/line-0/part-3 1/1"}));
}

TEST(CompareGroups, OneExceptionInTenLeavesTheGroupWhole) {
  Plants p;
  p.after.set_transform(p.now.lines[0], core::translation({0, 0, 1}));
  p.after.set_placement(p.now.items[0], core::translation({0, 0, -1}));
  EXPECT_EQ(lines(p, p.grouped()), Lines{"moved /plant/line-0 9/10"});
  p.after.set_name(p.now.parts[0], "other");  // so that the line has moved with a part of another name
  EXPECT_EQ(lines(p, p.grouped()), (Lines{"moved /plant/line-0 9/10", "renamed /plant/line-0/other 1/1"}));
}

TEST(CompareGroups, AFewPartsOfALineAreAGroupOfTheLine) {
  Plants p;
  const auto remove = [&](int part) { p.after.remove_node(p.now.parts[std::size_t(part)]); };
  remove(3);
  EXPECT_EQ(lines(p, p.grouped()), Lines{"removed /plant/line-0/part-3 1/1"});
  for (const int part : {5, 7, 11}) remove(part);
  EXPECT_EQ(lines(p, p.grouped()), (Lines{"removed /plant/line-0 3/10", "removed /plant/line-1/part-1 1/1"}));
}

TEST(CompareGroups, WhatCannotHaveMovedIsNoException) {
  Plants p;
  p.after.set_transform(p.now.lines[0], core::translation({0, 0, 1}));
  p.after.add_primitive(p.now.lines[0], core::Sphere{1}, core::translation({0, 0, 50}));
  p.after.add_primitive(p.now.lines[0], core::Sphere{1}, core::translation({0, 0, 60}));
  p.before.remove_item(p.old.items[0]);
  p.before.add_primitive(p.old.parts[0], core::Box{1, 1, 1}, core::translation({0, 0, 0}));
  EXPECT_EQ(lines(p, p.grouped()),
            (Lines{"moved /plant/line-0 9/9", "added /plant/line-0 2/2", "changed /plant/line-0/part-0 1/1"}));
}

TEST(CompareGroups, WhatIsGoneIsGroupedInTheEarlierRevision) {
  Plants p;
  p.after.remove_node(p.now.lines[1]);
  p.before.remove_node(p.old.lines[2]);
  EXPECT_EQ(lines(p, p.grouped()), (Lines{"added /plant/line-2 10/10", "removed /plant/line-1 10/10"}));
}

TEST(CompareGroups, ANodeThatWasRenamedIsOneGroup) {
  Plants p;
  p.after.set_name(p.now.lines[1], "line-1-B");
  EXPECT_EQ(lines(p, p.grouped()), Lines{"renamed /plant/line-1-B 10/10"});
}

TEST(CompareGroups, AttributesAreGroupedByTheirNames) {
  Plants p;
  p.begin_attributes();
  for (int i = 0; i < 10; ++i) p.after.set_attribute(p.now.parts[std::size_t(i)], "Revision", std::to_string(i));
  for (int i = 10; i < 20; ++i) p.after.set_attribute(p.now.parts[std::size_t(i)], "Spec", "A");
  for (const NodeId line : p.now.lines) p.after.set_attribute(line, "Checked", "yes");
  p.after.set_attribute(p.now.top, "Checked", "yes");
  EXPECT_EQ(lines(p, p.grouped()),
            (Lines{"changed /plant/line-1 10/10", "changed /plant/line-0 10/10", "changed /plant 4/4"}));
}

TEST(CompareGroups, ManyLevelsTakeNoQuadraticTime) {
  Pair p;
  NodeId old = p.before.root(), now = p.after.root();
  constexpr int kLevels = 200'000;
  for (int i = 0; i < kLevels; ++i) {
    old = p.before.add_node(old, "n"), now = p.after.add_node(now, "n");
    p.before.add_primitive(old, core::Sphere{1}, core::translation({0, 0, 10.0 * i}));
    p.after.add_primitive(now, core::Sphere{1}, core::translation({i % 2, 0, 10.0 * i}));
  }
  EXPECT_EQ(p.grouped().all.size(), std::size_t(kLevels / 2));
}

}  // namespace
}  // namespace sightline::tests::compare_groups_test
