// A session that comes into a context shows its image by rays until it has come.
#include <optional>

#include <gtest/gtest.h>

#include "sightline/apps/view/session.h"
#include "sightline/render/image/image.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::apps::first_image_test {
namespace {

class FirstImage : public tests::GlTest {
 protected:
  std::unique_ptr<Session> open(engine::Renderer renderer) {
    Model model;
    model.scene = std::make_unique<core::Scene>();
    for (int i = 0; i < 2000; ++i)
      model.scene->add_primitive(model.scene->root(), core::Cylinder{0.3f, 0.8f},
                                 core::translation({i % 20, i / 20 % 10, i / 200}));
    engine::EngineConfig config;
    config.draw = true;
    config.width = 160, config.height = 100;
    config.drawing.looks = engine::Looks::standard();
    config.drawing.renderer = renderer;
    config.context.later = true;
    auto opened = Session::open(std::move(model), config);
    EXPECT_TRUE(opened) << opened.error().message;
    return opened ? std::move(*opened) : nullptr;
  }
};

TEST_F(FirstImage, IsThatOfOpenGl) {
  const auto session = open(engine::Renderer::kAutomatic);
  ASSERT_TRUE(session);
  while (session->engine.preparing_picks()) continue;
  const std::array<int, 2> size{200, 120};  // the window has become larger meanwhile
  std::optional<image::Image> first;
  for (bool done = false; !done;) {
    const auto step = session->begin(*context, size);
    ASSERT_TRUE(step) << step.error().message;
    done = *step;
    if (session->first_image()) first = *session->first_image();
  }
  EXPECT_EQ(session->first_image(), nullptr) << "OpenGL's is there";
  ASSERT_TRUE(first);
  const auto drawn = session->image.read(false);
  ASSERT_TRUE(drawn);
  const auto found = image::compare(*first, *drawn);
  ASSERT_TRUE(found);
  EXPECT_LE(found->pixels, 200u * 120u / 25u);
  EXPECT_LE(found->mean, 1.5);
}

TEST_F(FirstImage, IsNoneWhereRaysDoNotDraw) {
  const auto session = open(engine::Renderer::kGl);
  ASSERT_TRUE(session);
  for (bool done = false; !done;) {
    const auto step = session->begin(*context, {160, 100});
    ASSERT_TRUE(step) << step.error().message;
    done = *step;
    EXPECT_EQ(session->first_image(), nullptr);
  }
  EXPECT_TRUE(session->image.read(false));
}

}  // namespace
}  // namespace sightline::apps::first_image_test
