// What the GPU culler leaves out of an image: against exact arithmetic, and against the tests of the CPU.
#include <gtest/gtest.h>

#include "exact_samples.h"
#include "gpu_rig.h"
#include "scenes.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/gpuprims/internal/view_block.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests::gpu_drawn_items_test {
namespace {

using core::Slot;
using culling::GpuCuller;
using culling::GpuCullerConfig;
using culling::SampleTest;

/// Every test is for all ways to cull.
class GpuDrawnItems : public GlTest, public testing::WithParamInterface<GpuCullerConfig> {};

INSTANTIATE_TEST_SUITE_P(All, GpuDrawnItems, testing::ValuesIn(all_gpu_configs()), gpu_config_name);

/// A mesh that fills a box, up to the rounding of its placement.
void add_box(core::Scene& scene, const Aabb& box, const core::dvec3& origin) {
  core::Mesh mesh;
  const core::vec3 size = box.max - box.min;
  mesh.positions = {{0, 0, 0}, size, {size.x, 0, 0}};
  mesh.indices = {0, 1, 2};
  scene.add_mesh_instance(scene.root(), scene.add_mesh(mesh).value(), core::translation(origin + core::dvec3(box.min)));
}

ImageSamples random_samples(Random& random) {
  ImageSamples samples{whole(random, 1, 9), whole(random, 1, 7), {{0, 0}}};
  if (chance(random, 0.7)) return samples;
  samples.offsets.clear();
  for (int i = whole(random, 2, 8); i > 0; --i)
    samples.offsets.push_back({float(whole(random, -8, 7)) / 16.0f, float(whole(random, -8, 7)) / 16.0f});
  return samples;
}

/// The slots of the view volume, and those of them that the GPU selects for an image. Checks the feedback.
struct Answer {
  std::vector<Slot> in_view, selected;

