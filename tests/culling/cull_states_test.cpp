// What culling makes of every item, against boxes tested one by one against planes in long double, and against the
// cullers.
#include "sightline/culling/cull_states.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "sightline/culling/frustum/linear_culler.h"
#include "sightline/tests/culling/scenes.h"

namespace sightline::tests::cull_states_test {
namespace {

using culling::CullState;
using culling::CullStates;

/// The obvious way: every plane against all corners. Within rounding of a plane a box may be either.
class Twin {
 public:
  enum class Side { kIn, kOut, kAcross, kNear };
  explicit Twin(const core::View& view) : view_(view) {}

  Side side(const core::Plane& plane, const core::dvec3& origin, const core::Aabb& box) const {
    long double least = 0, most = 0, size = std::abs((long double)plane.offset);
    for (int corner = 0; corner < 8; ++corner) {
      long double value = plane.offset;
      for (int i = 0; i < 3; ++i) {
        const long double at = (long double)origin[i] + (corner >> i & 1 ? box.max[i] : box.min[i]);
        value += plane.normal[i] * at;
        size += std::abs(plane.normal[i] * at) + std::abs(plane.normal[i] * (long double)origin[i]);
      }
      least = corner == 0 ? value : std::min(least, value);
      most = corner == 0 ? value : std::max(most, value);
    }
    const long double doubt = kDoubt * size;
    if (most < -doubt) return Side::kOut;
    if (least > doubt) return Side::kIn;
    return most < doubt || least > -doubt ? Side::kNear : Side::kAcross;
  }

  /// States that a box may have, a bit for each.
  unsigned allowed(const core::dvec3& origin, const core::Aabb& box) const {
    constexpr unsigned kIn = 1u << int(CullState::kInside), kAcross = 1u << int(CullState::kIntersecting),
                       kOut = 1u << int(CullState::kOutside);
    bool out = false, across = false, in_doubt = false;
    const auto add = [&](Side side) {
      out |= side == Side::kOut;
      across |= side == Side::kAcross;
      in_doubt |= side == Side::kNear;
    };
    for (const core::Plane& plane : core::frustum_planes(view_.clip_from_world(), view_.clip_depth()))
      if (plane.normal != core::dvec3(0.0)) add(side(plane, origin, box));
    std::vector<Side> sections;
    for (const core::Plane& plane : view_.sections)
      if (plane.normal != core::dvec3(0.0)) sections.push_back(side(plane, origin, box));
    const auto all = [&](Side s) {
      return std::all_of(sections.begin(), sections.end(), [s](Side x) { return x == s; });
    };
    const auto any = [&](Side s) {
      return std::any_of(sections.begin(), sections.end(), [s](Side x) { return x == s; });
    };
    if (view_.section_mode == core::SectionMode::kIntersection)
      std::for_each(sections.begin(), sections.end(), add);
    else if (!sections.empty())
      add(any(Side::kIn) ? Side::kIn : all(Side::kOut) ? Side::kOut : any(Side::kNear) ? Side::kNear : Side::kAcross);
    if (out) return kOut;
    if (in_doubt) return kIn | kAcross | kOut;
    return across ? kAcross : kIn;
  }

 private:
  static constexpr long double kDoubt = 1e-5L;
  const core::View& view_;
};

/// All that the header promises.
void expect_right(const core::View& view, const Scene& scene, const CullStates& states, culling::SlotBits small = {},
                  culling::SlotBits occluded = {}) {
  const Twin twin(view);
  core::VisibleSet visible;
  culling::LinearCuller(scene.bounds).cull(view, visible);
  std::vector<bool> kept(scene.bounds.size());
  for (const core::Slot slot : scene.occupied(visible)) kept[slot] = true;
  std::array<std::int64_t, culling::kCullStateCount> items{};
  ASSERT_EQ(states.of_slot.size(), scene.bounds.size());
  for (core::Slot slot = 0; slot < scene.bounds.size(); ++slot) {
    const CullState state = states.of_slot[slot];
    if (scene.bounds.vacant(slot)) {
      EXPECT_EQ(state, CullState::kOutside);
      continue;
    }
    ++items[std::size_t(state)];
    ASSERT_EQ(state != CullState::kOutside, bool(kept[slot])) << "slot " << slot << " " << name_of(state);
    if (!kept[slot]) continue;
    if (culling::contains(small, slot)) {
      ASSERT_EQ(state, CullState::kTooSmall);
    } else if (culling::contains(occluded, slot)) {
      ASSERT_EQ(state, CullState::kOccluded);
    } else {
      ASSERT_TRUE(twin.allowed(scene.bounds.origin, scene.bounds.box(slot)) >> int(state) & 1u)
          << "slot " << slot << " " << name_of(state);
    }
  }
  EXPECT_EQ(items, states.items);

  // Each item is in one box of its state.
  std::array<std::int64_t, culling::kCullStateCount> boxed{};
  for (const culling::CullBox& box : states.boxes) {
    EXPECT_GT(box.items, 0u);
    boxed[std::size_t(box.state)] += box.items;
  }
  EXPECT_EQ(boxed, items);
}

core::View some_view(Random& random, const core::dvec3& origin, double half) {
  core::View view = random_view(random, origin, half);
  if (chance(random, 0.4)) add_sections(random, origin, half, view);
  if (chance(random, 0.2)) view.layers = core::kLayerInsulation | (chance(random, 0.5) ? core::kLayerModel : 0u);
  return view;
}

TEST(CullStates, AreThoseOfBoxesTestedOneByOne) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const double half = magnitude(random, 1.0, 1e4);
    const core::dvec3 origin = chance(random, 0.5) ? core::dvec3(0.0) : point(random, 1e6);
    auto boxes = random_boxes(random, std::size_t(whole(random, 0, 5000)), half);
    for (core::Aabb& box : boxes)
      if (chance(random, 0.02)) box = {};
    Scene scene(boxes, origin);
    if (chance(random, 0.5)) {
      for (core::Slot slot = 0; slot < scene.bounds.size(); ++slot)
        if (slot / 700 % 2 == 0 || chance(random, 0.1))
          scene.bounds.set_layers(slot, chance(random, 0.5) ? core::kLayerInsulation : 5u);
      scene.culler->refit();
    }
    for (int i = 0; i < 8; ++i) {
      const core::View view = some_view(random, origin, half);
      ASSERT_NO_FATAL_FAILURE(expect_right(view, scene, cull_states(view, scene.bounds, scene.culler->hierarchy())));
      std::vector<std::uint64_t> small(culling::bit_words(scene.bounds.size())), occluded(small);
      for (core::Slot slot = 0; slot < scene.bounds.size(); ++slot) {  // in runs, so that whole nodes are of one state
        const std::uint32_t run = slot / 100 % 4;
        if (run == 1 || chance(random, 0.02)) small[slot / 64] |= std::uint64_t(1) << slot % 64;
        if (run == 2 || chance(random, 0.02)) occluded[slot / 64] |= std::uint64_t(1) << slot % 64;
      }
      ASSERT_NO_FATAL_FAILURE(expect_right(
          view, scene, cull_states(view, scene.bounds, scene.culler->hierarchy(), small, occluded), small, occluded));
    }
  }
}

