// Which ends are found to lie on a neighbour's, against all pairs compared, and what edits leave of that.
#include "sightline/gpuprims/internal/joints.h"

#include <cmath>
#include <numbers>
#include <set>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include "sightline/core/internal/snapshot_copies.h"
#include "sightline/tests/core/primitive_samples.h"

namespace sightline::gpuprims::joints_test {
namespace {

using namespace core;

using tests::Random;
using tests::uniform;

constexpr double kPi = std::numbers::pi;

dmat3 turned(double angle, const dvec3& axis) {
  return dmat3(glm::rotate(core::dmat4(1.0), angle, glm::normalize(axis)));
}

/// A snapshot with its joints, which follow edits as in the engine.
struct Joined {
  Snapshot snapshot;
  Joints joints{snapshot};

  /// The slots that the scene's edits touch.
  std::vector<Slot> commit(Scene& scene) {
    const auto delta = scene.commit();
    EXPECT_TRUE(delta);
    const std::size_t former_size = snapshot.size();
    std::vector<Slot> touched = snapshot.apply(*delta);
    joints.dissolve(snapshot, {delta->removed, delta->changed, delta->inserted}, former_size, touched);
    if (!delta->materials.empty()) joints.dissolve_transparent(snapshot, former_size, touched);
    return touched;
  }
};

/// A scene to which solids are added one by one, item 0 first.
class Solids {
 public:
  Scene scene;