  Answer(Rig& rig, const View& view, const ImageSamples& samples) : in_view(rig.cull(view)) {
    rig.context->functions().Finish();
    (void)rig.culler.take_feedback();
    const GpuCuller::Image image{view, samples};
    EXPECT_TRUE(rig.culler.cull(view, rig.snapshot, rig.gpu, rig.lists, {7, &image}));
    selected = rig.culler.read_back(rig.lists).single_slots;
    rig.context->functions().Finish();
    const auto feedback = rig.culler.take_feedback();
    EXPECT_TRUE(feedback);
    if (!feedback) return;
    EXPECT_EQ(feedback->frame, 7u);
    EXPECT_EQ(feedback->visible, in_view.size());
    EXPECT_EQ(feedback->items_drawn, selected.size());
  }
};

/// Boxes that touch the lines of sight of samples or just miss them. What no exact line meets may go; the CPU's test,
/// which computes with bands half as wide, keeps nearly the same.
TEST_P(GpuDrawnItems, KeepsWhatASampleSees) {
  std::size_t seen = 0, kept = 0, unseen = 0, other = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const auto [half, origin, view] = RandomSite(random);
    const ImageSamples samples = random_samples(random);
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
TEST_P(GpuDrawnItems, LeavesOutWhatTheCpuLeavesOut) {
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
      ImageSamples samples{whole(random, 1, 300), whole(random, 1, 200), {{0, 0}}};
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
  EXPECT_LE(other, (left_out + kept) / 100) << "the CPU also tests the rays of few pixels";
  RecordProperty("boxes", int(left_out + kept));
  RecordProperty("other_than_on_the_cpu", int(other));
}

// --- occlusion -------------------------------------------------------------------------------------------------------

/// A reverse-Z depth texture, and the distances that it stands for.
struct DepthTexture {
  gl::Texture2D texture;
  std::vector<float> depths, distances;

  DepthTexture(const gl::Functions& gl, const View& view, int width, int height, std::vector<float> values)
      : texture(std::move(*gl::Texture2D::create(gl, width, height, GL_DEPTH_COMPONENT32F, "test depth"))),
        depths(std::move(values)) {
    texture.write(GL_DEPTH_COMPONENT, GL_FLOAT, std::as_bytes(std::span(depths)));
    const core::dmat4 clip = gpuprims::reversed_clip_from_eye(view);
    for (const float depth : depths)
      distances.push_back(depth == 0.0f ? std::numeric_limits<float>::infinity()
                                        : float(gpuprims::eye_depth(clip, double(depth))));
  }
};

/// The depth of a distance, or 0 (nothing is there) for those that no depth stands for.
float depth_of(const View& view, double distance) {
  const core::dmat4 clip = gpuprims::reversed_clip_from_eye(view);
  const double depth = (clip[3][2] - distance * clip[2][2]) / (clip[3][3] - distance * clip[2][3]);
  return depth > 0.0 && depth <= 1.0 ? float(depth) : 0.0f;
}

/// Large areas of few depths, some of them empty.
std::vector<float> random_depths(Random& random, int width, int height) {
  std::vector<float> depths(std::size_t(width) * std::size_t(height), 0.0f);
  for (int i = whole(random, 0, 6); i > 0; --i) {
    const float depth = chance(random, 0.1) ? 0.0f : float(magnitude(random, 1e-6, 1.0));
    const int x0 = whole(random, 0, width - 1), x1 = whole(random, x0, width - 1);
    const int y0 = whole(random, 0, height - 1), y1 = whole(random, y0, height - 1);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) depths[std::size_t(y * width + x)] = depth;
  }
  return depths;
}

class GpuDepthPyramidTest : public GlTest {};

/// Every block holds the farthest distance of its pixels, whatever the size of the image.
TEST_F(GpuDepthPyramidTest, HoldsTheFarthestDistances) {
  auto pyramid = culling::GpuDepthPyramid::create(gl());
  ASSERT_TRUE(pyramid);
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const int width = whole(random, 1, 90), height = whole(random, 1, 70);
    const View view = random_view(random, core::dvec3(0.0), 10.0);
    const DepthTexture depth(gl(), view, width, height, random_depths(random, width, height));
    ASSERT_TRUE(pyramid->build(depth.texture, view));
    std::vector<float> texels(pyramid->buffer().size() / sizeof(float));
    pyramid->buffer().read(0, pyramid->buffer().size(), texels.data());
    std::size_t at = 0;
    for (int level = 0, w = width, h = height;; ++level, w = (w + 1) / 2, h = (h + 1) / 2) {
      ASSERT_LT(std::size_t(level), pyramid->levels().size());
      ASSERT_EQ(pyramid->levels()[std::size_t(level)].first, at);
      std::vector<float> farthest(std::size_t(w) * std::size_t(h), -std::numeric_limits<float>::infinity());
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          float& block = farthest[std::size_t((y >> level) * w + (x >> level))];
          block = std::max(block, depth.distances[std::size_t(y * width + x)]);
        }
      for (const float distance : farthest) {
        const float found = texels[at++];
        if (distance > 3.4e38f) {
          ASSERT_GE(found, 3.4e38f);
        } else {
          ASSERT_NEAR(found, distance, 1e-6 * std::abs(distance));
        }
      }
      if (w <= 3 && h <= 3) break;
    }
    ASSERT_EQ(at, texels.size());
  }
}

/// Both passes of a frame against a given depth.
struct OcclusionFrame {
  std::vector<Slot> first, others;

  OcclusionFrame(Rig& rig, const View& view, const DepthTexture& depth, std::size_t in_view) {
    const GpuCuller::Image image{view, {depth.texture.width(), depth.texture.height(), {{0, 0}}}, true};
    EXPECT_TRUE(rig.culler.cull(view, rig.snapshot, rig.gpu, rig.lists, {3, &image}));
    first = rig.culler.read_back(rig.lists).single_slots;
    const double error = render::RenderTarget::orthographic_error(view);
    EXPECT_TRUE(rig.culler.cull_others(image, rig.gpu, rig.lists, depth.texture, error));
    others = rig.culler.read_back(rig.lists).single_slots;
    rig.context->functions().Finish();
    const auto feedback = rig.culler.take_feedback();
    EXPECT_TRUE(feedback);
    if (!feedback) return;
    EXPECT_EQ(feedback->visible, in_view);
    EXPECT_EQ(feedback->items_drawn, first.size() + others.size());
  }
};

