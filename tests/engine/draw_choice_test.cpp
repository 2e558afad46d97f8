// Which triangles of meshes are drawn: faces that are left out are those that do not show.
#include "sightline/engine/drawing/internal/draw_choice.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/render/internal/renderer.h"
#include "sightline/tests/lod/mesh_samples.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::draw_choice_test {
namespace {

using core::dvec3;
using core::View;
using core::VisibleSet;

/// All that it takes to draw a scene.
struct Stage {
  Stage(const gl::Context& context, const core::Scene& scene, int width, int height)
      : snapshot(scene),
        gpu(std::move(*gpuscene::GpuScene::create(context, snapshot))),
        lists(std::move(*gpuscene::DrawLists::create(context, gpu))),
        renderer(std::move(*render::Renderer::create(context, gpu, {.ids = true}))),
        target(std::move(*render::RenderTarget::create(context, width, height, {.ids = true}))) {}

  VisibleSet all() const {
    VisibleSet set;
    set.ranges = {{0, std::uint32_t(snapshot.size())}};
    return set;
  }
  std::vector<std::uint32_t> ids(const View& view) {
    EXPECT_TRUE(renderer.draw(view, snapshot, gpu, lists, target));
    return target.read_ids().ids;
  }

  core::Snapshot snapshot;
  gpuscene::GpuScene gpu;
  gpuscene::DrawLists lists;
  engine::DrawChoice choice;
  render::Renderer renderer;
  render::RenderTarget target;
};

/// Solids as meshes, some mirrored, some open, some bent.
class FrontFaces : public tests::GlTest {
 protected:
  static constexpr int kWidth = 160, kHeight = 120;

  core::MeshId mesh_of(const core::Primitive& primitive, gpuprims::Caps caps = {}) {
    return scene.add_mesh(gpuprims::tessellate(primitive, {.fixed_segments = 24}, caps)).value();
  }

  void SetUp() override {
    tests::GlTest::SetUp();
    const core::MeshId box = mesh_of(core::Box{1.0f, 1.4f, 0.8f}), ball = mesh_of(core::Sphere{1.2f}),
                       ring = mesh_of(core::CircularTorus{0.5f, 0.2f, 6.2831853f}),
                       pipe = mesh_of(core::Cylinder{0.4f, 1.0f}, {.bottom = false, .top = false});
    core::dmat3 turned(glm::normalize(dvec3(1, 2, 0)), glm::normalize(dvec3(-2, 1, 0)), dvec3(0, 0, 1));
    core::dmat3 mirrored = turned;
    mirrored[0] = -mirrored[0];
    int i = 0;
    for (const core::MeshId mesh : {box, ball, ring, pipe})
      for (const core::dmat3& linear : {core::dmat3(1.0), turned, mirrored}) {
        core::Affine place = core::translation(kCentre + dvec3(1.7 * (i % 4), 1.9 * (i / 4), 0.3 * (i % 3)));
        place.linear = linear;
        scene.add_mesh_instance(scene.root(), mesh, place);
        ++i;
      }
    EXPECT_TRUE(scene.commit());
  }

  /// With and without the faces that are thought not to show; returns how many commands had them left out.
  int expect_same(Stage& stage, const View& view) {
    EXPECT_TRUE(stage.lists.update(stage.snapshot, stage.gpu, stage.all()));
    EXPECT_EQ(stage.lists.section(gpuscene::BatchKind::kMesh).front_only, 0);
    const std::vector<std::uint32_t> all = stage.ids(view);
    const auto all_colours = stage.target.read_colour().pixels;
    EXPECT_GT(std::count_if(all.begin(), all.end(), [](std::uint32_t id) { return id != 0; }), 500);
    EXPECT_TRUE(stage.choice.update(stage.lists, stage.gpu, stage.snapshot, stage.all(), {view}));
    EXPECT_EQ(stage.ids(view), all);
    EXPECT_EQ(stage.target.read_colour().pixels, all_colours);
    return stage.lists.section(gpuscene::BatchKind::kMesh).front_only;
  }

