// Handles of sections in a session: dragged, snapped, put back, flipped. Nothing is drawn.
#include "sightline/apps/view/section_handles.h"

#include <gtest/gtest.h>

namespace sightline::apps::section_handles_test {
namespace {

using core::dvec2;
using core::dvec3;

constexpr double kScale = 1.0;

class SectionHandlesTest : public testing::Test {
 protected:
  /// A box of 4 m whose middle is at 0, 0, 10 of the model, seen from the east; cut at y = 1 from the south.
  void SetUp() override {
    Model model;
    model.scene = std::make_unique<core::Scene>();
    model.offset = dvec3(1e6, 0.25, 0.0);
    model.scene->add_primitive(model.scene->root(), core::Box{4, 4, 4},
                               core::translation(model.offset + dvec3(0, 0, 10)));
    engine::EngineConfig config;
    config.width = 800;
    config.height = 600;
    auto opened = Session::open(std::move(model), config);
    ASSERT_TRUE(opened) << opened.error().message;
    session = std::move(*opened);
    session->camera.set_pose({place(dvec3(20, 0, 10)), place(dvec3(0, 0, 10)), {0, 0, 1}});
    ASSERT_TRUE(session->sections.add(place(dvec3(0, 1, 10)), {0, -1, 0}));
    ASSERT_TRUE(session->sections.add(place(dvec3(0, 0, 11)), {0, 0, 1}));
    session->sections.select(0);
  }
  dvec3 place(const dvec3& in_model) const { return in_model + dvec3(1e6, 0.25, 0.0); }
  dvec2 handle(SectionGizmo::Part part) const {
    const auto all = SectionHandles::shown(*session, kScale);
    for (const SectionGizmo::Handle& one : all.back().gizmo.handles())
      if (one.part == part) return one.at;
    ADD_FAILURE() << "no handle " << SectionGizmo::name_of(part);
    return {};
  }
  dvec2 pixel_of(const dvec3& in_model) const {
    return *ImageFrame::create(*session->image.view(), 800, 600)->project(place(in_model));
  }
  const Sections::Section& section(std::size_t index = 0) const { return session->sections.all()[index]; }

  std::unique_ptr<Session> session;
  SectionHandles handles;
};

TEST_F(SectionHandlesTest, FollowTheCursorAndComeBack) {
  const dvec2 out = handle(SectionGizmo::Part::kOut), by = pixel_of({0, 0.5, 10}) - pixel_of({0, 1, 10});
  ASSERT_TRUE(handles.press(*session, out, kScale));
  EXPECT_TRUE(handles.dragging());
  handles.drag(*session, out + by, {});
  EXPECT_NEAR(section().place().y, place(dvec3(0, 0.5, 10)).y, 1e-6);
  EXPECT_EQ(handles.words({Units::kMetres, 3}), "+0.500 m, Y = 0.500 m");
  handles.drag(*session, out + 3.0 * by, {});
  EXPECT_NEAR(section().place().y, place(dvec3(0, -0.5, 10)).y, 1e-6) << "from where it began";
  handles.cancel(*session);
  EXPECT_FALSE(handles.dragging());
  EXPECT_EQ(section().place(), place(dvec3(0, 1, 10)));
  EXPECT_EQ(section().offset, 0.0);
  handles.drag(*session, {}, {});  // without a press
  handles.release(*session, true);
  EXPECT_EQ(section().place(), place(dvec3(0, 1, 10)));
  EXPECT_FALSE(handles.press(*session, {5, 5}, kScale));
}

TEST_F(SectionHandlesTest, StopAtRoundPlacesAndAtTheModel) {
  const dvec2 out = handle(SectionGizmo::Part::kOut);
  const auto dragged_to = [&](const dvec2& to, const SectionHandles::Snapping& snapping) {
    EXPECT_TRUE(handles.press(*session, out, kScale));
    handles.drag(*session, to, snapping);
    const double y = section().place().y - place(dvec3(0.0)).y;
    handles.cancel(*session);
    return y;
  };
  for (double x = -90.0; x < 90.0; x += 7.3) {
    const double free = dragged_to(out + dvec2(x, 0.0), {}), round = dragged_to(out + dvec2(x, 0.0), {.round = true});
    EXPECT_NEAR(round, 0.2 * std::round(free / 0.2), 1e-6) << "six pixels are 0.16 m";
  }
  // The corner of the box next to the cursor, although that is beside the axis.
  EXPECT_NEAR(dragged_to(pixel_of({2, 2, 9}) - dvec2(3, 0), {.model = true}), 2.0, 1e-6);
  const dvec2 up = handle(SectionGizmo::Part::kUp);
  ASSERT_TRUE(handles.press(*session, up, kScale));
  handles.drag(*session, up + dvec2(-11.0, 0.0), {.round = true});
  EXPECT_EQ(handles.words({}), "+15.0\u00b0");
  EXPECT_NEAR(section().normal.z, -std::sin(0.2617993877991494), 1e-9);
}

TEST_F(SectionHandlesTest, ClicksSelectAndFlip) {
  session->sections.select(1);
  const dvec2 first = SectionHandles::shown(*session, kScale).front().gizmo.middle();
  const auto click = [&] {
    ASSERT_TRUE(handles.press(*session, first, kScale));
    handles.release(*session, true);
  };
  click();
  EXPECT_EQ(session->sections.selected(), 0u);
  EXPECT_EQ(section().normal, dvec3(0, -1, 0));
  click();
  EXPECT_EQ(section().normal, dvec3(0, 1, 0));
  session->sections.all()[0].on = false;
  EXPECT_EQ(SectionHandles::shown(*session, kScale).size(), 1u);
  session->sections.clear();
  EXPECT_FALSE(SectionHandles::at(*session, first, kScale));
}

/// Its section may vanish while it is dragged, by a script.
TEST_F(SectionHandlesTest, SurviveTheirSection) {
  ASSERT_TRUE(handles.press(*session, handle(SectionGizmo::Part::kOut), kScale));
  session->sections.clear();
  handles.drag(*session, {100, 100}, {.round = true, .model = true});
  handles.cancel(*session);
  EXPECT_TRUE(session->sections.all().empty());
}

}  // namespace
}  // namespace sightline::apps::section_handles_test
