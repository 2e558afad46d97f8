// Each workaround for a faulty driver, forced on, shows what the driver shows without it; kAddBaseVertex stays off,
// since it would be wrong.
#include <gtest/gtest.h>

#include "sightline/culling/gpu/internal/gpu_culler.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/tests/engine/drawn_grid.h"

namespace sightline::tests::workarounds_test {
namespace {

using engine::CullerChoice;
using engine::Engine;

struct Drawn {
  image::Image colour;
  image::IdImage ids;
  image::DepthImage depth;
  std::string variant;
};

class WorkaroundsTest : public DrawnGrid, public testing::WithParamInterface<std::size_t> {
 protected:
  /// Draws with every culler, with occlusion and with several samples, in a context with these switches.
  std::vector<Drawn> draw(const std::string& switches) {
    std::vector<Drawn> all;
    auto made = gl::Context::create_offscreen({.debug = true, .workarounds = switches});
    EXPECT_TRUE(made) << made.error().message;
    if (!made) return all;
    if (watch_functions) watch_functions(const_cast<gl::Functions&>(made->functions()));
    for (const CullerChoice culler : {CullerChoice::kCpu, CullerChoice::kGpu})
      for (const int samples : {1, 4}) {
        core::Scene scene;
        fill(scene, 8);
        add_meshes(scene);
        engine::EngineConfig c = config(culler);
        c.context.application = &*made;
        c.drawing.ids = true;
        c.drawing.samples = samples;
        c.culling.occlusion = engine::OcclusionChoice::kOn;
        auto engine = Engine::create(scene, c);
        EXPECT_TRUE(engine) << engine.error().message;
        if (!engine) return all;
        EXPECT_TRUE(draw_complete(*engine, near_view())) << switches;
        const auto& target = engine::EngineParts::drawing(*engine)->target();
        const auto* gpu = engine::EngineParts::drawing(*engine)->gpu_culler();
        all.push_back({target.read_colour(), target.read_ids(), target.read_depth(near_view()),
                       gpu ? std::to_string(int(gpu->variant())) : std::string()});
        EXPECT_TRUE(made->take_errors().empty()) << switches;
      }
    return all;
  }

 private:
  static core::View near_view() {
    return *core::View::perspective({{-4.0, -3.0, 5.0}, {4.0, 4.0, 4.0}, {0, 0, 1}}, 0.9, 1.5, 0.1);
  }
  static void add_meshes(core::Scene& scene) {
    core::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {0.8f, 0, 0}, {0, 0.8f, 0}, {0, 0, 0.8f}};
    mesh.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const core::MeshId id = *scene.add_mesh(std::move(mesh));
    for (int i = 0; i < 40; ++i)
      scene.add_mesh_instance(scene.root(), id, core::translation({0.2 * i - 2.0, 0.5 * (i % 7), 0.3 * (i % 11)}));
  }
};

TEST_P(WorkaroundsTest, ShowTheSame) {
  const gl::WorkaroundFacts& facts = gl::workaround_facts()[GetParam()];
  const std::string name(facts.name);
  const auto off = draw(name + "=off"), on = draw(name + "=on");
  ASSERT_EQ(on.size(), 4u);
  ASSERT_EQ(off.size(), on.size());
  for (std::size_t i = 0; i < on.size(); ++i) {
    EXPECT_EQ(on[i].ids.ids, off[i].ids.ids) << i;
    EXPECT_EQ(on[i].depth.metres, off[i].depth.metres) << i;
    EXPECT_EQ(image::compare(on[i].colour, off[i].colour)->max, 0) << i;
    EXPECT_GT(std::count_if(on[i].ids.ids.begin(), on[i].ids.ids.end(), [](std::uint32_t id) { return id != 0; }), 4000)
        << i;
    if (facts.workaround == gl::Workaround::kNoFeedback && !on[i].variant.empty()) {
      EXPECT_EQ(on[i].variant, std::to_string(int(culling::GpuVariant::kCompute)));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, WorkaroundsTest, testing::Range<std::size_t>(0, gl::kWorkaroundCount),
                         [](const auto& param) {
                           std::string name(gl::workaround_facts()[param.param].name);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace sightline::tests::workarounds_test
