// Every variant against sets computed in double without a hierarchy: what it promises, along moving cameras, so that
// coherent ones have something to remember.
#include <gtest/gtest.h>

#include "sightline/apps/bench/models/aircraft.h"
#include "sightline/apps/study/culler.h"
#include "sightline/apps/study/exact.h"
#include "sightline/apps/study/motion.h"
#include "sightline/tests/culling/scenes.h"

namespace sightline::study::variants_test {
namespace {

constexpr unsigned kSeed = 11;
constexpr double kHalf = 50.0;

struct Model {
  std::vector<core::Aabb> boxes;
  Tree mean, median;

  explicit Model(std::vector<core::Aabb> all)
      : boxes(std::move(all)),
        mean(build_tree(boxes, {}, Split::kMean)),
        median(build_tree(boxes, {}, Split::kMedian)) {}

  Culler culler(const Variant& v) const { return {v, boxes, v.tree == TreeKind::kMean ? mean : median}; }
};

/// All valid combinations on one thread; trees take turns to keep the number down.
std::vector<Variant> all_variants() {
  std::vector<Variant> all;
  int turn = 0;
  for (int tree = 0; tree <= int(TreeKind::kMedian); ++tree)
    for (int traversal = 0; traversal < 3; ++traversal)
      for (int test = 0; test <= int(study::Test::kRadarTwoAnswers); ++test)
        for (const bool simd : {false, true})
          for (unsigned flags = 0; flags <= kAllFlags; ++flags)
            for (const bool test_items : {true, false}) {
              const Variant v{.tree = TreeKind(tree),
                              .traversal = Traversal(traversal),
                              .test = study::Test(test),
                              .simd = simd,
                              .flags = flags,
                              .test_items = test_items};
              if (valid(v) && (v.tree == TreeKind::kNone || ++turn % 2 == tree % 2)) all.push_back(v);
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

/// Culls each view by a variant; checks its promise in each.
void expect_promises(const Model& model, const Variant& v, const std::vector<core::View>& views,
                     const std::vector<ExactSets>& exact, std::uint64_t& rounding, std::uint64_t& lost) {
  SCOPED_TRACE(name(v));
  Culler culler = model.culler(v);
  for (std::size_t i = 0; i < views.size(); ++i) {
    SCOPED_TRACE("view " + std::to_string(i));
    culler.cull(views[i]);
    const auto ids = culler.ids();
    ASSERT_EQ(ids.size(), culler.count());
    ASSERT_TRUE(std::adjacent_find(ids.begin(), ids.end()) == ids.end());
    expect_promise(v, compare(ids, exact[i]), rounding, lost);
  }
}

std::vector<ExactSets> exact_sets(const Model& model, const std::vector<core::View>& views) {
  std::vector<ExactSets> exact;
  for (const core::View& view : views) exact.emplace_back(model.boxes, view);
  return exact;
}

TEST(StudyVariants, KeepTheirPromisesAlongAPath) {
  tests::Random random(kSeed);
  const Model model(tests::random_boxes(random, 700, kHalf));
  const auto views = path(random, 24);
  const auto exact = exact_sets(model, views);
  std::uint64_t rounding = 0, lost = 0;
  const auto variants = all_variants();
  EXPECT_GT(variants.size(), 300u);
  for (const Variant& v : variants) {
    expect_promises(model, v, views, exact, rounding, lost);
    if (HasFailure()) return;
  }
  EXPECT_LT(rounding, variants.size()) << "boxes within rounding errors of a plane must be rare";
  EXPECT_GT(lost, 0u) << "the counting radar loses boxes larger than the view; a test that sees none sees nothing";
}

TEST(StudyVariants, KeepTheirPromisesInAnyView) {
  tests::Random random(kSeed + 1);
  const auto variants = all_variants();
  std::uint64_t ignored = 0;
  for (std::size_t round = 0; round < 40; ++round) {
    SCOPED_TRACE("seed " + std::to_string(kSeed + 1) + ", round " + std::to_string(round));
    const Model model(tests::random_boxes(random, 150, kHalf));
    std::vector<core::View> views;
    for (int i = 0; i < 10; ++i) views.push_back(tests::random_view(random, core::dvec3(0.0), kHalf));
    const auto exact = exact_sets(model, views);
    for (std::size_t k = round; k < variants.size(); k += 7)
      expect_promises(model, variants[k], views, exact, ignored, ignored);
    if (HasFailure()) return;
  }
}

TEST(StudyVariants, PlaneTestsAgreeBitForBit) {
  tests::Random random(kSeed + 2);
  const Model model(tests::random_boxes(random, 2000, kHalf));
  const auto views = path(random, 20);
  std::vector<std::vector<std::uint32_t>> expected(views.size());
  for (const Variant& v : all_variants()) {
    if (promise(v) != Promise::kSame || v.has(kMotion) || (v.simd && v.test != study::Test::kSplit)) continue;
    SCOPED_TRACE("seed " + std::to_string(kSeed + 2) + ": " + name(v));
    Culler culler = model.culler(v);
    for (std::size_t i = 0; i < views.size(); ++i) {
      culler.cull(views[i]);
      if (expected[i].empty()) expected[i] = culler.ids();
      ASSERT_EQ(culler.ids(), expected[i]);
    }
  }
}

TEST(StudyVariants, KeepBoxesThatTouchThePlanes) {
  tests::Random random(kSeed + 5);
  const auto variants = all_variants();
  std::uint64_t close_calls = 0, ignored = 0;
  for (std::size_t round = 0; round < 20; ++round) {
    SCOPED_TRACE("seed " + std::to_string(kSeed + 5) + ", round " + std::to_string(round));
    const core::View view = tests::random_view(random, core::dvec3(0.0), kHalf);
    const auto planes = core::frustum_planes(view.clip_from_world(), view.clip_depth());
    std::vector<core::Aabb> boxes;
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
      boxes.push_back(box);
    }
    if (boxes.empty()) continue;
    const Model model(std::move(boxes));
    const auto exact = exact_sets(model, {view});
    close_calls += exact[0].p_vertex().size();
    for (std::size_t k = round; k < variants.size(); k += 5)
      expect_promises(model, variants[k], {view}, exact, ignored, ignored);
    if (HasFailure()) return;
  }
  EXPECT_GT(close_calls, 100u);
}

TEST(StudyVariants, ThreadsChangeNothing) {
  const Model model(bench::make_aircraft(60'000));
  std::vector<core::View> views;
  for (int i = 0; i < 10; ++i) {
    const core::Pose pose{{60.0 - 12.0 * i, 20.0, 5.0}, {0.0, 0.0, 0.0}, {0, 0, 1}};
    views.push_back(*core::View::perspective(pose, 0.5, 1.5, 0.1, 200.0));
  }
  for (const unsigned flags : {0u, unsigned(kMasking)}) {
    Variant v{.tree = TreeKind::kMean, .flags = flags};
    Culler one = model.culler(v);
    for (const Threads threads : {Threads::kStatic, Threads::kTasks, Threads::kRing}) {
      for (const int count : {1, 2, 3, 4, 7}) {
        v.threads = threads;
        v.thread_count = count;
        SCOPED_TRACE(name(v));
        Culler many = model.culler(v);
        for (const core::View& view : views) {
          one.cull(view);
          many.cull(view);
          ASSERT_GT(one.count(), 0u);
          ASSERT_LT(one.count(), model.boxes.size());
          ASSERT_EQ(one.ids(), many.ids());
        }
      }
    }
  }
}

TEST(StudyMotion, StaysConservativeBeyondItsHistory) {
  tests::Random random(kSeed + 4);
  const Model model(tests::random_boxes(random, 500, kHalf));
  core::Pose pose;
  pose.eye = {0, 0, 0};
  Culler culler = model.culler({.flags = kMotion});
  for (int i = 0; i < 5000; ++i) {
    pose.target = {std::cos(1e-3 * i), std::sin(1e-3 * i), 0.0};
    const auto view = core::View::perspective(pose, 0.8, 1.5, 0.1, 3.0 * kHalf);
    culler.cull(*view);
    if (i % 250 == 0) {
      EXPECT_EQ(compare(culler.ids(), ExactSets(model.boxes, *view)).missing, 0u) << "frame " << i;
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

}  // namespace
}  // namespace sightline::study::variants_test
