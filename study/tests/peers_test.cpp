// Other libraries' cullers and production's forms against sets computed in double.
#include <gtest/gtest.h>

#include "sightline/apps/bench/models/aircraft.h"
#include "sightline/apps/bench/models/platforms.h"
#include "sightline/study/brute_force.h"
#include "sightline/study/camera.h"
#include "sightline/study/exact.h"
#include "sightline/study/peer.h"
#include "sightline/study/production.h"
#include "sightline/tests/culling/scenes.h"

namespace sightline::study::peers_test {
namespace {

constexpr unsigned kSeed = 31;
constexpr double kHalf = 50.0;

std::vector<core::View> views() {
  tests::Random random(kSeed);
  std::vector<core::View> out;
  for (int i = 0; i < 40; ++i) {
    const core::Pose pose{tests::point(random, 1.5 * kHalf), tests::point(random, 0.5 * kHalf), {0, 0, 1}};
    out.push_back(*core::View::perspective(pose, 0.4 + 0.02 * i, 1.5, 0.1, i % 2 == 0 ? 40.0 : 400.0));
  }
  return out;
}

void expect_no_loss(Method& method, const std::vector<core::Aabb>& boxes) {
  std::uint64_t visible = 0, extra = 0;
  for (const core::View& view : views()) {
    method.cull(view);
    const auto ids = method.ids();
    ASSERT_EQ(ids.size(), method.count());
    ASSERT_TRUE(std::is_sorted(ids.begin(), ids.end()));
    const Errors e = compare(ids, ExactSets(boxes, view));
    EXPECT_EQ(e.false_negatives, 0u);
    visible += e.visible;
    extra += e.false_positives;
  }
  EXPECT_GT(visible, 0u);
  EXPECT_LT(extra, visible / 2) << "it culls";
}

TEST(StudyPeers, LoseNothing) {
  tests::Random random(kSeed + 1);
  const auto boxes = tests::random_boxes(random, 3000, kHalf);
  for (const Peer& peer : peers()) {
    SCOPED_TRACE(peer.name);
    expect_no_loss(*peer.make(boxes), boxes);
  }
}

TEST(StudyPeers, KeepEverythingInViewsTheyCannotHave) {
  const auto boxes = bench::make_aircraft(2000);
  const auto view = core::View::perspective({{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}, 0.5, 1.0, 0.1);
  ASSERT_FALSE(symmetric(*view).has_value()) << "no far plane";
  for (const Peer& peer : peers()) {
    SCOPED_TRACE(peer.name);
    const auto method = peer.make(boxes);
    method->cull(*view);
    EXPECT_EQ(method->count(), boxes.size());
  }
}

TEST(StudyProduction, AnswersTheSameInEveryForm) {
  tests::Random random(kSeed + 2);
  const auto boxes = tests::random_boxes(random, 3000, kHalf);
  std::vector<std::unique_ptr<Method>> methods;
  for (const ProductionForm& form : production_forms()) methods.push_back(make_production(form, boxes));
  for (const auto& method : methods) expect_no_loss(*method, boxes);
  for (const core::View& view : views()) {
    methods[0]->cull(view);
    const auto expected = methods[0]->ids();
    for (const auto& method : methods) {
      method->cull(view);
      EXPECT_EQ(method->ids(), expected);
    }
  }
}

TEST(StudyCamera, SymmetricViewsAreTakenApart) {
  const core::Pose pose{{3, 4, 5}, {10, -2, 1}, {0, 0, 1}};
  const auto s = symmetric(*core::View::perspective(pose, 0.7, 1.5, 0.25, 300.0));
  ASSERT_TRUE(s.has_value());
  EXPECT_LT(glm::distance(s->eye, pose.eye), 1e-12);
  EXPECT_LT(glm::distance(s->forward, glm::normalize(pose.target - pose.eye)), 1e-12);
  EXPECT_NEAR(glm::dot(s->up, s->forward), 0.0, 1e-12);
  EXPECT_NEAR(s->fovy, 0.7, 1e-12);
  EXPECT_NEAR(s->aspect, 1.5, 1e-12);
  EXPECT_NEAR(s->near, 0.25, 1e-9);
  EXPECT_NEAR(s->far, 300.0, 1e-6);
  EXPECT_FALSE(symmetric(*core::View::orthographic(pose, 10.0, 1.0, 0.0, 50.0)).has_value());
  EXPECT_FALSE(symmetric(*core::View::asymmetric(pose, -1.0, 2.0, -1.0, 1.0, 1.0, 50.0)).has_value());
}

TEST(StudyPlatforms, KindsAreMixedToTheItem) {
  for (const bench::Platform& platform : bench::kPlatforms) {
    for (const std::size_t count : {1000u, 12345u}) {
      SCOPED_TRACE(platform.name);
      std::vector<std::uint8_t> kinds;
      for (std::size_t i = 0; i < count; ++i) kinds.push_back(std::uint8_t(i * 7919 % 20 < 13 ? 0 : i % 4));
      bench::mix_kinds(platform, kinds);
      std::array<std::uint64_t, 4> have{};
      for (const std::uint8_t k : kinds) ++have.at(k);
      for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(have[k], platform.counts[k] * count / platform.objects());
    }
  }
}

}  // namespace
}  // namespace sightline::study::peers_test
