// Scenes in parts beside the same in one piece, and boxes beside each of them in turn.
#include "sightline/raytrace/internal/traced_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/image_rays.h"
#include "sightline/raytrace/internal/moving_image.h"
#include "sightline/tests/core/primitive_samples.h"

namespace sightline::raytrace::traced_scene_test {
namespace {

using core::dvec3;
using core::Slot;
using tests::uniform;

constexpr int kWidth = 150, kHeight = 90;

core::ItemBounds random_boxes(tests::Random& random, std::size_t count) {
  core::ItemBounds bounds;
  bounds.origin = {1e5, -2e5, 30.0};
  bounds.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto place = [&] { return float(uniform(random, -10, 10)); };
    const core::vec3 low(place(), place(), place());
    const core::vec3 size(float(uniform(random, 0, 2)), i % 9 == 0 ? 0.0f : float(uniform(random, 0, 2)), 1.0f);
    if (i % 31 != 0) bounds.set(i, {low, low + size});  // others are empty
  }
  return bounds;
}

core::AabbD placed(const core::ItemBounds& bounds, Slot slot) {
  const core::Aabb box = bounds.box(slot);
  return {bounds.origin + dvec3(box.min), bounds.origin + dvec3(box.max)};
}

/// Where a ray from outside enters a box; infinity where it does not.
double entry_of(const core::Ray& ray, const core::AabbD& box) {
  double in = -std::numeric_limits<double>::infinity(), out = -in;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (box.min[axis] - ray.origin[axis]) / ray.direction[axis];
    const double b = (box.max[axis] - ray.origin[axis]) / ray.direction[axis];
    in = std::max(in, std::min(a, b));
    out = std::min(out, std::max(a, b));
  }
  return !box.empty() && in <= out && in >= ray.t_min && in <= ray.t_max ? in : std::numeric_limits<double>::infinity();
}

std::vector<core::Ray> random_rays(tests::Random& random, const dvec3& about, std::size_t count) {
  std::vector<core::Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    const auto place = [&](double size) {
      return dvec3(uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size));
    };
    core::Ray ray{about + place(i % 3 == 0 ? 4.0 : 25.0), glm::normalize(place(1.0)), 0.0, 60.0};
    if (i % 5 == 0) ray.t_max = 8.0;
    rays.push_back(ray);
  }
  return rays;
}

TEST(ItemBoxesTest, FindWhatEachBoxInTurnHas) {
  tests::Random random(20261130);
  const core::ItemBounds bounds = random_boxes(random, 400);
  const ItemBoxes boxes(bounds, 1);
  RayFilter filter;
  std::vector<std::uint64_t> without(7);
  for (Slot slot = 0; slot < 400; slot += 5) without[slot / 64] |= std::uint64_t(1) << slot % 64;
  filter.without = without;
  const std::vector<core::Ray> rays = random_rays(random, bounds.origin, 4000);
  std::vector<ItemBoxes::Entry> entries(rays.size());
  boxes.nearest(rays, filter, entries);
  std::size_t found = 0, within = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (Slot slot = 0; slot < 400; ++slot)
      if (slot % 5 != 0) nearest = std::min(nearest, entry_of(rays[i], placed(bounds, slot)));
    const ItemBoxes::Entry alone = boxes.nearest(rays[i], filter);
    ASSERT_EQ(alone.slot == core::kNone, std::isinf(nearest)) << i;
    ASSERT_EQ(entries[i].slot == core::kNone, std::isinf(nearest)) << i;
    if (std::isinf(nearest)) continue;
    ++found;
    EXPECT_NEAR(alone.t, nearest, 1e-9);
    EXPECT_NEAR(entries[i].t, nearest, 1e-9);
    EXPECT_EQ(entries[i].slot, alone.slot);
    EXPECT_EQ(entries[i].normal, alone.normal);
    EXPECT_LT(glm::dot(alone.normal, rays[i].direction), 0.0);
    for (Slot slot = 0; slot < 400; ++slot) {
      const core::AabbD box = placed(bounds, slot);
      within += glm::all(glm::lessThan(box.min, rays[i].origin)) && glm::all(glm::lessThan(rays[i].origin, box.max));
    }
  }
  EXPECT_GT(found, 500u);
  EXPECT_GT(within, 8u) << "of the rays few begin in a box";
}