  ItemId add(const Primitive& primitive, const Affine& world_from_item = {}, MaterialId material = {}) {
    return scene.add_primitive(scene.root(), primitive, world_from_item, material);
  }
  Joined joined() {
    EXPECT_TRUE(scene.commit());
    return Joined{Snapshot(scene)};
  }
  int covered(ItemId item) { return joined().joints.covered(item); }
};

std::size_t count_of(const Scene& scene) {
  return Joints(Snapshot(scene)).count();
}

/// Ends that a unit cylinder on [0, 1] of the z axis and another solid cover of each other: own << 2 | the other's.
int ends_with(const Primitive& other, const Affine& placed) {
  Solids solids;
  const ItemId own = solids.add(Cylinder{1.0f, 1.0f}, translation({0, 0, 0.5}));
  const ItemId item = solids.add(other, placed);
  const Joints joints = solids.joined().joints;
  const int a = joints.covered(own), b = joints.covered(item);
  EXPECT_EQ(joints.count(), std::size_t((a & 1) + (a >> 1) + (b & 1) + (b >> 1)));
  return a << 2 | b;
}
constexpr int kOwnTop = kTopEnd << 2;

TEST(Joints, EqualEndsCoverEachOther) {
  EXPECT_EQ(ends_with(Cylinder{1.0f, 2.0f}, translation({0, 0, 2.0})), kOwnTop | kBottomEnd);
  EXPECT_EQ(ends_with(Cylinder{1.0f, 2.0f}, {turned(kPi, {1, 0, 0}), {0, 0, 2.0}}), kOwnTop | kTopEnd);
  EXPECT_EQ(ends_with(Cylinder{1.0f, 2.0f}, {dmat3({1, 0, 0}, {0, 1, 0}, {0, 0, -1}), {0, 0, 2.0}}), kOwnTop | kTopEnd);
  EXPECT_EQ(ends_with(Cylinder{1000.0f, 2000.0f}, {dmat3(1e-3), {0, 0, 2.0}}), kOwnTop | kBottomEnd);
  EXPECT_EQ(ends_with(Snout{1.0f, 0.5f, 1.0f, 0.3f, 0, 0, 0, 0, 0}, translation({0.15, 0, 1.5})), kOwnTop | kBottomEnd);
  EXPECT_EQ(ends_with(EllipticalDish{1.0f, 0.5f}, translation({0, 0, 1})), kOwnTop | kBottomEnd);
  EXPECT_EQ(ends_with(SphericalDish{1.0f, 0.5f}, translation({0, 0, 1})), kOwnTop | kBottomEnd);
  // The sweep begins in the plane y = 0, towards +y: upwards once turned about x.
  const CircularTorus elbow{3.0f, 1.0f, float(0.5 * kPi)};
  const dmat3 up = turned(0.5 * kPi, {1, 0, 0});
  EXPECT_EQ(ends_with(elbow, {up, {-3, 0, 1}}), kOwnTop | kBottomEnd);
  const dmat3 from_its_end = up * turned(0.5 * kPi, {0, 0, 1}) * turned(kPi, {1, 0, 0});
  EXPECT_EQ(ends_with(elbow, {from_its_end, {-3, 0, 1}}) & ~kOwnTop, kTopEnd);
}

TEST(Joints, ClosedToriHaveNoEnds) {
  const float nearly_full = 6.283185f;  // a float below 2 pi
  const auto has_ends = [](float major, float tube, float angle) {
    const Primitive torus = CircularTorus{major, tube, angle};
    const bool bottom = end_face(torus, {}, kBottomEnd).has_value(), top = end_face(torus, {}, kTopEnd).has_value();
    EXPECT_EQ(bottom, top);
    return bottom;
  };
  for (const float angle : {nearly_full, -nearly_full, float(2.0 * kPi), 7.0f, 0.0f})
    EXPECT_FALSE(has_ends(3.0f, 1.0f, angle)) << angle;
  for (const float angle : {std::nextafter(nearly_full, 0.0f), 1e-3f, -1.0f})
    EXPECT_TRUE(has_ends(3.0f, 1.0f, angle)) << angle;
  EXPECT_TRUE(has_ends(1.0f, 1.0f, 1.0f)) << "a horn's";
  EXPECT_FALSE(has_ends(std::nextafter(1.0f, 0.0f), 1.0f, 1.0f)) << "a spindle's is no disc";
}

TEST(Joints, OfEndsOfDifferentSizeTheSmallerOneIsCovered) {
  EXPECT_EQ(ends_with(Cylinder{2.0f, 1.0f}, translation({0, 0, 1.5})), kOwnTop);
  EXPECT_EQ(ends_with(Cylinder{0.5f, 1.0f}, translation({0, 0, 1.5})), kBottomEnd);
  EXPECT_EQ(ends_with(Cylinder{1.001f, 1.0f}, translation({0, 0, 1.5})), kOwnTop);
}

TEST(Joints, WhatDoesNotMeetIsNotFound) {
  EXPECT_EQ(ends_with(Cylinder{1.0f, 2.0f}, translation({0, 0, 2.0 + 3.0 * kJointGap})), 0);
  EXPECT_EQ(ends_with(Cylinder{1.0f, 2.0f}, translation({0, 0, 2.0 - 3.0 * kJointGap})), 0);
  EXPECT_EQ(ends_with(Cylinder{1.0f, 2.0f}, translation({3.0 * kJointExcess, 0, 2.0})), 0);
  EXPECT_EQ(ends_with(Cylinder{1.0f, 2.0f}, {turned(3.0 * kJointGap, {1, 0, 0}), {0, 0, 2.0}}), 0);
  EXPECT_EQ(ends_with(Cylinder{1.0f, 2.0f}, translation({0, 0, 0})), 0) << "same normals";
  EXPECT_EQ(ends_with(Cylinder{1.0f, 0.0f}, translation({0, 0, 1})), 0) << "no volume";
  EXPECT_EQ(ends_with(Sphere{2.0f}, translation({0, 0, 2})), 0);
  EXPECT_EQ(ends_with(Box{4, 4, 2}, translation({0, 0, 2})), 0);
  EXPECT_EQ(ends_with(Cylinder{1.0f, 2.0f}, {dmat3({1, 0, 0}, {0, 1.2, 0}, {0, 0, 1}), {0, 0, 2.0}}), kOwnTop)
      << "an ellipse around the circle";
  EXPECT_EQ(ends_with(Cylinder{1.0f, 2.0f}, {dmat3({0.8, 0, 0}, {0, 1.2, 0}, {0, 0, 1}), {0, 0, 2.0}}), 0)
      << "ellipse and circle, neither within the other";
  EXPECT_EQ(ends_with(Cylinder{1.0f, 2.0f}, {dmat3({1, 0, 0}, {0, 1, 0}, {0.5, 0.2, 1}), {0.5, 0.2, 2.0}}),
            kOwnTop | kBottomEnd)
      << "leans, on the same circle";
}

TEST(Joints, WithinToleranceIsFound) {
  EXPECT_EQ(ends_with(Cylinder{1.0f, 2.0f}, translation({0, 0, 2.0 + 0.8 * kJointGap})), kOwnTop | kBottomEnd);
  EXPECT_EQ(ends_with(Cylinder{1.0f, 2.0f}, translation({0.8 * kJointExcess, 0, 2.0})), kOwnTop | kBottomEnd);
  EXPECT_EQ(ends_with(Cylinder{1.0f, 2.0f}, {turned(0.4 * kJointGap, {1, 0, 0}), {0, 0, 2.0}}) & kOwnTop, kOwnTop);
}

TEST(Joints, SlantedEndsMeet) {
  // A cone cut at a slant, and its mirror image in the plane of the cut.
  for (const float top_radius : {1.0f, 0.7f, 1.3f}) {
    SCOPED_TRACE(top_radius);
    const Snout cut{1.0f, top_radius, 2.0f, 0.1f, 0.2f, 0, 0, 0.4f, -0.2f};
    const dvec3 normal = glm::normalize(dvec3(-std::tan(0.4), -std::tan(-0.2), 1.0)), centre(0.05, 0.1, 1.0);
    dmat3 mirror(1.0);
    for (int i = 0; i < 3; ++i) mirror[i] -= 2.0 * normal[i] * normal;
    Solids solids;
    solids.add(cut);
    solids.add(cut, {mirror, centre - mirror * centre});
    EXPECT_EQ(solids.covered(core::ItemId{0}), kTopEnd);
    EXPECT_EQ(solids.covered(core::ItemId{1}), kTopEnd);
    // Turned about the normal the ellipses differ.
    Solids others;
    others.add(cut);
    const dmat3 twisted = turned(1.0, normal) * mirror;
    others.add(cut, {twisted, centre - twisted * centre});
    EXPECT_EQ(others.covered(core::ItemId{0}), kNoEnd);
  }
}

TEST(Joints, TheContourOfASlantedEndLiesOnConeAndPlane) {
  Random random{5};
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE(i);
    const auto f = [&](double low, double high) { return float(uniform(random, low, high)); };
    const Snout s{f(0.1, 1),    f(0.1, 1),    f(0.5, 3),    f(-0.5, 0.5), f(-0.5, 0.5),
                  f(-0.5, 0.5), f(-0.5, 0.5), f(-0.5, 0.5), f(-0.5, 0.5)};
    for (const Ends end : {kBottomEnd, kTopEnd}) {
      const auto face = end_face(s, {}, end);
      if (!face) continue;
      const double side = end == kTopEnd ? 0.5 : -0.5;
      const dvec3 middle = side * dvec3(s.offset_x, s.offset_y, s.height);
      const double mx = std::tan(double(end == kTopEnd ? s.top_shear_x : s.bottom_shear_x)),
                   my = std::tan(double(end == kTopEnd ? s.top_shear_y : s.bottom_shear_y));
      EXPECT_GT(side * glm::cross(face->u, face->v).z, 0.0);
      for (double a = 0.1; a < 6.3; a += 0.7) {
        const dvec3 p = face->centre + std::cos(a) * face->u + std::sin(a) * face->v;
        EXPECT_NEAR(p.z - middle.z, mx * (p.x - middle.x) + my * (p.y - middle.y), 1e-12);
        const double part = p.z / s.height, radius = 0.5 * (double(s.bottom_radius) + s.top_radius) +
                                                     part * (double(s.top_radius) - s.bottom_radius);
        EXPECT_NEAR(std::hypot(p.x - part * s.offset_x, p.y - part * s.offset_y), radius, 1e-12);
      }
    }
  }
}

TEST(Joints, OnlyOfVisibleOpaqueItemsInTheSameLayers) {
  const auto joined = [](auto&& change) {
    Solids solids;
    Material glass;
    glass.alpha = 0.5f;
    const MaterialId paint = solids.scene.add_material({}), see_through = solids.scene.add_material(glass);
    const NodeId node = solids.scene.add_node(solids.scene.root());
    solids.add(Cylinder{1.0f, 1.0f}, translation({0, 0, 0.5}), paint);
    const ItemId other = solids.scene.add_primitive(node, Cylinder{1.0f, 1.0f}, translation({0, 0, 1.5}));
    change(solids.scene, node, other, see_through);
    return solids.covered(core::ItemId{0}) != kNoEnd;
  };
  EXPECT_TRUE(joined([](auto&&...) {}));
  EXPECT_FALSE(joined([](Scene& s, NodeId, ItemId item, MaterialId glass) { s.set_material(item, glass); }));
  EXPECT_FALSE(joined([](Scene& s, NodeId node, ItemId, MaterialId glass) { s.set_material(node, glass); }));
  EXPECT_FALSE(joined([](Scene& s, NodeId, ItemId item, MaterialId) { s.set_visible(item, false); }));
  EXPECT_FALSE(joined([](Scene& s, NodeId node, ItemId, MaterialId) { s.set_layers(node, kLayerInsulation); }));
}

// --- pipe runs
// --------------------------------------------------------------------------------------------------------

/// Pipes, elbows, reducers, flanges and dishes end to end, some a little off, over `site` metres.
void add_runs(Scene& scene, Random& random, int runs, double site) {
  const auto f = [&](double low, double high) { return float(uniform(random, low, high)); };
  for (int run = 0; run < runs; ++run) {
    Affine at{turned(uniform(random, 0.0, 6.0), {uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0), 0.3}),
              {uniform(random, -site, site), uniform(random, -site, site), uniform(random, -site, site)}};
    float radius = f(0.02, 0.6);
    for (int i = 0; i < 12; ++i) {
      const double off = random() % 3 == 0 ? std::pow(10.0, uniform(random, -6.0, -2.0)) * double(radius) : 0.0;
      at.origin += off * dvec3(uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0));
      const auto onwards = [&](double length) { at = at * translation({0, 0, length}); };
      switch (random() % 6) {
        case 0: {  // an elbow
          const float major = radius * f(1.5, 3), angle = f(0.2, 3);
          const Affine start{turned(0.5 * kPi, {1, 0, 0}), {-major, 0, 0}};
          scene.add_primitive(scene.root(), CircularTorus{major, radius, angle}, at * start);
          at = at * Affine{dmat3(1.0), {-major, 0, 0}} * Affine{turned(-double(angle), {0, 1, 0}), dvec3(0.0)} *
               Affine{dmat3(1.0), {major, 0, 0}};
          break;
        }
        case 1: {  // a reducer
          const float to = radius * f(0.5, 1.5), height = f(0.1, 1), x = f(-0.1, 0.1);
          scene.add_primitive(scene.root(), Snout{radius, to, height, x, 0, 0, 0, 0, 0},
                              at * translation({0.5 * x, 0, 0.5 * height}));
          at = at * translation({x, 0, height});
          radius = to;
          break;
        }
        case 2: {  // a flange
          const float height = 0.2f * radius;
          scene.add_primitive(scene.root(), Cylinder{1.5f * radius, height}, at * translation({0, 0, 0.5 * height}));
          onwards(height);
          break;
        }
        case 3:
          scene.add_primitive(scene.root(), EllipticalDish{radius, radius}, at);
          break;
        default: {
          const float height = f(0.1, 3);
          scene.add_primitive(scene.root(), Cylinder{radius, height}, at * translation({0, 0, 0.5 * height}));
          onwards(height);
        }
      }
    }
  }
}

