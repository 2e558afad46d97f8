// Every pixel of a ray-cast primitive against the double-precision intersection of the same ray (image_check.h):
// cylinders, snouts and torus slices, from outside, inside, along the axis, orthographic, cut by section planes,
// mirrored, sheared, and far from the origin.
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/tests/render/image_check.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::ray_cast_test {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec3;
using core::Pose;
using core::View;

constexpr int kWidth = 96, kHeight = 64;
constexpr double kAspect = double(kWidth) / kHeight;

class RayCast : public tests::GlTest {
 protected:
  /// Renders the item alone and compares item and depth of every pixel.
  void check(const core::Primitive& primitive, const Affine& world_from_item, const View& view) {
    core::Scene scene;
    const core::NodeId node = scene.add_node(scene.root(), "item", world_from_item);
    tests::Shape shape{.primitive = primitive};
    shape.world_from_item = world_from_item;
    shape.item = scene.add_primitive(node, primitive);
    engine::EngineConfig config;
    config.draw = true;
    config.drawing.ids = true;
    config.width = kWidth;
    config.height = kHeight;
    config.context.application = &*context;
    auto engine = engine::Engine::create(scene, config);
    ASSERT_TRUE(engine) << engine.error().message;
    ASSERT_TRUE(engine->frame(view));
    engine->finish();
    const render::RenderTarget& target = engine::EngineParts::drawing(*engine)->target();
    const tests::Image image{view, target.read_colour(), target.read_depth(view), target.read_ids(), {}};
    const tests::Compared compared =
        tests::compare(image, tests::look_at({&shape, 1}, view, kWidth, kHeight), {2e-5, 0.0});
    EXPECT_GT(compared.clear + compared.edges, 50) << "the case shows nothing";
  }

  static View look(const dvec3& eye, const dvec3& target, double fovy = 1.0, double near = 0.01) {
    return *View::perspective({eye, target, {0.0, 0.0, 1.0}}, fovy, kAspect, near);
  }

  /// Checks one set of views for every primitive of about unit size at `centre`.
  void check_views(const core::Primitive& primitive, const Affine& world_from_item) {
    const dvec3 c = world_from_item.origin;
    const std::pair<const char*, View> views[] = {
        {"from the side", look(c + dvec3(4, 1, 0.5), c)},
        {"from above", look(c + dvec3(0.1, 0.2, 5), c)},
        {"slanted", look(c + dvec3(-2, -3, 2.5), c)},
        {"close", look(c + dvec3(1.6, 0.3, 0.4), c, 1.2, 0.001)},
        {"orthographic", *View::orthographic({c + dvec3(3, 4, 2), c, {0, 0, 1}}, 4.0, kAspect, -50.0, 100.0)},
        {"off-axis", *View::asymmetric({c + dvec3(5, 0, 1), c, {0, 0, 1}}, -0.02, 0.05, -0.03, 0.02, 0.1, 1000.0)},
        {"clip space of OpenGL",
         *View::from_matrices(look(c + dvec3(4, -2, 1), c).eye_from_world(),
                              core::dmat4{{1.2, 0, 0, 0}, {0, 1.8, 0, 0}, {0, 0, -1.0002, -1}, {0, 0, -0.20002, 0}},
                              core::ClipDepth::kMinusOneToOne)},
        {"depth of Vulkan",
         *View::from_matrices(look(c + dvec3(4, -2, 1), c).eye_from_world(),
                              core::dmat4{{1.2, 0, 0, 0}, {0, 1.8, 0, 0}, {0, 0, -1.0001, -1}, {0, 0, -0.10001, 0}},
                              core::ClipDepth::kZeroToOne)},
    };
    for (const auto& [name, view] : views) {
      SCOPED_TRACE(name);
      check(primitive, world_from_item, view);
    }
    View cut = look(c + dvec3(4, 1, 2), c);
    cut.sections = {{{-1, 0, 0}, glm::dot(dvec3(1, 0, 0), c) + 0.1},
                    {{0, -0.5, -1}, glm::dot(dvec3(0, 0.5, 1), c) + 0.3}};
    for (const auto mode : {core::SectionMode::kIntersection, core::SectionMode::kUnion}) {
      SCOPED_TRACE(mode == core::SectionMode::kUnion ? "sections, union" : "sections, intersection");
      cut.section_mode = mode;
      check(primitive, world_from_item, cut);
    }
  }
};

Affine at(const dvec3& origin, double scale = 1.0) {
  return {dmat3(scale), origin};
}

/// Right-angled turns, a mirror and a shear: columns of a linear map.
const dmat3 kMirror = {{0.9, 0.1, 0.0}, {0.1, -0.9, 0.2}, {0.0, 0.1, 1.0}};
const dmat3 kShear = {{1.0, 0.0, 0.0}, {0.4, 0.8, 0.0}, {0.0, 0.3, 1.3}};

TEST_F(RayCast, Cylinder) {
  check_views(core::Cylinder{0.7f, 2.2f}, at({0, 0, 0}));
  check_views(core::Cylinder{700.0f, 2200.0f}, at({10, 20, 30}, 1e-3));
}
TEST_F(RayCast, CylinderMirroredAndSheared) {
  check_views(core::Cylinder{0.7f, 1.8f}, {kMirror, {1, 2, 3}});
  check_views(core::Cylinder{0.7f, 1.8f}, {kShear, {1, 2, 3}});
}
TEST_F(RayCast, DiscOfNoHeight) {
  check(core::Cylinder{1.0f, 0.0f}, at({0, 0, 0}), look({1, 2, 3}, {0, 0, 0}));
}

TEST_F(RayCast, Snout) {
  check_views(core::Snout{1.0f, 0.5f, 1.6f, 0, 0, 0, 0, 0, 0}, at({0, 0, 0}));
  check_views(core::Snout{0.4f, 0.9f, 1.2f, 0.5f, -0.3f, 0, 0, 0, 0}, at({5, 6, 7}));
}
TEST_F(RayCast, SnoutSlantedSharpAndStraight) {
  check_views(core::Snout{0.8f, 0.8f, 1.5f, 0, 0, 0.3f, 0.0f, -0.2f, 0.25f}, at({0, 0, 0}));
  check_views(core::Snout{0.9f, 0.6f, 1.5f, 0.3f, 0.2f, 0.2f, -0.1f, 0.15f, 0.1f}, at({0, 0, 0}));
  check_views(core::Snout{1.0f, 0.0f, 1.5f, 0.2f, 0.0f, 0, 0, 0, 0}, {kMirror, {0, 0, 0}});
}

TEST_F(RayCast, CircularTorus) {
  for (const float angle : {0.4f, 1.5707964f, 2.5f, 3.1415927f, 4.4f, 6.2831855f}) {
    SCOPED_TRACE(angle);
    // Centred on the middle of the arc, so that every view sees it.
    const double middle = 0.5 * angle;
    const Affine placed{dmat3(1.0),
                        angle > 3.2f ? dvec3(0.0) : dvec3(-0.8 * std::cos(middle), -0.8 * std::sin(middle), 0.0)};
    const View view = look({2.5, 2.0, 2.0}, {0, 0, 0});
    check(core::CircularTorus{1.0f, 0.35f, angle}, placed, view);
  }
  check_views(core::CircularTorus{1.0f, 0.4f, 6.2831855f}, at({0, 0, 0}));
  check_views(core::CircularTorus{1.0f, 0.4f, 4.0f}, {kMirror, {0, 0, 0}});
}
TEST_F(RayCast, SphereAndDishes) {
  check_views(core::Sphere{1.8f}, at({0, 0, 0}));
  check_views(core::EllipticalDish{1.0f, 0.5f}, at({1, 2, 3}));
  check_views(core::EllipticalDish{0.6f, 1.2f}, {kShear, {0, 0, 0}});
  check_views(core::SphericalDish{1.0f, 0.4f}, at({0, 0, 0}));
  check_views(core::SphericalDish{0.6f, 1.1f}, {kMirror, {0, 0, 0}});  // more than half a ball
  check(core::SphericalDish{1.0f, 0.02f}, at({0, 0, 0}), look({2, 1, 2}, {0, 0, 0}));
  check(core::Sphere{2.0f}, at({0, 0, 0}), look({0.2, 0.1, 0.3}, {2, 1, 1}));
}

TEST_F(RayCast, HornAndThinTorus) {
  check(core::CircularTorus{0.6f, 0.6f, 6.2831855f}, at({0, 0, 0}), look({3, 1, 2}, {0, 0, 0}));
  check(core::CircularTorus{1.0f, 0.02f, 6.2831855f}, at({0, 0, 0}), look({1.5, 1, 2}, {0, 0, 0}));
}

TEST_F(RayCast, EyeInside) {
  check(core::Cylinder{1.0f, 8.0f}, at({0, 0, 0}), look({0.2, 0.1, -2}, {0.3, 0.5, 3}));
  check(core::Cylinder{1.0f, 8.0f}, at({0, 0, 0}), look({0, 0, 0}, {0, 1e-3, 1}));  // on the axis, along it
  check(core::Snout{1.0f, 0.5f, 6.0f, 0.5f, 0, 0, 0, 0, 0}, at({0, 0, 0}), look({0, 0.1, -1}, {0.4, 0.3, 2}));
  check(core::CircularTorus{3.0f, 1.0f, 6.2831855f}, at({0, 0, 0}), look({3, 0, 0.1}, {2, 3, 0}));
}

TEST_F(RayCast, BehindTheNearPlaneTheFarWallShows) {
  // The near plane lies inside the cylinder although the eye is outside.
  check(core::Cylinder{1.0f, 4.0f}, at({0, 0, 0}), look({3, 0, 0.2}, {0, 0, 0}, 1.0, 2.6));
}

TEST_F(RayCast, FarFromTheOrigin) {
  const dvec3 site(3e6, 7e6, 1e3);
  check(core::Cylinder{0.5f, 2.0f}, at(site), look(site + dvec3(3, 2, 1), site));
  check(core::CircularTorus{1.0f, 0.3f, 2.0f}, at(site), look(site + dvec3(3, 2, 2), site + dvec3(0.5, 0.7, 0)));
}

TEST_F(RayCast, FarFromTheEye) {
  // A thousand radii away through a narrow field of view.
  check(core::Cylinder{0.05f, 0.2f}, at({0, 0, 0}), look({40, 20, 20}, {0, 0, 0}, 0.006));
  check(core::CircularTorus{0.1f, 0.03f, 6.2831855f}, at({0, 0, 0}), look({40, 20, 20}, {0, 0, 0}, 0.006));
}

TEST_F(RayCast, RandomSnoutsAndTori) {
  for (int seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random{std::uint32_t(seed)};
    const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
    const auto f = [&](double low, double high) { return float(uniform(low, high)); };
    const core::Primitive primitive =
        seed % 2 ? core::Primitive(core::Snout{f(0.2, 1), f(0.2, 1), f(0.5, 2), f(-0.5, 0.5), f(-0.5, 0.5),
                                               f(-0.3, 0.3), f(-0.3, 0.3), f(-0.3, 0.3), f(-0.3, 0.3)})
                 : core::Primitive(core::CircularTorus{f(0.7, 1.2), f(0.2, 0.5), f(2.0, 6.3)});
    const dvec3 eye = 4.0 * glm::normalize(dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)));
    check(primitive, at({0, 0, 0}), look(eye, {0, 0, 0}));
  }
}

}  // namespace
}  // namespace sightline::ray_cast_test
