// Every variant against sets computed in double without a hierarchy: what it promises, along moving cameras, so that
// coherent ones have something to remember.
#include <gtest/gtest.h>

#include "sightline/apps/bench/models/aircraft.h"
#include "sightline/study/culler.h"
#include "sightline/study/exact.h"
#include "sightline/study/motion.h"
#include "sightline/tests/culling/scenes.h"

namespace sightline::study::variants_test {
namespace {

constexpr unsigned kSeed = 11;
constexpr double kHalf = 50.0;

struct Model {
  std::vector<core::Aabb> boxes;
  Tree mean, median, sah;
  const Tree& tree(TreeKind kind) const {
    return kind == TreeKind::kMean ? mean : kind == TreeKind::kMedian ? median : sah;
  }
};

Model make_model(tests::Random& random, std::size_t count) {
  Model m;
  m.boxes = tests::random_boxes(random, count, kHalf);
  m.mean = build_tree(m.boxes, {}, Split::kMean);
  m.median = build_tree(m.boxes, {}, Split::kMedian);
  m.sah = build_tree(m.boxes, {}, Split::kSah);
  return m;
}

/// All valid combinations on one thread; trees take turns to keep the number down.
std::vector<Variant> all_variants() {
  std::vector<Variant> all;
  int turn = 0;
  for (int tree = 0; tree <= int(TreeKind::kSah); ++tree)
    for (int traversal = 0; traversal < 3; ++traversal)
      for (int test = 0; test <= int(study::Test::kSphere); ++test)
        for (int simd = 0; simd < 3; ++simd)
          for (unsigned flags = 0; flags < 128; ++flags) {
            Variant v;
            v.tree = TreeKind(tree);
            v.traversal = Traversal(traversal);
            v.test = study::Test(test);
            v.simd = Simd(simd);
            v.plane_coherency = (flags & 1) != 0;
            v.octant = (flags & 2) != 0;
            v.masking = (flags & 4) != 0;
            v.motion = (flags & 8) != 0;
            v.pre_test = (flags & 16) != 0;
            v.test_items = (flags & 32) == 0;
            v.max_depth = (flags & 64) == 0 ? 0xff : 5;
            const bool binary = v.tree != TreeKind::kNone;
            if (valid(v) && (!binary || ++turn % 3 == tree % 3)) all.push_back(v);
          }
  return all;
}

/// A path that goes on and turns, with a stretch of each alone and a jump, inside and around the model.
std::vector<core::View> path(tests::Random& random, int frames) {
  std::vector<core::View> views;
  core::Pose pose;
  double angle = 0.0;
  core::dvec3 eye = tests::point(random, kHalf);
  for (int i = 0; i < frames; ++i) {
    if (i % 3 != 0) eye += core::dvec3(0.02 * kHalf, 0.01 * kHalf, 0.0);
    if (i % 3 != 1) angle += 0.03;
    if (i == frames / 2) eye = tests::point(random, 2.0 * kHalf), angle += 2.0;
    pose.eye = eye;
    pose.target = eye + core::dvec3(std::cos(angle), std::sin(angle), 0.1);
    views.push_back(*core::View::perspective(pose, 0.8, 1.5, 0.1, 3.0 * kHalf));
  }
  return views;
}

void expect_promise(const Variant& v, const Errors& e, std::uint64_t& rounding, std::uint64_t& lost) {
  switch (promise(v)) {
    case Promise::kSame:
      EXPECT_EQ(e.missing, 0u);
      rounding += e.extra;
      break;
    case Promise::kConservative:
      EXPECT_EQ(e.missing, 0u);
      break;
    case Promise::kTighter:
      EXPECT_EQ(e.false_negatives, 0u);
      break;
    case Promise::kErrs:
      lost += e.false_negatives;
      break;
  }
}

TEST(StudyVariants, KeepTheirPromisesAlongAPath) {
  tests::Random random(kSeed);
  const Model model = make_model(random, 700);
  const auto views = path(random, 24);
  std::vector<ExactSets> exact;
  for (const core::View& view : views) exact.emplace_back(model.boxes, view);
  std::uint64_t rounding = 0, lost = 0;
  const auto variants = all_variants();
  EXPECT_GT(variants.size(), 700u);
  for (const Variant& v : variants) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ": " + name(v));
    Culler culler(v, model.boxes, model.tree(v.tree));
    Visible visible;
    for (std::size_t i = 0; i < views.size(); ++i) {
      culler.cull(views[i], visible);
      const auto ids = culler.ids(visible);
      ASSERT_EQ(ids.size(), visible.count());
      ASSERT_TRUE(std::adjacent_find(ids.begin(), ids.end()) == ids.end());
      expect_promise(v, compare(ids, exact[i]), rounding, lost);
    }
    if (HasFailure()) return;
  }
  EXPECT_LT(rounding, variants.size()) << "boxes within rounding errors of a plane must be rare";
  EXPECT_GT(lost, 0u) << "the counting radar loses boxes larger than the view; a test that sees none sees nothing";
}