TEST(Joints, AsAllPairsCompared) {
  std::size_t found = 0;
  for (int seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    Random random{std::uint64_t(seed)};
    Solids solids;
    add_runs(solids.scene, random, 15, seed % 3 == 0 ? 1000.0 : 5.0);
    const Joined joined = solids.joined();
    const Snapshot& snapshot = joined.snapshot;
    for (Slot a = 0; a < snapshot.size(); ++a) {
      int expected = 0;
      for (const Ends end : {kBottomEnd, kTopEnd}) {
        const auto face = end_face(snapshot.primitive(a), snapshot.world_from_item(a), end);
        for (Slot b = 0; face && b < snapshot.size(); ++b)
          for (const Ends other_end : {kBottomEnd, kTopEnd})
            if (const auto other = end_face(snapshot.primitive(b), snapshot.world_from_item(b), other_end))
              if (a != b && covers(*other, *face)) expected |= end;
      }
      ASSERT_EQ(int(joined.joints.covered(snapshot.item(a))), expected);
      found += std::size_t((expected & 1) + (expected >> 1));
    }
  }
  EXPECT_GT(found, 3000u);
}

TEST(Joints, HeapsInOnePlaceTakeNoTime) {
  Solids solids;
  for (int i = 0; i < 20000; ++i) solids.add(Cylinder{1.0f, 1.0f}, translation({0, 0, double(i % 2)}));
  EXPECT_GT(solids.joined().joints.count(), 0u);
}

