// The GPU culler against the linear one: nothing lost, what is extra lies within the float planes' band; through edits,
// layers, section planes; and on its way to the draw nothing asks the GPU for an answer.
#include "sightline/culling/gpu/internal/gpu_culler.h"

#include "gpu_rig.h"
#include "scenes.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/tests/support/gl_test.h"
#include "sightline/tests/support/gl_watch.h"

namespace sightline::gpu_culler_test {
namespace {

using core::Affine;
using core::dvec3;
using core::Slot;
using core::View;
using culling::GpuCuller;
using culling::GpuCullerConfig;
using culling::GpuVariant;
using tests::all_gpu_configs;
using tests::chance;
using tests::expect_same;
using tests::gpu_config_name;
using tests::magnitude;
using tests::point;
using tests::Random;
using tests::Rig;
using tests::uniform;
using tests::whole;

/// Items of every batch, most of them small. Meshes go where tessellated kinds go.
core::ItemId add_any(Random& random, core::Scene& scene, core::NodeId node, const dvec3& place, double size,
                     bool tessellated = true) {
  static const core::Primitive kinds[] = {core::Box{1, 1, 1},
                                          core::CircularTorus{0.4f, 0.2f, 3},
                                          core::EllipticalDish{0.6f, 0.4f},
                                          core::SphericalDish{0.6f, 0.3f},
                                          core::Snout{0.6f, 0.3f, 1, 0, 0, 0, 0, 0, 0},
                                          core::Cylinder{0.5f, 1},
                                          core::Sphere{1},
                                          core::Line{-0.5f, 0.5f},
                                          core::Pyramid{1, 1, 0.5f, 0.5f, 0, 0, 1},
                                          core::RectangularTorus{0.3f, 0.6f, 0.4f, 3}};
  Affine placement = core::translation(place);
  for (int i = 0; i < 3; ++i) placement.linear[i][i] = size * magnitude(random, 0.1, 10.0);
  return scene.add_primitive(node, kinds[whole(random, 0, tessellated ? 9 : 7)], placement);
}

core::MeshId add_point_mesh(core::Scene& scene, const core::vec3& size) {
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, size, {size.x, 0, 0}};
  mesh.indices = {0, 1, 2};
  return scene.add_mesh(mesh).value();
}

/// Every test is for all ways to cull.
class GpuCullerTest : public tests::GlTest, public testing::WithParamInterface<GpuCullerConfig> {};

constexpr GpuVariant kVariants[] = {GpuVariant::kGeometry, GpuVariant::kCompute};
INSTANTIATE_TEST_SUITE_P(All, GpuCullerTest, testing::ValuesIn(all_gpu_configs()), gpu_config_name);

TEST_P(GpuCullerTest, FindsWhatTheCpuFinds) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    core::Scene scene;
    const dvec3 site = seed % 2 ? dvec3(0.0) : point(random, 1e7);
    const double half = magnitude(random, 1.0, 1e3);
    for (int i = 0; i < 3000; ++i)
      add_any(random, scene, scene.root(), site + point(random, half), half * magnitude(random, 1e-4, 0.1));
    ASSERT_TRUE(scene.commit());
    Rig rig(*context, scene, GetParam());
    std::size_t extra = 0, found = 0;
    for (int i = 0; i < 12; ++i) {
      SCOPED_TRACE("view " + std::to_string(i));
      View view = tests::random_view(random, site, half);
      if (chance(random, 0.5)) tests::add_sections(random, site, half, view);
      extra += expect_same(gl(), rig, view);
      found += rig.cull_linear(view).size();
    }
    EXPECT_GT(found, 100u);
    EXPECT_LE(extra, 3u);
  }
}