TEST(StudyVariants, KeepTheirPromisesInAnyView) {
  tests::Random random(kSeed + 1);
  const auto variants = all_variants();
  for (int round = 0; round < 40; ++round) {
    const Model model = make_model(random, 150);
    std::vector<core::View> views;
    std::vector<ExactSets> exact;
    for (int i = 0; i < 10; ++i) {
      views.push_back(tests::random_view(random, core::dvec3(0.0), kHalf));
      exact.emplace_back(model.boxes, views.back());
    }
    for (std::size_t k = std::size_t(round); k < variants.size(); k += 7) {
      SCOPED_TRACE("seed " + std::to_string(kSeed + 1) + ", round " + std::to_string(round) + ": " + name(variants[k]));
      Culler culler(variants[k], model.boxes, model.tree(variants[k].tree));
      Visible visible;
      std::uint64_t ignored = 0;
      for (std::size_t i = 0; i < views.size(); ++i) {
        culler.cull(views[i], visible);
        SCOPED_TRACE("view " + std::to_string(i));
        expect_promise(variants[k], compare(culler.ids(visible), exact[i]), ignored, ignored);
      }
      if (HasFailure()) return;
    }
  }
}

TEST(StudyVariants, PlaneTestsAgreeBitForBit) {
  tests::Random random(kSeed + 2);
  const Model model = make_model(random, 2000);
  const auto views = path(random, 20);
  std::vector<Variant> variants;
  for (const Variant& v : all_variants())
    if (promise(v) == Promise::kSame && v.test != study::Test::kRadarByLimit && !v.motion &&
        !(v.simd == Simd::kPerTest && v.test != study::Test::kSplit))
      variants.push_back(v);
  std::vector<std::vector<std::uint32_t>> expected(views.size());
  for (const Variant& v : variants) {
    SCOPED_TRACE("seed " + std::to_string(kSeed + 2) + ": " + name(v));
    Culler culler(v, model.boxes, model.tree(v.tree));
    Visible visible;
    for (std::size_t i = 0; i < views.size(); ++i) {
      culler.cull(views[i], visible);
      if (&v == variants.data())
        expected[i] = culler.ids(visible);
      else
        ASSERT_EQ(culler.ids(visible), expected[i]);
    }
  }
}