TEST(Joints, CostNothingWhereThereAreNone) {
  Solids solids;
  solids.add(Cylinder{1.0f, 1.0f});
  solids.add(Cylinder{1.0f, 1.0f}, translation({0, 0, 1}));
  EXPECT_EQ(solids.joined().joints.count(), 2u);
  EXPECT_GT(solids.joined().joints.memory_bytes(), 0u);
  Solids apart;
  apart.add(Cylinder{1.0f, 1.0f});
  apart.add(Cylinder{1.0f, 1.0f}, translation({0, 0, 2}));
  EXPECT_EQ(apart.joined().joints.memory_bytes(), 0u);
}

// --- edits -----------------------------------------------------------------------------------------------------------

TEST(Joints, EditsDissolveThoseOfTheItemAndItsNeighbours) {
  const auto check = [](const char* what, auto&& edit) {
    SCOPED_TRACE(what);
    Solids solids;
    Scene& scene = solids.scene;
    const MaterialId paint = scene.add_material({});
    for (int i = 0; i < 5; ++i) solids.add(Cylinder{1.0f, 1.0f}, translation({0, 0, double(i)}));
    Joined joined = solids.joined();
    const Snapshot& snapshot = joined.snapshot;
    const Joints& joints = joined.joints;
    ASSERT_EQ(joints.count(), 8u);
    edit(scene, paint);
    const std::vector<Slot> touched = joined.commit(scene);
    EXPECT_EQ(joints.covered(core::ItemId{2}), kNoEnd);
    EXPECT_EQ(joints.covered(core::ItemId{1}), kBottomEnd);
    EXPECT_EQ(joints.covered(core::ItemId{3}), kTopEnd);
    EXPECT_EQ(joints.covered(core::ItemId{0}), kTopEnd);
    EXPECT_EQ(joints.covered(core::ItemId{4}), kBottomEnd);
    EXPECT_EQ(joints.count(), 4u);
    const std::set<Slot> set(touched.begin(), touched.end());
    EXPECT_EQ(set.size(), touched.size()) << "each once";
    EXPECT_TRUE(set.contains(snapshot.slot(core::ItemId{1})) && set.contains(snapshot.slot(core::ItemId{3})));
    EXPECT_FALSE(set.contains(snapshot.slot(core::ItemId{0})) || set.contains(snapshot.slot(core::ItemId{4})));
    // A new scene version finds what there is now.
    core::ItemCopies items;
    core::copy_items(snapshot, 0, Slot(snapshot.size()), items);
    EXPECT_EQ(Joints(core::reordered(snapshot, std::move(items))).count(), count_of(scene));
  };
  check("moved", [](Scene& s, MaterialId) { s.set_placement(core::ItemId{2}, translation({0.2, 0, 2})); });
  check("moved far", [](Scene& s, MaterialId) { s.set_placement(core::ItemId{2}, translation({900, 0, 2})); });
  check("moved by nothing", [](Scene& s, MaterialId) { s.set_placement(core::ItemId{2}, translation({0, 0, 2})); });
  check("removed", [](Scene& s, MaterialId) { s.remove_item(core::ItemId{2}); });
  check("hidden", [](Scene& s, MaterialId) { s.set_visible(ItemId(2), false); });
  check("painted", [](Scene& s, MaterialId paint) { s.set_material(ItemId(2), paint); });
}