  static constexpr dvec3 kCentre{4000.0, -300.0, 20.0};
  static constexpr int kSolids = 4;  // boxes and balls that are not mirrored
  core::Scene scene;
};

TEST_F(FrontFaces, ShowAsMuchAsBoth) {
  Stage stage(*context, scene, kWidth, kHeight);
  const dvec3 middle = kCentre + dvec3(2.5, 2.0, 0.3);
  for (const dvec3& eye : {dvec3(0.3, -6, 3), dvec3(5, 5, 4), dvec3(-6, 1, -4), dvec3(0.5, 0.2, 9)}) {
    EXPECT_EQ(expect_same(stage, *View::perspective({middle + eye, middle, {0, 0, 1}}, 0.9, 4.0 / 3.0, 0.1)), kSolids);
    EXPECT_EQ(expect_same(stage, *View::orthographic({middle + eye, middle, {0, 0, 1}}, 8.0, 4.0 / 3.0, 0.0, 30.0)),
              kSolids);
  }
}

TEST_F(FrontFaces, OpenForAnEyeWithinAndForNearPlanesThatCut) {
  Stage stage(*context, scene, kWidth, kHeight);
  const dvec3 within = kCentre + dvec3(0.1, 0.2, 0.1);  // of the first box
  EXPECT_LT(expect_same(stage, *View::perspective({within, within + dvec3(1, 1, 0), {0, 0, 1}}, 0.9, 4.0 / 3.0, 0.01)),
            kSolids);
  const dvec3 middle = kCentre + dvec3(2.5, 2.0, 0.3), eye = middle + dvec3(0.3, -6, 3);
  for (const double near : {5.5, 6.0, 6.5})
    EXPECT_LT(expect_same(stage, *View::perspective({eye, middle, {0, 0, 1}}, 0.9, 4.0 / 3.0, near)), kSolids);
}

TEST_F(FrontFaces, AreAllThatCountsNeitherWithSectionsNorInMirroredViews) {
  Stage stage(*context, scene, kWidth, kHeight);
  const dvec3 middle = kCentre + dvec3(2.5, 2.0, 0.3), eye = middle + dvec3(0.3, -6, 3);
  View cut = *View::perspective({eye, middle, {0, 0, 1}}, 0.9, 4.0 / 3.0, 0.1);
  core::dmat4 mirror(1.0);
  mirror[0][0] = -1.0;
  const View mirrored = *View::from_matrices(mirror * cut.eye_from_world(), cut.clip_from_eye(), cut.clip_depth());
  const View flipped = *View::from_matrices(cut.eye_from_world(), cut.clip_from_eye() * mirror, cut.clip_depth());
  EXPECT_EQ(expect_same(stage, mirrored), 0);
  EXPECT_EQ(expect_same(stage, flipped), 0);
  cut.sections = {{{1, 0, 0}, -middle.x}};
  EXPECT_EQ(expect_same(stage, cut), 0);
}

/// A mesh with a solid and an open shell takes two commands.
TEST_F(FrontFaces, OfAMeshThatIsSolidInPart) {
  core::Mesh mesh = gpuprims::tessellate(core::Primitive(core::Cylinder{0.4f, 1.0f}), {.fixed_segments = 24},
                                         {.bottom = false, .top = false});
  const core::Mesh box = gpuprims::tessellate(core::Primitive(core::Box{0.3f, 0.3f, 0.9f}));
  const auto first = std::uint32_t(mesh.positions.size());
  for (std::size_t i = 0; i < box.positions.size(); ++i) {
    mesh.positions.push_back(box.positions[i] + core::vec3(1.0f, 0.0f, 0.0f));
    mesh.normals.push_back(box.normals[i]);
  }
  for (const std::uint32_t i : box.indices) mesh.indices.push_back(first + i);
  core::Scene parts;
  parts.add_mesh_instance(parts.root(), parts.add_mesh(mesh).value());
  ASSERT_TRUE(parts.commit());
  Stage stage(*context, parts, kWidth, kHeight);
  const View view = *View::perspective({{0.5, -3, 1.5}, {0.5, 0, 0}, {0, 0, 1}}, 0.8, 4.0 / 3.0, 0.1);
  EXPECT_EQ(expect_same(stage, view), 1);
  EXPECT_EQ(stage.lists.section(gpuscene::BatchKind::kMesh).count, 2);
}

/// What draws meshes with levels, some of them so large that all threads choose their cuts.
class Cuts : public testing::Test {
 protected:
  Cuts() {
    std::mt19937 random(7);
    for (const std::uint32_t cells : {8u, 30u, 260u}) {
      meshes.push_back(std::make_shared<core::Mesh>(tests::bumpy_torus(cells, 0.1)));
      levels.push_back(lod::build_levels(*meshes.back()));
      ids.push_back(scene.add_mesh(*meshes.back()).value());
    }
    std::uniform_real_distribution<double> side(-60.0, 60.0);
    for (int i = 0; i < 400; ++i) {
      const bool large = i % 150 == 0;
      scene.add_mesh_instance(scene.root(), ids[large ? 2 : std::size_t(i % 2)],
                              core::translation({side(random), side(random), side(random)}));
    }
    EXPECT_TRUE(scene.commit());
    snapshot.emplace(scene);
    for (core::Slot slot = 0; slot < snapshot->size(); ++slot) slots.push_back(slot);
  }