/// Boxes of denormal size, of 1e38 m, infinite and inverted ones: what the twin cannot tell, the culler can.
TEST(CullStates, OfBoxesThatNoPlantHas) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    auto boxes = random_boxes(random, 2000, 10.0);
    spoil(random, boxes);
    const Scene scene(boxes, core::dvec3(0.0));
    const core::View view = some_view(random, core::dvec3(0.0), 10.0);
    core::VisibleSet visible;
    scene.culler->cull(view, visible);
    const auto kept = scene.occupied(visible);
    const CullStates states = cull_states(view, scene.bounds, scene.culler->hierarchy());
    std::vector<core::Slot> not_outside;
    for (core::Slot slot = 0; slot < scene.bounds.size(); ++slot)
      if (states.of_slot[slot] != CullState::kOutside) not_outside.push_back(slot);
    EXPECT_EQ(not_outside, kept);
  }
}

TEST(CullStates, NothingAndEverything) {
  Random random(3);
  const auto boxes = random_boxes(random, 40'000, 10.0);
  const Scene scene(boxes, core::dvec3(0.0));
  const auto& hierarchy = scene.culler->hierarchy();
  const auto states_of = [&](const core::View& view) { return cull_states(view, scene.bounds, hierarchy); };
  const auto items = [](const CullStates& states, CullState state) { return states.items[std::size_t(state)]; };
  const auto around = core::View::orthographic({{0, -500, 0}, {0, 0, 0}, {0, 0, 1}}, 2000.0, 1.0, 0.0, 1000.0);
  const CullStates all = states_of(*around);
  EXPECT_EQ(items(all, CullState::kInside), 40'000);
  EXPECT_LE(all.boxes.size(), std::size_t(culling::kLanes)) << "the root's children";
  core::View away = *around;
  away.sections = {{{0, 0, 1}, -1000.0}};
  const CullStates none = states_of(away);
  EXPECT_EQ(items(none, CullState::kOutside), 40'000);
  EXPECT_LE(none.boxes.size(), std::size_t(culling::kLanes));
  core::View no_layer = *around;
  no_layer.layers = core::kLayerObstruction;
  EXPECT_EQ(items(states_of(no_layer), CullState::kOutside), 40'000);
  EXPECT_LE(states_of(no_layer).boxes.size(), std::size_t(culling::kLanes));

  // From within a box, which is the only one.
  const Scene one(std::vector<core::Aabb>{{core::vec3(-5.0f), core::vec3(5.0f)}}, core::dvec3(0.0));
  const auto within = core::View::perspective({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1);
  const CullStates inside_it = cull_states(*within, one.bounds, one.culler->hierarchy());
  EXPECT_EQ(items(inside_it, CullState::kIntersecting), 1);

  const CullStates empty = cull_states(*within, core::ItemBounds(), culling::Hierarchy());
  EXPECT_TRUE(empty.boxes.empty() && empty.of_slot.empty());
}

/// What is left out together is one box.
TEST(CullStates, WholeNodesThatAreLeftOutAreOneBox) {
  Random random(4);
  const auto boxes = random_boxes(random, 32 * 16 * 4, 10.0);
  const Scene scene(boxes, core::dvec3(0.0));
  const auto view = core::View::orthographic({{0, -500, 0}, {0, 0, 0}, {0, 0, 1}}, 2000.0, 1.0, 0.0, 1000.0);
  std::vector<std::uint64_t> occluded(culling::bit_words(boxes.size()));
  for (core::Slot slot = 0; slot < 32 * 16 + 32 + 2; ++slot) occluded[slot / 64] |= std::uint64_t(1) << slot % 64;
  const CullStates states = cull_states(*view, scene.bounds, scene.culler->hierarchy(), {}, occluded);
  std::vector<std::uint32_t> sizes;
  for (const culling::CullBox& box : states.boxes)
    if (box.state == CullState::kOccluded) sizes.push_back(box.items);
  EXPECT_EQ(sizes, (std::vector<std::uint32_t>{32 * 16, 32, 1, 1}));
}

}  // namespace
}  // namespace sightline::tests::cull_states_test
