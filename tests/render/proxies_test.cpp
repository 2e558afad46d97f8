// How many fragments ray-cast solids cost: no more than their local boxes cover, and none when they are behind the eye.
// Counts, not times.
#include <gtest/gtest.h>

#include "sightline/tests/render/image_check.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests::proxies_test {
namespace {

using core::dmat3;
using core::View;

constexpr int kSize = 320;
constexpr GLenum kFragmentShaderInvocations = 0x82F4;

/// A solid and the axes that its box is parallel to: slices of tori lie symmetric to their sweep.
struct Solid {
  const char* name;
  core::Primitive primitive;
  double turned = 0.0;  ///< about z
};
const Solid kSolids[] = {{"cylinder", core::Cylinder{0.5f, 3.0f}},
                         {"snout", core::Snout{1.0f, 0.4f, 1.6f, 0.5f, -0.3f, 0, 0, 0, 0}},
                         {"slanted snout", core::Snout{0.9f, 0.6f, 1.5f, 0, 0, 0.2f, -0.1f, 0.15f, 0.1f}},
                         {"closed torus", core::CircularTorus{1.0f, 0.3f, 6.2831855f}},
                         {"bend", core::CircularTorus{1.0f, 0.3f, 1.4f}, 0.7},
                         {"long bend", core::CircularTorus{1.0f, 0.3f, 4.0f}, 2.0},
                         {"sphere", core::Sphere{2.0f}},
                         {"elliptical dish", core::EllipticalDish{1.0f, 0.5f}},
                         {"flat dish", core::SphericalDish{1.0f, 0.3f}},
                         {"deep dish", core::SphericalDish{0.6f, 1.0f}},
                         {"rectangular bend", core::RectangularTorus{0.8f, 1.2f, 0.5f, 1.4f}, 0.7},
                         {"pyramid", core::Pyramid{0.4f, 1.2f, 1.0f, 0.6f, 0.2f, -0.3f, 1.5f}},
                         {"box", core::Box{1.4f, 0.3f, 1.0f}}};

class Proxies : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (!context) return;
    gl().GenQueries(1, &query_);
    gl().BeginQuery(kFragmentShaderInvocations, query_);
    if (!context->take_errors().empty()) GTEST_SKIP() << "this context does not count fragments";
    gl().EndQuery(kFragmentShaderInvocations);
    const double c = std::cos(0.8), s = std::sin(0.8);
    const dmat3 turn = dmat3(c, s, 0, -s, c, 0, 0, 0, 1) * dmat3(1, 0, 0, 0, c, s, 0, -s, c);
    for (const Solid& solid : kSolids) {
      const double a = std::cos(solid.turned), b = std::sin(solid.turned);
      Shape shape{.primitive = solid.primitive};
      shape.world_from_item.linear = turn * dmat3(1.2, 0, 0, 0, 0.9, 0, 0, 0, -1.1) * dmat3(a, -b, 0, b, a, 0, 0, 0, 1);
      shape.item = scene_.add_primitive(scene_.root(), shape.primitive, shape.world_from_item);
      shapes_.push_back(shape);
      // The box of the solid, turned back.
      boxes_.push_back(core::bounds(solid.primitive, {dmat3(a, -b, 0, b, a, 0, 0, 0, 1), dvec3(0.0)}));
      world_from_box_.push_back(turn * dmat3(1.2, 0, 0, 0, 0.9, 0, 0, 0, -1.1));
    }
    camera_.emplace(*context, scene_, kSize, kSize);
  }

  void TearDown() override {
    camera_.reset();
    if (context) gl().DeleteQueries(1, &query_);
    GlTest::TearDown();
  }

  int fragments(const View& view, std::size_t solid) {
    gl().BeginQuery(kFragmentShaderInvocations, query_);
    camera_->draw(view, {&shapes_[solid], 1});
    gl().EndQuery(kFragmentShaderInvocations);
    GLuint count = 0;
    gl().GetQueryObjectuiv(query_, GL_QUERY_RESULT, &count);
    return int(count);
  }

  bool meets_box(std::size_t solid, const PixelRay& ray) const {
    const dmat3 inverse = glm::inverse(world_from_box_[solid]);
    const dvec3 o = inverse * ray.origin, d = inverse * ray.direction;
    double from = 0.0, to = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (boxes_[solid].min[axis] - o[axis]) / d[axis], b = (boxes_[solid].max[axis] - o[axis]) / d[axis];
      from = std::max(from, std::min(a, b));
      to = std::min(to, std::max(a, b));
    }
    return from <= to;
  }

  GLuint query_ = 0;
  core::Scene scene_;
  std::vector<Shape> shapes_;
  std::vector<core::AabbD> boxes_;
  std::vector<dmat3> world_from_box_;
  std::optional<Camera> camera_;
};

TEST_F(Proxies, CoverNoMoreThanTheBoxOfTheSolid) {
  constexpr double kViews = 8;
  const dvec3 from[] = {{5, 1, 2}, {-3, 4, -2}, {1, -5, 1}, {-0.5, 0.4, 5}};
  for (std::size_t solid = 0; solid < std::size(kSolids); ++solid) {
    SCOPED_TRACE(kSolids[solid].name);
    const dvec3 middle = world_from_box_[solid] * (0.5 * (boxes_[solid].min + boxes_[solid].max));
    int covered = 0, drawn = 0;
    for (const dvec3& aside : from)
      for (const bool flat : {false, true}) {
        const core::Pose pose{middle + aside, middle, {0.1, 0.2, 1}};
        const View view =
            flat ? *View::orthographic(pose, 3.2, 1.0, -5.0, 20.0) : *View::perspective(pose, 0.6, 1.0, 0.1);
        drawn += fragments(view, solid);
        for (int y = 0; y < kSize; ++y)
          for (int x = 0; x < kSize; ++x) covered += meets_box(solid, pixel_ray(view, kSize, kSize, x, y));
      }
    EXPECT_GT(covered, kViews * kSize * kSize / 20);
    // Implementations may count whole blocks of pixels at each triangle's edges: 4 x 4 of them add 4 pixels on average
    // to edges and diagonals of three sides, which together are some ten times as long as the image of the box is
    // wide.
    const double width = std::sqrt(covered / kViews);
    EXPECT_LE(drawn, covered + kViews * 40.0 * width) << covered << " pixels covered";
  }
}

TEST_F(Proxies, OfAnEyeThatIsJustOutsideAndLooksAwayCoverNothing) {
  for (std::size_t solid = 0; solid < std::size(kSolids); ++solid) {
    SCOPED_TRACE(kSolids[solid].name);
    const core::AabbD& box = boxes_[solid];
    for (int axis = 0; axis < 3; ++axis) {
      dvec3 eye = 0.5 * (box.min + box.max), away(0.0);
      eye[axis] = box.max[axis] + 0.02 * (box.max[axis] - box.min[axis]);
      // Along the side's normal, so that the whole side lies behind the eye.
      away[axis] = 1.0;
      eye = world_from_box_[solid] * eye;
      away = glm::transpose(glm::inverse(world_from_box_[solid])) * away;
      EXPECT_EQ(fragments(*View::perspective({eye, eye + away, {0.3, 0.2, 1}}, 0.9, 1.0, 0.001), solid), 0)
          << "axis " << axis;
    }
  }
}

}  // namespace
}  // namespace sightline::tests::proxies_test
