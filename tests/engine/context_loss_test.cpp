// A context that is lost takes nothing with it but what lay in it: frames go on, culled by the CPU, edits too, and
// where there is a context again the images are what they would have been.
#include <optional>
#include <thread>

#include <gtest/gtest.h>

#include "drawn_grid.h"
#include "sightline/engine/internal/engine_parts.h"

namespace sightline::tests::context_loss_test {
namespace {

using engine::CullerChoice;
using engine::Engine;
using engine::EngineConfig;

class ContextLossTest : public DrawnGrid {
 protected:
  void SetUp() override {
    DrawnGrid::SetUp();
    fill(scene, 22);  // enough for a GPU culler
  }
  EngineConfig switching(CullerChoice culler, gl::Context* used) {
    EngineConfig c = config(culler, 96, 64);
    c.context.application = used;
    switch_often(c);
    return c;
  }
  static image::Image image(Engine& engine) { return engine::EngineParts::drawing(engine)->target().read_colour(); }
  /// The view on an engine of its own whose context is never lost.
  image::Image wanted(const core::View& view) {
    auto twin = Engine::create(scene, switching(CullerChoice::kCpu, nullptr));
    EXPECT_TRUE(twin && twin->frame(view));
    image::Image wanted = image(*twin);
    return wanted;
  }
  void expect_image(Engine& engine, const core::View& view) {
    const image::Image shown = image(engine);
    const auto difference = image::compare(wanted(view), shown);
    ASSERT_TRUE(difference);
    EXPECT_LE(difference->max, 1);  // another order of the items has other last bits
    (void)context->make_current();
  }