TEST(ItemBoxesTest, ABeamMissesNoBoxThatARayOfItMeets) {
  tests::Random random(4711);
  const core::ItemBounds bounds = random_boxes(random, 300);
  const ItemBoxes boxes(bounds, 1);
  for (const bool parallel : {false, true}) {
    const core::Pose pose{bounds.origin + dvec3(17, 3, 5), bounds.origin, {0, 0, 1}};
    const core::View view = parallel ? *core::View::orthographic(pose, 20.0, 1.0, 0.1, 60.0)
                                     : *core::View::perspective(pose, 1.0, 1.0, 0.1);
    const auto rays = *core::ImageRays::create(view, 64, 64);
    for (int block = 0; block < 16; ++block) {
      const int x = 16 * (block % 4), y = 16 * (block / 4);
      const Beam beam(
          {rays.through(x, y), rays.through(x + 16, y), rays.through(x + 16, y + 16), rays.through(x, y + 16)});
      std::vector<double> first(300, std::numeric_limits<double>::infinity());
      double limit = std::numeric_limits<double>::infinity(), before = -limit;
      boxes.find(beam, limit, [&](Slot slot, double t) {
        EXPECT_LE(before, t);
        before = first[slot] = t;
      });
      std::size_t visited = 0;
      for (Slot slot = 0; slot < 300; ++slot) visited += std::isfinite(first[slot]) || first[slot] < 0.0;
      EXPECT_LT(visited, 150u) << "a beam meets nearly everything";
      for (int i = 0; i < 200; ++i) {
        core::Ray ray = rays.through(x + uniform(random, 0, 16), y + uniform(random, 0, 16));
        ray.t_min = 0.0;
        for (Slot slot = 0; slot < 300; ++slot) {
          const double entry = entry_of(ray, placed(bounds, slot));
          ASSERT_TRUE(std::isinf(entry) || first[slot] <= entry) << block << " " << slot;
        }
      }
      std::size_t near = 0;
      limit = 10.0;
      boxes.find(beam, limit, [&](Slot, double t) {
        EXPECT_LE(t, limit);
        ++near;
      });
      EXPECT_LE(near, visited);
    }
  }
}

/// Solids about the origin, a fifth of them of glass, all in one snapshot and dealt out to five.
class PartsTest : public testing::Test {
 protected:
  static constexpr std::size_t kParts = 5;
  struct Piece {
    core::Scene scene;
    std::optional<core::Snapshot> snapshot;
    std::optional<Tracer> tracer;
    void finish() {
      ASSERT_TRUE(scene.commit());
      snapshot.emplace(scene);
      tracer.emplace(std::move(*Tracer::create(*snapshot)));
    }
  };

  void SetUp() override {
    tests::Random random(815);
    const auto length = [&] { return float(uniform(random, 0.1, 0.9)); };
    const auto shift = [&] { return float(uniform(random, -0.3, 0.3)); };
    const auto angle = [&] { return float(uniform(random, 0.5, 6.0)); };
    constexpr core::Kind kKinds[] = {core::Kind::kBox, core::Kind::kCylinder, core::Kind::kSphere, core::Kind::kSnout};
    for (std::size_t i = 0; i < 300; ++i) {
      const core::Affine at =
          core::translation({uniform(random, -4, 4), uniform(random, -4, 4), uniform(random, -3, 3)});
      const core::Primitive solid = tests::primitive_of(kKinds[i % 4], length, shift, angle);
      const core::Material material{"", {0.1f * float(i % 10), 0.5f, 0.3f}, i % 11 == 0 ? 0.4f : 1.0f, 0};
      for (Piece* piece : {&whole_, &pieces_[i % kParts]})
        piece->scene.add_primitive(piece->scene.root(), solid, at, piece->scene.add_material(material));
    }
    whole_.finish();
    for (Piece& piece : pieces_) piece.finish();
    boxes_.emplace(whole_.snapshot->bounds(), 1);
    part_of_.resize(whole_.snapshot->size());
    in_part_.resize(whole_.snapshot->size() / 64 + 1);
    colours_.assign(whole_.snapshot->size(), 0x808080u);
  }