/// Only what the glass meets, and nothing when colours change.
TEST(Joints, DissolveWhereAMaterialTurnsClear) {
  Solids solids;
  const MaterialId steel = solids.scene.add_material({}), pane = solids.scene.add_material({});
  for (int i = 0; i < 6; ++i)
    solids.add(Cylinder{1.0f, 1.0f}, translation({0, 0, double(i)}), i == 2 ? pane : i < 2 ? steel : MaterialId{});
  Joined joined = solids.joined();
  const Snapshot& snapshot = joined.snapshot;
  const Joints& joints = joined.joints;
  ASSERT_EQ(joints.count(), 10u);
  solids.scene.update_material(pane, {.name = "red", .colour = {1, 0, 0}});
  EXPECT_TRUE(joined.commit(solids.scene).empty());
  EXPECT_EQ(joints.count(), 10u);
  solids.scene.update_material(pane, {.name = "glass", .alpha = 0.5f});
  std::vector<Slot> touched = joined.commit(solids.scene);
  std::sort(touched.begin(), touched.end());
  std::vector<Slot> expected{snapshot.slot(core::ItemId{1}), snapshot.slot(core::ItemId{2}),
                             snapshot.slot(core::ItemId{3})};
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(touched, expected);
  EXPECT_EQ(joints.count(), 6u);
  EXPECT_EQ(joints.covered(core::ItemId{2}), kNoEnd);
  EXPECT_EQ(joints.covered(core::ItemId{1}), kBottomEnd);
  EXPECT_EQ(joints.covered(core::ItemId{3}), kTopEnd);
  solids.scene.update_material(pane, {.name = "glass", .alpha = 0.4f});
  EXPECT_TRUE(joined.commit(solids.scene).empty()) << "it was clear before";
  solids.scene.update_material(pane, {});
  EXPECT_TRUE(joined.commit(solids.scene).empty()) << "joints are not looked for again";
  EXPECT_EQ(joints.count(), 6u);
}