TEST(StudyVariants, KeepBoxesThatTouchThePlanes) {
  tests::Random random(kSeed + 5);
  const auto variants = all_variants();
  std::uint64_t close_calls = 0;
  for (int round = 0; round < 20; ++round) {
    const core::View view = tests::random_view(random, core::dvec3(0.0), kHalf);
    const auto planes = core::frustum_planes(view.clip_from_world(), view.clip_depth());
    Model model;
    for (int i = 0; i < 200; ++i) {
      const core::Plane& plane = planes[std::size_t(i % 6)];
      if (!(glm::length(plane.normal) > 0.0)) continue;
      // The p-vertex on the plane, as near as floats allow; the box behind it.
      core::dvec3 p = tests::point(random, kHalf);
      p -= core::evaluate(plane, p) / glm::dot(plane.normal, plane.normal) * plane.normal;
      if (!(glm::length(p) < 1e3 * kHalf)) continue;
      core::Aabb box;
      for (int axis = 0; axis < 3; ++axis) {
        const float near = float(p[axis]), far = near + float(plane.normal[axis] >= 0.0 ? -1.0 : 1.0);
        box.min[axis] = std::min(near, far);
        box.max[axis] = std::max(near, far);
      }
      model.boxes.push_back(box);
    }
    if (model.boxes.empty()) continue;
    model.mean = build_tree(model.boxes, {}, Split::kMean);
    model.median = build_tree(model.boxes, {}, Split::kMedian);
    model.sah = build_tree(model.boxes, {}, Split::kSah);
    const ExactSets exact(model.boxes, view);
    close_calls += exact.p_vertex().size();
    for (std::size_t k = std::size_t(round); k < variants.size(); k += 5) {
      SCOPED_TRACE("seed " + std::to_string(kSeed + 5) + ", round " + std::to_string(round) + ": " + name(variants[k]));
      Culler culler(variants[k], model.boxes, model.tree(variants[k].tree));
      Visible visible;
      std::uint64_t ignored = 0;
      culler.cull(view, visible);
      expect_promise(variants[k], compare(culler.ids(visible), exact), ignored, ignored);
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(close_calls, 100u);
}

TEST(StudyVariants, ThreadsChangeNothing) {
  const auto boxes = bench::make_aircraft(60'000);
  const Tree tree = build_tree(boxes, {}, Split::kMean);
  std::vector<core::View> views;
  for (int i = 0; i < 10; ++i) {
    const core::Pose pose{{60.0 - 12.0 * i, 20.0, 5.0}, {0.0, 0.0, 0.0}, {0, 0, 1}};
    views.push_back(*core::View::perspective(pose, 0.5, 1.5, 0.1, 200.0));
  }
  for (const bool masking : {false, true}) {
    Variant v{.tree = TreeKind::kMean, .masking = masking};
    Culler one(v, boxes, tree);
    for (const Threads threads : {Threads::kStatic, Threads::kTasks, Threads::kRing}) {
      for (const int count : {1, 2, 3, 4, 7}) {
        v.threads = threads;
        v.thread_count = count;
        SCOPED_TRACE(name(v));
        Culler many(v, boxes, tree);
        Visible a, b;
        for (const core::View& view : views) {
          one.cull(view, a);
          many.cull(view, b);
          ASSERT_GT(a.count(), 0u);
          ASSERT_LT(a.count(), boxes.size());
          ASSERT_EQ(one.ids(a), many.ids(b));
        }
      }
    }
  }
}

TEST(StudyMotion, StaysConservativeBeyondItsHistory) {
  tests::Random random(kSeed + 4);
  const Model model = make_model(random, 500);
  core::Pose pose;
  pose.eye = {0, 0, 0};
  Culler culler({.motion = true}, model.boxes, model.mean);
  Visible visible;
  for (int i = 0; i < 5000; ++i) {
    pose.target = {std::cos(1e-3 * i), std::sin(1e-3 * i), 0.0};
    const auto view = core::View::perspective(pose, 0.8, 1.5, 0.1, 3.0 * kHalf);
    culler.cull(*view, visible);
    if (i % 250 == 0) {
      EXPECT_EQ(compare(culler.ids(visible), ExactSets(model.boxes, *view)).missing, 0u) << "frame " << i;
    }
  }
}

TEST(StudyMotion, SettlesWhatItMayAndNoMore) {
  const core::Aabb extent{core::vec3(-100.0f), core::vec3(100.0f)};
  const auto camera = [&](double y, double angle) {
    const core::Pose pose{{0, y, 0}, {-std::sin(angle), y + std::cos(angle), 0}, {0, 0, 1}};
    return Camera(*core::View::perspective(pose, 1.0, 1.0, 0.1, 200.0), extent);
  };
  Motion motion;
  motion.advance(camera(0.0, 0.0));
  const Box behind{{-1, -6, -1}, {1, -5, 1}};  // 5.1 m behind the near plane
  const Memory memory = motion.remember({5.1f, core::kNear}, behind);
  EXPECT_TRUE(motion.still_outside(memory));
  EXPECT_FALSE(motion.still_outside({}));
  motion.advance(camera(50.0, 0.0));  // away from it
  EXPECT_TRUE(motion.still_outside(memory));
  motion.advance(camera(-5.0, 0.0));  // and back, to 0.1 m before it
  EXPECT_TRUE(motion.still_outside(memory));
  motion.advance(camera(-5.2, 0.0));
  EXPECT_FALSE(motion.still_outside(memory));
  Motion turning;
  turning.advance(camera(0.0, 0.0));
  const Memory before = turning.remember({5.1f, core::kNear}, behind);
  turning.advance(camera(0.0, 0.5));
  EXPECT_TRUE(turning.still_outside(before));
  turning.advance(camera(0.0, 3.0));
  EXPECT_FALSE(turning.still_outside(before));
}

TEST(StudyAircraft, HasTheCountAsked) {
  const auto boxes = bench::make_aircraft(10'000);
  EXPECT_EQ(boxes.size(), 10'000u);
  for (const core::Aabb& b : boxes) {
    ASSERT_FALSE(b.empty());
    ASSERT_LT(glm::length(b.max), 80.0f);
  }
  const auto again = bench::make_aircraft(10'000);
  for (std::size_t i = 0; i < boxes.size(); ++i) ASSERT_EQ(boxes[i].min, again[i].min);
}

}  // namespace
}  // namespace sightline::study::variants_test