  /// `missing`: the part that is not there; kParts: none.
  MovingImage image_of(std::size_t missing) {
    std::vector<TracedPart> parts;
    std::array<std::uint32_t, kParts> index;
    for (std::size_t i = 0; i < kParts; ++i) {
      index[i] = i == missing ? core::kNone : std::uint32_t(parts.size());
      if (i != missing) parts.push_back({&*pieces_[i].tracer, {}, &hits_[i]});
    }
    std::fill(in_part_.begin(), in_part_.end(), 0);
    for (Slot slot = 0; slot < part_of_.size(); ++slot) {
      part_of_[slot] = index[to_index(whole_.snapshot->item(slot)) % kParts];
      if (part_of_[slot] != core::kNone) in_part_[slot / 64] |= std::uint64_t(1) << slot % 64;
    }
    MovingImage image;
    EXPECT_TRUE(image.draw({{parts, {&*boxes_, part_of_, in_part_, colours_, kFirstId}}, view_, kWidth, kHeight},
                           threads_, kNever));
    return image;
  }

  static constexpr double kNever = std::numeric_limits<double>::infinity();
  static constexpr std::uint32_t kFirstId = 1000;
  const core::View view_ = *core::View::perspective({{12, 3, 4}, {}, {0, 0, 1}}, 0.7, double(kWidth) / kHeight, 0.1);
  core::ThreadPool threads_{2};
  Piece whole_;
  std::array<Piece, kParts> pieces_;
  std::array<std::atomic<std::uint32_t>, kParts> hits_{};
  std::optional<ItemBoxes> boxes_;
  std::vector<std::uint32_t> part_of_, colours_;
  std::vector<std::uint64_t> in_part_;
};

TEST_F(PartsTest, ShowWhatTheWholeShows) {
  MovingImage one;
  const TracedPart all{&*whole_.tracer};
  // Dithering goes by ids, which parts have of their own; so the pattern of glass differs, and nothing else.
  ASSERT_TRUE(one.draw({{{&all, 1}}, view_, kWidth, kHeight}, threads_, kNever));
  const MovingImage parts = image_of(kParts);
  const auto a = one.points().pixels(), b = parts.points().pixels();
  std::size_t differ = 0, items = 0;
  for (std::size_t i = 0; i < a.depths.size(); ++i) {
    differ += std::fabs(a.depths[i] - b.depths[i]) > 1e-6f;
    items += a.ids[i] != 0;
    ASSERT_LT(b.ids[i], kFirstId) << "a box, where all parts are there";
  }
  EXPECT_GT(items, a.ids.size() / 4);
  EXPECT_LT(differ, items / 8) << "glass covers less";
  std::uint32_t hits = 0;
  for (const auto& count : hits_) hits += count;
  EXPECT_GE(hits, items);
}

TEST_F(PartsTest, AreBoxesWhereTheyAreMissing) {
  MovingImage one;
  const TracedPart all{&*whole_.tracer};
  ASSERT_TRUE(one.draw({{{&all, 1}}, view_, kWidth, kHeight}, threads_, kNever));
  const MovingImage parts = image_of(2);
  const auto a = one.points().pixels(), b = parts.points().pixels();
  std::size_t boxes = 0;
  for (std::size_t i = 0; i < a.ids.size(); ++i) {
    const bool missing = a.ids[i] != 0 && (a.ids[i] - 1) % kParts == 2;
    boxes += b.ids[i] > kFirstId;
    EXPECT_TRUE(!missing || b.ids[i] != 0) << i;
    if (b.ids[i] <= kFirstId) continue;
    EXPECT_EQ(to_index(whole_.snapshot->item(Slot(b.ids[i] - 1 - kFirstId))) % kParts, 2u);
    EXPECT_GE(b.depths[i] * 1.000001f, missing ? a.depths[i] : 0.0f) << "boxes lie before what they hold";
  }
  EXPECT_GT(boxes, a.ids.size() / 30);
  EXPECT_EQ(hits_[2], 0u);
}

}  // namespace
}  // namespace sightline::raytrace::traced_scene_test