/// Only slots that existed before are touched, whether their neighbours are gone or appended.
TEST(Joints, NeighboursEditedTogetherTouchFormerSlotsOnly) {
  const auto check = [](const char* what, void (*edit)(Scene&)) {
    SCOPED_TRACE(what);
    Solids solids;
    for (int i = 0; i < 6; ++i) solids.add(Cylinder{1.0f, 1.0f}, translation({0, 0, double(i)}));
    Joined joined = solids.joined();
    const Snapshot& snapshot = joined.snapshot;
    const std::size_t size = snapshot.size();
    std::vector<Slot> expected;
    for (ItemId item{1}; to_index(item) < 5; ++item) expected.push_back(snapshot.slot(item));
    edit(solids.scene);
    std::vector<Slot> touched = joined.commit(solids.scene);
    for (const Slot slot : touched) EXPECT_LT(slot, size);
    std::sort(touched.begin(), touched.end());
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(touched, expected);
  };
  check("removed", [](Scene& s) { s.remove_item(core::ItemId{2}), s.remove_item(core::ItemId{3}); });
  check("moved far", [](Scene& s) {
    s.set_placement(core::ItemId{2}, translation({900, 0, 2}));
    s.set_placement(core::ItemId{3}, translation({900, 0, 3}));
  });
  check("one removed, the other the first that is appended", [](Scene& s) {
    s.remove_item(core::ItemId{2});
    s.set_placement(core::ItemId{3}, translation({900, 0, 3}));
  });
}