  core::Scene scene;
};

TEST_F(ContextLossTest, AnEngineReplacesItsOwnContext) {
  for (const CullerChoice culler : {CullerChoice::kCpu, CullerChoice::kGpu, CullerChoice::kHybrid}) {
    auto engine = Engine::create(scene, switching(culler, nullptr));
    ASSERT_TRUE(engine) << engine.error().message;
    SCOPED_TRACE(name_of(engine->plan().culler));
    ASSERT_TRUE(engine->frame(view(0)));
    const image::Image before = image(*engine);
    lose(engine::EngineParts::drawing(*engine)->context());
    const auto report = engine->frame(view(0));
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->drawn);
    ASSERT_NE(engine::EngineParts::drawing(*engine), nullptr);
    EXPECT_FALSE(engine::EngineParts::drawing(*engine)->context().lost());
    const auto difference = image::compare(before, image(*engine));
    ASSERT_TRUE(difference);
    EXPECT_EQ(difference->max, 0);
    bool gpu = false;
    for (int frame = 0; frame < 8; ++frame) gpu |= engine->frame(view(0.1 * frame))->culler == CullerChoice::kGpu;
    EXPECT_EQ(gpu, culler != CullerChoice::kCpu);
  }
}

TEST_F(ContextLossTest, AnApplicationHandsOverAnother) {
  for (const CullerChoice culler : {CullerChoice::kGpu, CullerChoice::kHybrid}) {
    auto made = gl::Context::create_offscreen();
    ASSERT_TRUE(made);
    auto engine = Engine::create(scene, switching(culler, &*made));
    ASSERT_TRUE(engine);
    SCOPED_TRACE(name_of(engine->plan().culler));
    std::int64_t visible = 0;
    for (int frame = 0; frame < 6; ++frame) ASSERT_TRUE(engine->frame(view(0.1 * frame)));
    lose(*made);
    for (int frame = 0; frame < 3; ++frame) {
      const auto report = engine->frame(view(0));
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_FALSE(report->drawn);
      EXPECT_NE(name_of(report->culler), "gpu");
      EXPECT_GT(report->visible, 1000);
      visible = report->visible;
      EXPECT_EQ(engine::EngineParts::drawing(*engine), nullptr);
      EXPECT_EQ(engine->memory().gpu, 0u);
    }
    made.~expected();  // what an application does with a context that is lost
    new (&made) auto(gl::Context::create_offscreen());
    ASSERT_TRUE(made);

    scene.remove_item(core::ItemId(culler == CullerChoice::kGpu ? 5577 : 5579));
    ASSERT_TRUE(engine->commit());
    EXPECT_EQ(engine->frame(view(0))->visible, visible - 1);
    EXPECT_EQ(engine::EngineParts::drawing(*engine), nullptr) << "the new context was not handed over yet";

    const auto used = engine->use_context(*made);
    ASSERT_TRUE(used) << used.error().message;
    int on_gpu = 0;
    for (int frame = 0; frame < 12; ++frame) {
      const auto report = engine->frame(view(0.1 * frame));
      ASSERT_TRUE(report);
      EXPECT_TRUE(report->drawn);
      on_gpu += report->culler == CullerChoice::kGpu;
    }
    EXPECT_GE(on_gpu, 3);
    expect_image(*engine, view(1.1));
    ASSERT_TRUE(made->make_current());
  }
}

/// Whatever is done before there is a context, images are then those of an engine that had one.
TEST_F(ContextLossTest, TheContextMayComeLater) {
  for (const CullerChoice culler : {CullerChoice::kCpu, CullerChoice::kGpu, CullerChoice::kHybrid}) {
    EngineConfig c = switching(culler, nullptr);
    c.context.later = true;
    std::optional<Engine> engine;
    std::jthread([&] { engine = std::move(Engine::create(scene, c).value()); }).join();
    SCOPED_TRACE(name_of(engine->plan().culler));
    const core::ItemId one{5577};
    ASSERT_TRUE(engine->hide({&one, 1}));
    const auto report = engine->frame(view(0));
    ASSERT_TRUE(report);
    EXPECT_FALSE(report->drawn);
    EXPECT_EQ(engine::EngineParts::drawing(*engine), nullptr);
    EXPECT_EQ(engine->memory().gpu, 0u);
    ASSERT_TRUE(engine->show_all() && engine->resize(48, 32) && engine->resize(96, 64));
    ASSERT_TRUE(context->make_current() && engine->use_context(*context));
    EXPECT_FALSE(engine->config().context.later);
    int on_gpu = 0;
    for (int frame = 0; frame < 12; ++frame) on_gpu += engine->frame(view(0.1 * frame))->culler == CullerChoice::kGpu;
    EXPECT_EQ(on_gpu > 0, culler != CullerChoice::kCpu);
    expect_image(*engine, view(1.1));
    ASSERT_TRUE(engine->configure(engine->config()));
  }
  EngineConfig both = switching(CullerChoice::kCpu, &*context);
  both.context.later = true;
  EXPECT_FALSE(Engine::create(scene, both));
}

/// What an application does that destroys its window before the engine. Another context, with an engine of its own, is
/// current when the objects of the first are let go.
TEST_F(ContextLossTest, AContextThatGoesFirstIsLost) {
  for (const CullerChoice culler : {CullerChoice::kCpu, CullerChoice::kGpu, CullerChoice::kHybrid}) {
    std::optional<gl::Context> made(std::move(gl::Context::create_offscreen().value()));
    auto engine = Engine::create(scene, switching(culler, &*made)),
         unused = Engine::create(scene, switching(culler, &*made));
    ASSERT_TRUE(engine && unused);
    SCOPED_TRACE(name_of(engine->plan().culler));
    for (int frame = 0; frame < 6; ++frame) ASSERT_TRUE(engine->frame(view(0.1 * frame)) && unused->frame(view(0)));
    ASSERT_TRUE(context->make_current());
    auto other = Engine::create(scene, switching(culler, &*context));
    ASSERT_TRUE(other);
    made.reset();
    ASSERT_TRUE(unused->use_context(*context)) << "straight away";
    EXPECT_TRUE(unused->frame(view(0))->drawn);
    (void)engine->take_late_report();
    engine->finish();
    EXPECT_EQ(engine::EngineParts::drawing(*engine), nullptr);
    ASSERT_TRUE(engine->resize(48, 32) && engine->resize(96, 64));
    scene.set_visible(core::ItemId(5577), culler == CullerChoice::kGpu);
    ASSERT_TRUE(engine->commit());
    for (int frame = 0; frame < 3; ++frame) {
      const auto report = engine->frame(view(0));
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_FALSE(report->drawn);
      EXPECT_GT(report->visible, 1000);
      EXPECT_EQ(engine->memory().gpu, 0u);
    }
    ASSERT_TRUE(engine->rebuild());
    { Engine gone = std::move(*unused); }
    ASSERT_TRUE(other->commit() && other->frame(view(1)));
    ASSERT_NO_FATAL_FAILURE(expect_image(*other, view(1)));
    for (const std::string& error : engine::EngineParts::drawing(*other)->take_gl_errors()) ADD_FAILURE() << error;
    const auto used = engine->use_context(*context);
    ASSERT_TRUE(used) << used.error().message;
    EXPECT_TRUE(engine->frame(view(2))->drawn);
    ASSERT_NO_FATAL_FAILURE(expect_image(*engine, view(2)));
  }
}

/// The reset comes while everything is made anew, which then fails here and there: that is no error of the call.
TEST_F(ContextLossTest, LossInTheMiddleOfARebuild) {
  auto made = gl::Context::create_offscreen();
  ASSERT_TRUE(made);
  auto engine = Engine::create(scene, switching(CullerChoice::kHybrid, &*made));
  ASSERT_TRUE(engine);
  ASSERT_TRUE(engine->frame(view(0)));
  lose(*made);
  const_cast<gl::Functions&>(made->functions()).GetError = []() -> GLenum { return GL_CONTEXT_LOST; };
  ASSERT_TRUE(engine->rebuild());
  const auto report = engine->frame(view(1));
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_FALSE(report->drawn);
  EXPECT_GT(report->visible, 0);
  ASSERT_TRUE(engine->rebuild());
  auto other = gl::Context::create_offscreen();
  ASSERT_TRUE(other);
  ASSERT_TRUE(engine->use_context(*other));
  EXPECT_TRUE(engine->frame(view(2))->drawn);
  expect_image(*engine, view(2));
  ASSERT_TRUE(other->make_current());
  engine->drop_context();  // which goes before the engine
}

TEST_F(ContextLossTest, AContextThatFailsIsNotTaken) {
  auto engine = Engine::create(scene, switching(CullerChoice::kHybrid, &*context));
  ASSERT_TRUE(engine);
  engine->drop_context();
  EXPECT_FALSE(engine->frame(view(0))->drawn);
  auto broken = gl::Context::create_offscreen();
  ASSERT_TRUE(broken);
  const_cast<gl::Functions&>(broken->functions()).GetError = []() -> GLenum { return GL_OUT_OF_MEMORY; };
  EXPECT_FALSE(engine->use_context(*broken));
  EXPECT_FALSE(engine->frame(view(0))->drawn);
  ASSERT_TRUE(context->make_current());
  ASSERT_TRUE(engine->use_context(*context));
  EXPECT_TRUE(engine->frame(view(0))->drawn);
}

}  // namespace
}  // namespace sightline::tests::context_loss_test