/// Boxes without size, of denormals, huge, long, and such that touch the planes of the view or miss them by a bit.
TEST_P(GpuCullerTest, LosesNothingAtThePlanes) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    core::Scene scene;
    const dvec3 site = seed % 2 ? dvec3(0.0) : dvec3(1e7, -1e7, 1e3);
    const double half = magnitude(random, 1.0, 1e3);
    View view = tests::random_view(random, site, half);
    if (seed % 3 == 0) tests::add_sections(random, site, half, view);
    std::vector<core::Plane> planes;
    for (const core::Plane& plane : core::frustum_planes(view.clip_from_world(), view.clip_depth()))
      if (plane.normal != dvec3(0.0)) planes.push_back(plane);
    for (const core::Plane& plane : view.sections)
      if (plane.normal != dvec3(0.0)) planes.push_back(plane);
    const float sizes[] = {0.0f, 1e-42f, 1e-6f, 1.0f, float(half), 1e12f};
    const bool with_huge = seed > 4;  // they widen the band for all
    for (int i = 0; i < 1200; ++i) {
      const core::Plane& plane = planes[std::size_t(whole(random, 0, int(planes.size()) - 1))];
      const dvec3 a = glm::abs(plane.normal);
      const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
      dvec3 p = site + point(random, half);
      p[axis] = 0.0;
      p[axis] = -(glm::dot(plane.normal, p) + plane.offset) / plane.normal[axis];
      if (!core::is_finite(p) || glm::length(p - site) > 100.0 * half) continue;
      const float outwards = plane.normal[axis] > 0.0 ? -1.0f : 1.0f;
      core::vec3 size(0.0f);
      for (int k = 0; k < 3; ++k)
        size[k] = (plane.normal[k] > 0.0 ? -1.0f : 1.0f) * sizes[std::size_t(whole(random, 0, with_huge ? 5 : 4))];
      p[axis] += outwards * half * (chance(random, 0.3) ? 0.0 : magnitude(random, 1e-12, 1e-5)) *
                 (chance(random, 0.5) ? 1.0 : -1.0);
      scene.add_mesh_instance(scene.root(), add_point_mesh(scene, size), core::translation(p));
    }
    ASSERT_TRUE(scene.commit());
    Rig rig(*context, scene, GetParam());
    expect_same(gl(), rig, view);
    EXPECT_FALSE(rig.cull_linear(view).empty());
  }
}

TEST_P(GpuCullerTest, LooksAtLayers) {
  Random random(5);
  core::Scene scene;
  for (int layer = 0; layer < 4; ++layer) {
    const core::NodeId node = scene.add_node(scene.root());
    if (layer > 0) scene.set_layers(node, std::uint32_t(layer));
    for (int i = 0; i < 400; ++i) add_any(random, scene, node, point(random, 20.0), 1.0);
  }
  ASSERT_TRUE(scene.commit());
  Rig rig(*context, scene, GetParam());
  std::size_t found = 0;
  for (std::uint32_t layers = 0; layers < 6; ++layers) {
    View view = *View::perspective({{0, -40, 0}, {0, 0, 0}, {0, 0, 1}}, 0.7, 1.0, 0.1);
    view.layers = layers;
    expect_same(gl(), rig, view);
    found += rig.cull_linear(view).size();
  }
  EXPECT_GT(found, 1000u);
}

TEST_P(GpuCullerTest, FollowsEdits) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    core::Scene scene;
    std::vector<core::NodeId> nodes;
    nodes.reserve(40);
    for (int i = 0; i < 40; ++i) nodes.push_back(scene.add_node(scene.root()));
    const core::MeshId mesh = add_point_mesh(scene, {1, 1, 1});
    for (int i = 0; i < 2000; ++i)
      add_any(random, scene, nodes[std::size_t(whole(random, 0, 39))], point(random, 20.0), 1.0, false);
    for (int i = 0; i < 300; ++i) scene.add_mesh_instance(scene.root(), mesh, core::translation(point(random, 20.0)));
    ASSERT_TRUE(scene.commit());
    Rig rig(*context, scene, GetParam());
    for (int round = 0; round < 12; ++round) {
      SCOPED_TRACE("round " + std::to_string(round));
      for (int i = 0; i < 12; ++i) {
        const core::ItemId item = core::ItemId(whole(random, 0, int(scene.item_slots()) - 1));
        if (!scene.contains_item(item)) continue;
        const dvec3 place = point(random, chance(random, 0.3) ? 300.0 : 20.0);  // far ones go to chunks of their own
        switch (whole(random, 0, 4)) {
          case 0:
            scene.set_placement(item, core::translation(place));
            break;
          case 1:
            scene.set_visible(item, !scene.item_visible(item));
            break;
          case 2:
            scene.remove_item(item);
            break;
          case 3:
            scene.add_mesh_instance(scene.root(), mesh, core::translation(place));
            break;
          default:
            add_any(random, scene, nodes[0], place, 0.5, false);
            break;
        }
      }
      if (round == 6) scene.set_layers(nodes[1], 2);  // until now no item was off the model layer
      auto delta = scene.commit();
      ASSERT_TRUE(delta);
      rig.apply(*delta);
      if (HasFatalFailure()) return;
      View view = tests::random_view(random, dvec3(0.0), chance(random, 0.5) ? 300.0 : 20.0);
      if (chance(random, 0.3)) view.layers = 2;
      expect_same(gl(), rig, view);
      // And at the newest item, which may lie where there was nothing before.
      Slot newest = Slot(rig.snapshot.size() - 1);
      while (rig.snapshot.vacant(newest)) --newest;
      const core::Aabb box = rig.snapshot.bounds().box(newest);
      const dvec3 there = rig.snapshot.bounds().origin + 0.5 * (dvec3(box.min) + dvec3(box.max));
      expect_same(gl(), rig, *View::perspective({there - dvec3(0, 5, 0), there, {0, 0, 1}}, 0.3, 1.0, 0.1));
    }
  }
}