TEST_P(GpuDrawnItems, TheOcclusionTestTakesNoMemoryUntilItIsUsed) {
  core::Scene scene;
  for (int i = 0; i < 5000; ++i)
    scene.add_primitive(scene.root(), core::Box{1, 1, 1}, core::translation({2.0 * i, 0, 0}));
  ASSERT_TRUE(scene.commit());
  Rig rig(*context, scene, GetParam());
  const View view = *View::perspective({{0, -50, 0}, {0, 0, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1);
  const Answer answer(rig, view, {64, 64, {{0, 0}}});
  const std::size_t before = rig.culler.memory_bytes();
  const DepthTexture nothing(gl(), view, 64, 64, std::vector<float>(64 * 64));
  const OcclusionFrame frame(rig, view, nothing, answer.in_view.size());
  EXPECT_EQ(frame.others, answer.selected);
  EXPECT_GT(rig.culler.memory_bytes(), before + 64 * 64 * sizeof(float) + 5000 * sizeof(std::uint32_t));
  EXPECT_LT(rig.culler.memory_bytes(), before + 2 * 64 * 64 * sizeof(float) + 2 * 5000 * sizeof(std::uint32_t));
}

/// Boxes just behind and just in front of what their pixels hold: of what is left out, no line of sight through a pixel
/// centre meets a point in front of it. And nearly as the CPU's test says.
TEST_P(GpuDrawnItems, HidesOnlyWhatEveryPixelHides) {
  std::size_t hidden = 0, open = 0, other = 0;
  for (std::uint64_t seed = 1; seed <= 250; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const RandomSite site(random);
    const View& view = site.view;
    const ImageSamples samples{whole(random, 1, 11), whole(random, 1, 9), {{0, 0}}};
    core::Scene scene;
    for (int i = 0; i < 8; ++i)
      add_box(scene,
              chance(random, 0.3) ? random_box(random, site.half) : box_at_a_sample(random, view, site.origin, samples),
              site.origin);
    ASSERT_TRUE(scene.commit());
    Rig rig(*context, scene, GetParam());
    const core::ItemBounds& bounds = rig.snapshot.bounds();
    const ExactSamples exact(view, bounds.origin, samples);
    const std::vector<Slot> in_view = rig.cull(view);
    rig.context->functions().Finish();
    (void)rig.culler.take_feedback();
    std::vector<float> depths = random_depths(random, samples.width, samples.height);
    const auto for_each_pixel = [&](const auto& f) {
      for (int y = 0; y < samples.height; ++y)
        for (int x = 0; x < samples.width; ++x) f(x, y, std::size_t(y * samples.width + x));
    };
    for (const Slot slot : in_view)  // the last of several boxes at a pixel counts
      for_each_pixel([&](int x, int y, std::size_t k) {
        const auto nearest = exact.nearest(bounds.box(slot), x, y);
        if (nearest && chance(random, 0.95))
          depths[k] = depth_of(view, nearest->get_d() * (1.0 + uniform(random, -4e-5, 1e-6)));
      });
    const DepthTexture depth(gl(), view, samples.width, samples.height, std::move(depths));
    const OcclusionFrame frame(rig, view, depth, in_view.size());
    EXPECT_TRUE(frame.first.empty()) << "nothing was known";
    culling::DepthPyramid pyramid;
    pyramid.build(depth.distances, samples.width, samples.height);
    const culling::OcclusionTest test(view, bounds.origin, samples.width, samples.height, pyramid,
                                      render::RenderTarget::orthographic_error(view));
    for (const Slot slot : in_view) {
      const bool hides = !std::binary_search(frame.others.begin(), frame.others.end(), slot);
      ++(hides ? hidden : open);
      other += hides != test.occluded(bounds.box(slot));
      if (!hides) continue;
      for_each_pixel([&](int x, int y, std::size_t k) {
        const auto nearest = exact.nearest(bounds.box(slot), x, y);
        if (!nearest) return;
        ASSERT_GT(depth.depths[k], 0.0f);
        ASSERT_TRUE(*nearest > mpq_class(double(depth.distances[k]))) << "slot " << slot << ", pixel " << k;
      });
    }
  }
  EXPECT_GT(hidden, 150u);
  EXPECT_GT(open, 150u);
  EXPECT_LE(other, (hidden + open) / 50);
  RecordProperty("boxes", int(hidden + open));
  RecordProperty("hidden", int(hidden));
  RecordProperty("other_than_on_the_cpu", int(other));
}

/// As the CPU's test, in images whose pyramids have many levels; and the first pass draws what was open before, the
/// second all else, whatever has changed since.
TEST_P(GpuDrawnItems, DrawsInTwoPassesWhatIsNotOccluded) {
  std::size_t boxes = 0, hidden = 0, other = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    core::Scene scene;
    const core::NodeId node = scene.add_node(scene.root());
    for (int i = 0; i < 4000; ++i) {
      const float size = float(magnitude(random, 1e-2, 2.0));
      const core::Affine place = core::translation(point(random, 30.0));
      chance(random, 0.1) ? scene.add_primitive(node, core::Line{-size, size}, place)
                          : scene.add_primitive(node, core::Box{size, size, size}, place);
    }
    ASSERT_TRUE(scene.commit());
    Rig rig(*context, scene, GetParam());
    std::vector<Slot> open_before;
    for (int i = 0; i < 8; ++i) {
      SCOPED_TRACE(testing::Message() << "frame " << i);
      if (i == 3) {  // moved, hidden and new items, and a layer that was not in use
        for (int k = 0; k < 100; ++k) {
          scene.set_placement(core::ItemId(2 * k), core::translation(point(random, 30.0)));
          scene.set_visible(core::ItemId(2 * k + 1), false);
          scene.add_primitive(scene.root(), core::Box{1, 1, 1}, core::translation(point(random, 30.0)));
        }
        if (seed % 2 == 0) {
          const core::NodeId other_layer = scene.add_node(scene.root());
          scene.set_layers(other_layer, 2);
          scene.add_primitive(other_layer, core::Box{1, 1, 1});
          open_before.clear();  // the culler makes everything anew
        }
        rig.apply(*scene.commit());
      }
      const core::Pose pose{point(random, 60.0), core::dvec3(0.0), {0, 0, 1}};
      const View view = chance(random, 0.3) ? *View::orthographic(pose, 40.0, 1.5, -100.0, 100.0)
                                            : *View::perspective(pose, 1.0, 1.5, 0.1);
      const int width = whole(random, 1, 300), height = whole(random, 1, 200);
      std::vector<float> depths(std::size_t(width) * std::size_t(height));
      const double wall = uniform(random, 20.0, 80.0);
      for (float& depth : depths)
        depth = chance(random, 1e-4) ? 0.0f : depth_of(view, wall * uniform(random, 1.0, 1.1));
      const DepthTexture depth(gl(), view, width, height, std::move(depths));
      const std::vector<Slot> in_view = rig.cull(view);
      rig.context->functions().Finish();
      (void)rig.culler.take_feedback();
      culling::DepthPyramid pyramid;
      pyramid.build(depth.distances, width, height);
      const core::dvec3& origin = rig.snapshot.bounds().origin;
      const culling::OcclusionTest test(view, origin, width, height, pyramid,
                                        render::RenderTarget::orthographic_error(view));
      const SampleTest sampled(view, origin, {width, height, {{0, 0}}});
      const OcclusionFrame frame(rig, view, depth, in_view.size());
      const auto has = [](const std::vector<Slot>& slots, Slot slot) {
        return std::binary_search(slots.begin(), slots.end(), slot);
      };
      std::vector<Slot> open;
      for (const Slot slot : in_view) {
        const bool line = rig.snapshot.kind(slot) == core::Kind::kLine;
        const core::Aabb box = rig.snapshot.bounds().box(slot);
        const bool hides = !line && test.occluded(box), covers = line || sampled.covers(box);
        if (!hides && !line) open.push_back(slot);
        const bool first = line || (covers && has(open_before, slot)), second = !first && !hides;
        other += has(frame.first, slot) != first || has(frame.others, slot) != second;
        ASSERT_FALSE(has(frame.first, slot) && has(frame.others, slot)) << slot;
        hidden += hides;
      }
      boxes += in_view.size();
      open_before = std::move(open);
      EXPECT_TRUE(std::includes(in_view.begin(), in_view.end(), frame.others.begin(), frame.others.end()));
      const OcclusionFrame again(rig, view, depth, in_view.size());
      EXPECT_TRUE(again.others.empty()) << "all that is open was drawn first";
    }
  }
  EXPECT_GT(hidden, boxes / 5);
  EXPECT_LT(hidden, boxes * 4 / 5);
  EXPECT_LE(other, boxes / 100) << "the CPU also tests the rays of few pixels";
  RecordProperty("boxes", int(boxes));
  RecordProperty("other_than_on_the_cpu", int(other));
}

}  // namespace
}  // namespace sightline::tests::gpu_drawn_items_test