  gpuscene::DrawnMesh drawn(core::Slot slot) const {
    const std::size_t count = snapshot->mesh(slot).indices.size();
    for (std::size_t i = 0; i < meshes.size(); ++i)
      if (meshes[i]->indices.size() == count)
        return {{std::uint32_t(count), 1, 0, 0, slot}, &levels[i], levels[i].solid_indices};
    return {};
  }
  template <class T>
  static std::vector<T> joined(gpuscene::MeshDraws::Runs<T> runs) {
    std::vector<T> all;
    for (const std::span<const T>& run : runs) all.insert(all.end(), run.begin(), run.end());
    return all;
  }
  struct Chosen {
    std::vector<gpuscene::ElementsCommand> fronts, both_faces;
    std::vector<std::uint32_t> indices;
    std::array<std::int64_t, 4> counts;
    double error;
    bool operator==(const Chosen&) const = default;
  };
  Chosen choose(engine::DrawChoice& choice, const View& view, bool tests_triangles, core::ThreadPool* threads) const {
    const lod::ImageError error(view, 640, 360, 1.0);
    const culling::TriangleTest triangles(view, {640, 360, {{0, 0}}, 0.0f});
    const auto draws = choice.choose(
        *snapshot, slots, [&](core::Slot slot) { return drawn(slot); },
        {.view = view, .error = &error, .triangles = tests_triangles ? &triangles : nullptr, .threads = threads});
    const engine::MeshCounts& counts = choice.counts();
    return {joined(draws.fronts),
            joined(draws.both_faces),
            joined(draws.indices),
            {counts.items, counts.coarser, counts.triangles, counts.full_triangles},
            counts.error};
  }

  std::vector<std::shared_ptr<const core::Mesh>> meshes;
  std::vector<lod::MeshLevels> levels;
  std::vector<core::MeshId> ids;
  core::Scene scene;
  std::optional<core::Snapshot> snapshot;
  std::vector<core::Slot> slots;
};

TEST_F(Cuts, AreTheSameForAnyNumberOfThreads) {
  for (const int threads : {2, 3, 5, 16}) {
    core::ThreadPool pool(threads);
    engine::DrawChoice alone, shared;
    for (int i = 0; i < 12; ++i) {
      SCOPED_TRACE(testing::Message() << "threads " << threads << ", view " << i);
      const dvec3 eye = dvec3(100.0, 0.0, 10.0 * i) / (1.0 + i);
      const View view = *View::perspective({eye, {0, 0, 0}, {0, 0, 1}}, 0.9, 16.0 / 9.0, 0.1);
      for (const bool tests_triangles : {false, true}) {
        const Chosen chosen = choose(alone, view, tests_triangles, nullptr);
        ASSERT_GT(chosen.fronts.size() + chosen.both_faces.size(), 20u);
        ASSERT_EQ(chosen.indices.empty(), !tests_triangles);
        ASSERT_TRUE(choose(shared, view, tests_triangles, &pool) == chosen);
      }
    }
  }
}

}  // namespace
}  // namespace sightline::draw_choice_test
