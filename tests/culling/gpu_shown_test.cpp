// What the GPU culler leaves out of a picture: against exact arithmetic, and against the tests of the CPU.
#include <gtest/gtest.h>

#include "exact_samples.h"
#include "gpu_rig.h"
#include "scenes.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests {
namespace {

using core::Slot;
using culling::GpuCuller;
using culling::GpuCullerConfig;
using culling::SampleTest;

/// Every test is for all ways to cull.
class GpuShown : public GlTest, public testing::WithParamInterface<GpuCullerConfig> {};

INSTANTIATE_TEST_SUITE_P(All, GpuShown, testing::ValuesIn(all_gpu_configs()), gpu_config_name);

/// A mesh that fills a box, up to the rounding of its placement.
void add_box(core::Scene& scene, const Aabb& box, const core::dvec3& origin) {
  core::Mesh mesh;
  const core::vec3 size = box.max - box.min;
  mesh.positions = {{0, 0, 0}, size, {size.x, 0, 0}};
  mesh.indices = {0, 1, 2};
  scene.add_mesh_instance(scene.root(), scene.add_mesh(mesh).value(), core::translation(origin + core::dvec3(box.min)));
}

PictureSamples random_samples(Random& random) {
  PictureSamples samples{whole(random, 1, 9), whole(random, 1, 7), {{0, 0}}};
  if (chance(random, 0.7)) return samples;
  samples.offsets.clear();
  for (int i = whole(random, 2, 8); i > 0; --i)
    samples.offsets.push_back({float(whole(random, -8, 7)) / 16.0f, float(whole(random, -8, 7)) / 16.0f});
  return samples;
}

/// The slots of the view volume, and those of them that the GPU selects for a picture. Checks the feedback.
struct Answer {
  std::vector<Slot> in_view, selected;

  Answer(Rig& rig, const View& view, const PictureSamples& samples) : in_view(rig.cull(view)) {
    rig.context->functions().Finish();
    (void)rig.culler.take_feedback();
    const GpuCuller::Picture picture{view, samples};
    EXPECT_TRUE(rig.culler.cull(view, rig.snapshot, rig.gpu, rig.lists, 7, &picture));
    selected = rig.culler.read_back(rig.lists).items;
    rig.context->functions().Finish();
    const auto feedback = rig.culler.take_feedback();
    EXPECT_TRUE(feedback);
    if (!feedback) return;
    EXPECT_EQ(feedback->frame, 7u);
    EXPECT_EQ(feedback->visible, in_view.size());
    EXPECT_EQ(feedback->shown, selected.size());
  }
};

/// Boxes that touch the lines of sight of samples or just miss them. What no exact line meets may go; the CPU's test,
/// which computes with bands half as wide, keeps nearly the same.
TEST_P(GpuShown, KeepsWhatASampleSees) {
  std::size_t seen = 0, kept = 0, unseen = 0, other = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const auto [half, origin, view] = RandomSite(random);
    const PictureSamples samples = random_samples(random);
    core::Scene scene;
    for (int i = 0; i < 40; ++i)
      add_box(scene, chance(random, 0.3) ? random_box(random, half) : box_at_a_sample(random, view, origin, samples),
              origin);
    ASSERT_TRUE(scene.commit());
    Rig rig(*context, scene, GetParam());
    const core::ItemBounds& bounds = rig.snapshot.bounds();
    const SampleTest test(view, bounds.origin, samples);
    const ExactSamples exact(view, bounds.origin, samples);
    const Answer answer(rig, view, samples);
    for (const Slot slot : answer.in_view) {
      const bool keeps = std::binary_search(answer.selected.begin(), answer.selected.end(), slot);
      const bool sees = exact.covered_by(bounds.box(slot));
      ASSERT_TRUE(keeps || !sees) << "slot " << slot;
      ++(sees ? seen : unseen);
      kept += keeps && !sees;
      other += keeps != test.covers(bounds.box(slot));
    }
  }
  EXPECT_GT(seen, 100u);
  EXPECT_GT(unseen, 100u);
  EXPECT_LT(kept, 3 * unseen / 4) << "boxes at samples included";
  EXPECT_LE(other, (seen + unseen) / 20);
  RecordProperty("boxes", int(seen + unseen));
  RecordProperty("other_than_on_the_cpu", int(other));
}

/// Items of many sizes in usual views: as the CPU's test, but for boxes within the bands. Lines always stay.
TEST_P(GpuShown, LeavesOutWhatTheCpuLeavesOut) {
  std::size_t left_out = 0, kept = 0, other = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const core::dvec3 site = seed % 2 ? core::dvec3(0.0) : core::dvec3(4e5, 6e6, 100.0);
    core::Scene scene;
    for (int i = 0; i < 5000; ++i) {
      const float size = float(magnitude(random, 1e-3, 0.5));
      const core::Affine place = core::translation(site + point(random, 30.0));
      chance(random, 0.1) ? scene.add_primitive(scene.root(), core::Line{-size, size}, place)
                          : scene.add_primitive(scene.root(), core::Box{size, size, size}, place);
    }
    ASSERT_TRUE(scene.commit());
    Rig rig(*context, scene, GetParam());
    const core::ItemBounds& bounds = rig.snapshot.bounds();
    for (int i = 0; i < 6; ++i) {
      SCOPED_TRACE(testing::Message() << "view " << i);
      const core::Pose pose{site + point(random, 60.0), site, {0, 0, 1}};
      const View view = chance(random, 0.3) ? *View::orthographic(pose, 40.0, 1.5, -100.0, 100.0)
                                            : *View::perspective(pose, 1.0, 1.5, 0.1);
      PictureSamples samples{whole(random, 1, 300), whole(random, 1, 200), {{0, 0}}};
      if (chance(random, 0.3)) samples.offsets = {{-0.125f, -0.375f}, {0.375f, -0.125f}, {0.125f, 0.375f}};
      const SampleTest test(view, bounds.origin, samples);
      const Answer answer(rig, view, samples);
      for (const Slot slot : answer.in_view) {
        const bool keeps = std::binary_search(answer.selected.begin(), answer.selected.end(), slot);
        if (rig.snapshot.kind(slot) == core::Kind::kLine) {
          ASSERT_TRUE(keeps);
          continue;
        }
        ++(keeps ? kept : left_out);
        other += keeps != test.covers(bounds.box(slot));
      }
    }
  }
  EXPECT_GT(left_out, 10000u);
  EXPECT_GT(kept, 10000u);
  EXPECT_LE(other, (left_out + kept) / 1000);
  RecordProperty("boxes", int(left_out + kept));
  RecordProperty("other_than_on_the_cpu", int(other));
}

}  // namespace
}  // namespace sightline::tests