/// Slices that are closed, none, or cut themselves have no ends; those that touch their axis do.
TEST(Joints, EndsOfTori) {
  constexpr float kTurn = float(2.0 * kPi);
  const auto has_ends = [](const CircularTorus& torus) {
    const bool bottom = end_face(torus, {}, kBottomEnd).has_value(), top = end_face(torus, {}, kTopEnd).has_value();
    EXPECT_EQ(bottom, top);
    return bottom;
  };
  const auto torus = [](float major, float tube, float angle) { return CircularTorus{major, tube, angle}; };
  for (const float angle : {1e-3f, 1.0f, 6.2f, 6.28f, -1.0f}) EXPECT_TRUE(has_ends(torus(2, 1, angle))) << angle;
  for (const float angle : {0.0f, kTurn, 7.0f, -kTurn}) EXPECT_FALSE(has_ends(torus(2, 1, angle))) << angle;
  EXPECT_TRUE(has_ends(torus(1, 1, 1))) << "touches its axis";
  EXPECT_FALSE(has_ends(torus(1, 1.001f, 1))) << "crosses it";
  EXPECT_TRUE(has_ends(torus(2, -1, 1)) && has_ends(torus(-2, 1, 1))) << "signs mean nothing";
  const auto top = end_face(torus(2, 1, float(kPi / 2)), {}, kTopEnd);
  ASSERT_TRUE(top);
  EXPECT_NEAR(glm::distance(top->centre, dvec3(0, 2, 0)), 0.0, 1e-6);
  EXPECT_NEAR(glm::normalize(glm::cross(top->u, top->v)).x, -1.0, 1e-6);
  const auto bottom = end_face(torus(2, 1, float(kPi / 2)), {}, kBottomEnd);
  EXPECT_NEAR(glm::distance(bottom->centre, dvec3(2, 0, 0)), 0.0, 1e-6);
  EXPECT_NEAR(glm::normalize(glm::cross(bottom->u, bottom->v)).y, -1.0, 1e-6);
}

TEST(Joints, EditedNeighboursAreTouchedOnce) {
  Solids solids;
  for (int i = 0; i < 6; ++i) solids.add(Cylinder{1.0f, 1.0f}, translation({0, 0, double(i)}));
  Joined joined = solids.joined();
  for (ItemId i{1}; to_index(i) < 4; ++i) solids.scene.set_placement(i, translation({0, 0, double(i)}));
  const std::vector<Slot> touched = joined.commit(solids.scene);
  EXPECT_EQ(std::set<Slot>(touched.begin(), touched.end()).size(), touched.size());
  EXPECT_EQ(touched.size(), 5u);
  EXPECT_EQ(joined.joints.count(), 2u);  // between 4 and 5
}

TEST(Joints, AMaterialOfLaterIsKnownToANewVersion) {
  Solids solids;
  solids.add(Cylinder{1.0f, 1.0f});
  solids.add(Cylinder{1.0f, 1.0f}, translation({0, 0, 1}));
  Joined joined = solids.joined();
  Material glass;
  glass.alpha = 0.3f;
  const MaterialId paint = solids.scene.add_material({}), see_through = solids.scene.add_material(glass);
  const auto joints_with = [&](MaterialId material) {
    solids.scene.set_material(ItemId(1), material);
    joined.commit(solids.scene);
    core::ItemCopies items;
    core::copy_items(joined.snapshot, 0, Slot(joined.snapshot.size()), items);
    return Joints(core::reordered(joined.snapshot, std::move(items))).count();
  };
  EXPECT_EQ(joints_with(see_through), 0u);
  EXPECT_EQ(joints_with(paint), 2u);
}

}  // namespace
}  // namespace sightline::gpuprims::joints_test