TEST_P(GpuCullerTest, ScenesOfNothingAndOfOne) {
  core::Scene scene;
  const View view = *View::perspective({{0, -5, 0}, {0, 0, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1);
  Rig empty(*context, scene, GetParam());
  EXPECT_TRUE(empty.cull(view).empty());
  const core::ItemId item = scene.add_primitive(scene.root(), core::Cylinder{1, 2});
  ASSERT_TRUE(scene.commit());
  Rig one(*context, scene, GetParam());
  EXPECT_EQ(one.cull(view).size(), 1u);
  scene.set_visible(item, false);
  one.apply(*scene.commit());
  EXPECT_TRUE(one.cull(view).empty());
  View behind = *View::perspective({{0, -5, 0}, {0, -9, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1);
  EXPECT_TRUE(one.cull(behind).empty());
}

/// What a culler has left in the draw lists, in their order.
struct Written {
  std::vector<std::uint32_t> counts, commands, records;

  explicit Written(const Rig& rig) {
    const auto read = [](const gl::Functions& gl, GLuint buffer, std::size_t offset, std::size_t words, auto& out) {
      const std::size_t old = out.size();
      out.resize(old + words);
      if (words > 0) gl.GetNamedBufferSubData(buffer, GLintptr(offset), GLsizeiptr(4 * words), out.data() + old);
    };
    const gl::Functions& gl = rig.context->functions();
    read(gl, rig.lists.counts().id(), 0, 2 * gpuscene::kBatchKindCount, counts);
    for (const gpuscene::Batch& batch : rig.gpu.batches()) {
      const auto kind = std::size_t(batch.kind);
      const auto target = rig.lists.target(batch.kind);
      const auto& section = rig.lists.section(batch.kind);
      const bool meshes = batch.kind == gpuscene::BatchKind::kMesh;
      // In record batches, commands that are not in use count as well: where nobody counts they are drawn.
      const std::size_t drawn = meshes ? counts[2 * kind] : std::size_t(section.count);
      read(gl, rig.lists.commands().id(), section.offset, 5 * drawn, commands);
      if (!meshes) read(gl, target.buffer, target.offset, counts[2 * kind + 1], records);
    }
  }
  bool operator==(const Written&) const = default;
};

class GpuVariants : public tests::GlTest {};

/// Not only the same set: the same bytes, so that no pixel depends on the variant. Batches of many blocks of 2048
/// records.
TEST_F(GpuVariants, WriteTheSameLists) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    core::Scene scene;
    for (int i = 0; i < 6000 * int(seed); ++i)
      scene.add_primitive(scene.root(), core::Cylinder{0.5f, 1}, core::translation(point(random, 100.0)));
    for (int i = 0; i < 4000; ++i) add_any(random, scene, scene.root(), point(random, 100.0), 1.0);
    const core::MeshId mesh = add_point_mesh(scene, {1, 1, 1});
    for (int i = 0; i < 5000; ++i) scene.add_mesh_instance(scene.root(), mesh, core::translation(point(random, 100.0)));
    ASSERT_TRUE(scene.commit());
    Rig geometry(*context, scene, {GpuVariant::kGeometry}), compute(*context, scene, {GpuVariant::kCompute});
    EXPECT_EQ(geometry.culler.variant(), GpuVariant::kGeometry);
    EXPECT_EQ(compute.culler.variant(), GpuVariant::kCompute);
    for (int i = 0; i < 8; ++i) {
      SCOPED_TRACE("view " + std::to_string(i));
      View view = tests::random_view(random, dvec3(0.0), 100.0);
      const std::size_t found = geometry.cull(view).size();
      EXPECT_EQ(compute.cull(view).size(), found);
      if (found > 0) {
        EXPECT_TRUE(Written(geometry) == Written(compute));
      }
    }
  }
}

TEST_F(GpuVariants, AreChosenByMeasuring) {
  Random random(9);
  core::Scene scene;
  for (int i = 0; i < 3000; ++i) add_any(random, scene, scene.root(), point(random, 50.0), 1.0);
  ASSERT_TRUE(scene.commit());
  Rig measured(*context, scene, {});
  EXPECT_TRUE(measured.culler.why_this_variant().starts_with("measured: geometry "))
      << measured.culler.why_this_variant();
  EXPECT_FALSE(measured.culler.take_feedback()) << "of the measuring";
  const View view = *View::perspective({{0, -40, 0}, {0, 0, 0}, {0, 0, 1}}, 0.7, 1.0, 0.1);
  expect_same(gl(), measured, view);
  for (const GpuVariant variant : kVariants) {
    Rig named(*context, scene, {variant});
    EXPECT_EQ(named.culler.variant(), variant);
    EXPECT_EQ(named.culler.why_this_variant(), "asked for");
  }
  const core::Scene nothing;
  Rig empty(*context, nothing, {});
  EXPECT_TRUE(empty.culler.why_this_variant().starts_with("not measured: "));
  EXPECT_TRUE(measured.culler.variant_settled() && !empty.culler.variant_settled());
  EXPECT_TRUE(empty.cull(view).empty());
}

/// Where a context's storage blocks are too small for a batch, the other variant does.
TEST_F(GpuVariants, ComputeNeedsItsStorageBlocks) {
  core::Scene scene;
  for (int i = 0; i < 3000; ++i)
    scene.add_primitive(scene.root(), core::Cylinder{0.5f, 1}, core::translation({double(i), 0, 0}));
  ASSERT_TRUE(scene.commit());
  auto& capabilities = const_cast<gl::Capabilities&>(context->capabilities());
  const auto limit = std::exchange(capabilities.max_storage_block_bytes, 8192);
  core::Snapshot snapshot(scene);
  auto gpu = gpuscene::GpuScene::create(*context, snapshot);
  const auto asked = GpuCuller::create(*context, snapshot, *gpu, {GpuVariant::kCompute});
  ASSERT_FALSE(asked);
  EXPECT_NE(asked.error().message.find("8192"), std::string::npos) << asked.error().message;
  const auto any = GpuCuller::create(*context, snapshot, *gpu, {});
  ASSERT_TRUE(any);
  EXPECT_EQ(any->variant(), GpuVariant::kGeometry);
  EXPECT_NE(any->why_this_variant().find("8192"), std::string::npos) << any->why_this_variant();
  capabilities.max_storage_block_bytes = limit;
}

/// With no far plane in reach nothing is drawn, and the feedback says so.
TEST_P(GpuCullerTest, AViewOfNothingDrawsNothing) {
  core::Scene scene;
  ASSERT_TRUE(importers::generate_plant({3000, 1}, scene));
  ASSERT_TRUE(scene.commit());
  Rig rig(*context, scene, GetParam());
  View view = *View::perspective({{0, -50, 0}, {0, 0, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1);
  EXPECT_FALSE(rig.cull(view).empty());
  view.layers = 0;
  EXPECT_TRUE(rig.cull(view).empty());
  for (const gpuscene::Batch& batch : rig.gpu.batches()) EXPECT_EQ(rig.lists.section(batch.kind).count, 0);
  gl().Finish();
  const auto first = rig.culler.take_feedback(), second = rig.culler.take_feedback();
  ASSERT_TRUE(first && second);
  EXPECT_GT(first->visible, 0u);
  EXPECT_EQ(second->visible, 0u);
  EXPECT_FALSE(rig.culler.take_feedback());
}

/// Results that nobody takes are kept for the first frames, later ones are lost; after that they come again.
TEST_P(GpuCullerTest, FeedbackWaitsToBeTaken) {
  core::Scene scene;
  ASSERT_TRUE(importers::generate_plant({3000, 1}, scene));
  ASSERT_TRUE(scene.commit());
  Rig rig(*context, scene, GetParam());
  View views[2] = {*View::perspective({{0, -50, 0}, {0, 0, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1),
                   *View::perspective({{0, 3, 2}, {0, 0, 0}, {0, 0, 1}}, 0.3, 1.0, 0.1)};
  std::size_t visible[2];
  for (int i = 0; i < 2; ++i) visible[i] = rig.cull(views[i]).size();
  gl().Finish();
  while (rig.culler.take_feedback()) {
  }
  for (const std::uint64_t first : {0u, 100u}) {
    for (std::uint64_t frame = first; frame < first + 20; ++frame)
      ASSERT_TRUE(rig.culler.cull(views[frame % 2], rig.snapshot, rig.gpu, rig.lists, {frame}));
    gl().Finish();
    std::uint64_t frame = first;
    for (; const auto feedback = rig.culler.take_feedback(); ++frame) {
      EXPECT_EQ(feedback->frame, frame);
      EXPECT_EQ(feedback->visible, visible[frame % 2]);
    }
    EXPECT_EQ(frame, first + gl::GpuTimer::kSlots);
  }
}

constexpr double kAspect = double(tests::ImagePair::kWidth) / tests::ImagePair::kHeight;

// --- images ----------------------------------------------------------------------------------------------------------

class GpuCullerImages : public GpuCullerTest {
 protected:
  void expect_same_images(const core::Scene& scene, const std::vector<View>& views) {
    Rig rig(*context, scene, GetParam());
    tests::ImagePair images(*context, rig);
    for (const View& view : views) {
      core::VisibleSet set;
      culling::LinearCuller(rig.snapshot.bounds()).cull(view, set);
      const auto [shown, ties] = images.expect_same(rig, view, set);
      EXPECT_GT(shown, 100u);
      EXPECT_LE(ties, shown / 50);
    }
  }

  static std::vector<View> plant_views() {
    std::vector<View> views;
    for (const auto& [eye, target] : {std::pair{dvec3(-60, -60, 50), dvec3(0, 0, 5)},
                                      {dvec3(5, -20, 4), dvec3(-10, 10, 3)},
                                      {dvec3(-20, 1, 2), dvec3(20, 2, 3)},
                                      {dvec3(0, 0, 30), dvec3(0.1, 0, 0)}})
      views.push_back(*View::perspective({eye, target, {0, 0, 1}}, 1.0, kAspect, 0.1));
    return views;
  }

  /// A plant, and of every batch kind that it lacks something.
  static void make_plant(core::Scene& scene) {
    ASSERT_TRUE(importers::generate_plant({6000, 3}, scene));
    Random random(3);
    for (int i = 0; i < 600; ++i)
      add_any(random, scene, scene.root(), point(random, 20.0) + dvec3(0, 0, 15), magnitude(random, 0.05, 1.0));
    ASSERT_TRUE(scene.commit());
  }
};

INSTANTIATE_TEST_SUITE_P(All, GpuCullerImages, testing::ValuesIn(all_gpu_configs()), gpu_config_name);

TEST_P(GpuCullerImages, AreThoseOfTheCpu) {
  core::Scene scene;
  make_plant(scene);
  expect_same_images(scene, plant_views());
}

/// Without ARB_indirect_parameters.
TEST_P(GpuCullerImages, NeedNoCountOfCommands) {
  auto& table = const_cast<gl::Functions&>(context->functions());
  const auto taken = std::exchange(table.MultiDrawElementsIndirectCountARB, nullptr);
  core::Scene scene;
  make_plant(scene);
  expect_same_images(scene, plant_views());
  table.MultiDrawElementsIndirectCountARB = taken;
}

// --- no read-back ----------------------------------------------------------------------------------------------------

TEST_P(GpuCullerImages, NothingIsReadBackFromCullToDraw) {
  core::Scene scene;
  make_plant(scene);
  Rig rig(*context, scene, GetParam());
  auto renderer = render::Renderer::create(*context, rig.gpu);
  auto target =
      render::RenderTarget::create(*context, tests::ImagePair::kWidth, tests::ImagePair::kHeight, {.ids = true});
  ASSERT_TRUE(renderer && target);
  const auto frames = [&] {
    for (const View& view : plant_views()) {
      ASSERT_TRUE(rig.culler.cull(view, rig.snapshot, rig.gpu, rig.lists));
      ASSERT_TRUE(renderer->draw(view, rig.snapshot, rig.gpu, rig.lists, *target));
      const GpuCuller::Image image{view, {target->width(), target->height(), {{0, 0}}}, true};
      ASSERT_TRUE(rig.culler.cull(view, rig.snapshot, rig.gpu, rig.lists, {0, &image}));
      ASSERT_TRUE(renderer->draw(view, rig.snapshot, rig.gpu, rig.lists, *target));
      ASSERT_TRUE(rig.culler.cull_others(image, rig.gpu, rig.lists, target->depth(), 0.0));
      ASSERT_TRUE(renderer->draw({view, rig.snapshot, rig.gpu, rig.lists, *target}));
      while (rig.culler.take_feedback()) {
      }
    }
  };
  frames();  // the first makes buffers and programs
  {
    const tests::Watch watch(const_cast<gl::Functions&>(context->functions()));
    frames();
    for (const auto& [name, count] : tests::Watch::calls) ADD_FAILURE() << name << " called " << count << " times";
    rig.culler.read_back(rig.lists);
    EXPECT_GT(tests::Watch::calls["GetNamedBufferSubData"], 0) << "the watch sees nothing";
  }
}

}  // namespace
}  // namespace sightline::gpu_culler_test
