// Surfaces as they are drawn: item, depth and normal of every pixel of each solid and of meshes, against the reference
// in double (image_check.h). Turned, mirrored, sheared and stretched; in perspective and orthographic views, off-axis
// ones, and from within; whole and cut by sections; at 1 m and at 1e7 m from the origin.
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sightline/tests/render/image_check.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests::surfaces_test {
namespace {

using core::Affine;
using core::dmat3;
using core::Pose;
using core::View;

constexpr int kWidth = 60, kHeight = 44;
constexpr double kAspect = double(kWidth) / kHeight;

/// Rays are cast in float, from nearby: what they meet is known to 1e-6 of its size, and a normal to that over the
/// least radius of curvature (a twentieth, of the thin torus), times the stretch of the placement. The depth buffer of
/// an orthographic view tells 1e-7 of its 60 m apart.
constexpr Tolerance kRayCast{1e-5, 0.02};
/// Normals of vertices have 16 bits, 0.002 degrees, which a placement stretches; between them the rasteriser
/// interpolates, and is 1/128 pixel beside, of the some 10 degrees a pixel of a coarse mesh.
constexpr Tolerance kRasterised{1e-5, 0.1, 1};

dmat3 turn(double angle, dvec3 axis) {
  axis = glm::normalize(axis);
  dmat3 m;
  for (int i = 0; i < 3; ++i) {
    dvec3 e(0.0);
    e[i] = 1.0;
    m[i] = std::cos(angle) * e + std::sin(angle) * glm::cross(axis, e) + (1.0 - std::cos(angle)) * axis[i] * axis;
  }
  return m;
}

struct Placed {
  const char* name;
  dmat3 linear;
};
const Placed kPlaced[] = {
    {"as it is", dmat3(1.0)},
    {"turned", turn(1.1, {1, 2, -0.7})},
    {"mirrored", turn(2.3, {-1, 0.4, 1}) * dmat3(1, 0, 0, 0, -1, 0, 0, 0, 1)},
    {"sheared", turn(0.6, {0.2, 1, 0.5}) * dmat3(1, 0, 0, 0.5, 0.9, 0, 0.2, -0.4, 1.1)},
    {"stretched", turn(-1.7, {0.6, -1, 0.3}) * dmat3(1.9, 0, 0, 0, 0.5, 0, 0, 0, 1.1) * turn(0.5, {1, 1, 1})},
    {"mirrored, sheared and small", 0.01 * turn(2.9, {1, 0.1, -0.4}) * dmat3(-1.2, 0.1, 0, 0.3, 0.7, -0.2, 0, 0.4, 1)},
};
const dvec3 kNear(1.0, 0.3, -0.2), kFar(6e6, -8e6, 300.0);

/// Directions all around, another for each n.
dvec3 direction(int n) {
  const double z = std::fmod(0.381966 * n + 0.2, 1.8) - 0.9, turned = 2.39996 * n;
  return {std::sqrt(1.0 - z * z) * std::cos(turned), std::sqrt(1.0 - z * z) * std::sin(turned), z};
}

class Surfaces : public GlTest {
 protected:
  struct Named {
    const char* name;
    View view;
  };

  /// About a solid that has its middle there and reaches that far. `inside`: a point within.
  static std::vector<Named> views(const dvec3& middle, double reach, const dvec3& inside, int turned) {
    const auto pose = [&](int n, double distance) {
      return Pose{middle + distance * reach * direction(turned + n), middle + 0.05 * reach * direction(n),
                  direction(3 * n)};
    };
    const double near = 0.01 * reach;
    std::vector<Named> views = {
        {"in perspective", *View::perspective(pose(0, 2.6), 0.9, kAspect, near)},
        {"orthographic", *View::orthographic(pose(1, 2.0), 2.0 * reach, kAspect, -30.0 * reach, 30.0 * reach)},
        {"off-axis",
         *View::asymmetric(pose(2, 3.0), -0.3 * near, 0.5 * near, -0.35 * near, 0.3 * near, near, 90.0 * reach)},
        {"from within",
         *View::perspective({inside, inside + direction(turned + 3), direction(turned)}, 1.4, kAspect, near)},
        {"cut", *View::perspective(pose(4, 2.4), 0.9, kAspect, near)},
        {"cut by any, orthographic",
         *View::orthographic(pose(5, 2.0), 2.0 * reach, kAspect, -30.0 * reach, 30.0 * reach)},
        {"cut near the eye", *View::perspective(pose(6, 0.8), 1.3, kAspect, near)}};
    const auto half_space = [&](int n, double offset) {
      const dvec3 normal = (1.0 + 0.3 * n) * direction(turned + 2 * n);
      return core::Plane{normal, offset * reach - glm::dot(normal, inside)};
    };
    views[4].view.sections = {half_space(1, 0.05), half_space(2, 0.3)};
    views[5].view.sections = {half_space(3, -0.02), half_space(4, -0.1)};
    views[5].view.section_mode = core::SectionMode::kUnion;
    views[6].view.sections = {half_space(5, 0.1)};
    return views;
  }

  /// The middle of the first thick part that a ray through the middle, or near it, passes.
  static dvec3 point_within(const Shape& shape, const dvec3& middle, double reach) {
    for (int n = 0; n < 200; ++n) {
      const PixelRay ray{middle + 0.02 * n * reach * direction(5 * n), direction(n), 0.0, 0.0};
      const std::vector<gpuprims::Hit> hits = crossings(shape, ray);
      if (hits.size() >= 2 && hits[1].t - hits[0].t > 0.03 * reach)
        return ray.origin + 0.5 * (hits[0].t + hits[1].t) * ray.direction;
    }
    return middle;
  }

  /// Each shape at each place, alone in the image.
  void check(std::span<const Shape> kinds, const Tolerance& tolerance) {
    core::Scene scene;
    std::vector<Shape> shapes;
    std::vector<core::MeshId> meshes;
    for (const Shape& kind : kinds) meshes.push_back(kind.mesh ? scene.add_mesh(*kind.mesh).value() : core::MeshId{});
    for (const dvec3& site : {kNear, kFar})
      for (const Placed& placed : kPlaced)
        for (std::size_t i = 0; i < kinds.size(); ++i) {
          Shape shape = kinds[i];
          shape.world_from_item = {placed.linear, site};
          shape.item = shape.mesh ? scene.add_mesh_instance(scene.root(), meshes[i], shape.world_from_item)
                                  : scene.add_primitive(scene.root(), shape.primitive, shape.world_from_item);
          shapes.push_back(shape);
        }
    Camera camera(*context, scene, kWidth, kHeight);
    Compared sum;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      const Shape& shape = shapes[i];
      const core::AabbD box = scene.bounds_under(shape.item, shape.world_from_item);
      const dvec3 middle = 0.5 * (box.min + box.max);
      const double reach = 0.5 * glm::length(box.max - box.min);
      const bool far = i >= shapes.size() / 2;
      int number = 0;
      for (const Named& named : views(middle, reach, point_within(shape, middle, reach), 7 * int(i))) {
        if (far && (number++ + int(i)) % 4 != 0) continue;  // there every fourth will do
        SCOPED_TRACE(testing::Message() << "shape " << i % kinds.size() << ", "
                                        << kPlaced[i / kinds.size() % std::size(kPlaced)].name
                                        << (far ? ", far away, " : ", ") << named.name);
        const std::vector<PixelHits> seen = look_at({&shape, 1}, named.view, kWidth, kHeight);
        const Compared compared = compare(camera.draw(named.view, {&shape, 1}), seen, tolerance);
        EXPECT_GT(compared.clear + compared.edges + compared.silhouettes, 4) << "the view shows nothing";
        sum.clear += compared.clear;
        sum.edges += compared.edges;
        sum.silhouettes += compared.silhouettes;
        sum.cut += compared.cut;
      }
    }
    EXPECT_GT(sum.clear, 10 * (sum.edges + sum.silhouettes))
        << sum.edges << " at edges, " << sum.silhouettes << " at silhouettes";
    EXPECT_GT(sum.cut, sum.clear / 50);
  }

  void check(std::initializer_list<core::Primitive> primitives) {
    std::vector<Shape> shapes;
    for (const core::Primitive& primitive : primitives) shapes.push_back({.primitive = primitive});
    check(shapes, kRayCast);
  }
};

constexpr float kFull = float(2.0 * std::numbers::pi);

TEST_F(Surfaces, OfCylinders) {
  check({core::Cylinder{0.7f, 2.2f}, core::Cylinder{1.0f, 0.3f}});
}
TEST_F(Surfaces, OfSnouts) {
  check({core::Snout{1.0f, 0.5f, 1.6f, 0, 0, 0, 0, 0, 0}, core::Snout{0.4f, 0.9f, 1.2f, 0.5f, -0.3f, 0, 0, 0, 0},
         core::Snout{0.9f, 0.6f, 1.5f, 0.3f, 0.2f, 0.2f, -0.1f, 0.15f, 0.1f},
         core::Snout{1.0f, 0.0f, 1.5f, 0.2f, 0.0f, 0, 0, 0, 0}, core::Snout{1.0f, 0.4f, 0.1f, 0.1f, 0.5f, 0, 0, 0, 0}});
}
TEST_F(Surfaces, OfSnoutsWhoseEndsAreSteeperThanTheirCones) {
  check({core::Snout{1.0f, 0.2f, 1.0f, 0, 0, 1.2f, 0, 0, 0}, core::Snout{0.3f, 1.0f, 1.0f, 0, 0, 0, 0, 0.3f, 1.3f}});
}
TEST_F(Surfaces, OfCircularTori) {
  check({core::CircularTorus{1.0f, 0.35f, kFull}, core::CircularTorus{1.0f, 0.4f, 4.0f},
         core::CircularTorus{1.2f, 0.3f, 1.2f}, core::CircularTorus{1.0f, 0.05f, 2.5f},
         core::CircularTorus{0.6f, 0.6f, kFull}});
}
TEST_F(Surfaces, OfSpheresAndDishes) {
  check({core::Sphere{1.8f}, core::EllipticalDish{1.0f, 0.5f}, core::SphericalDish{1.0f, 0.4f},
         core::SphericalDish{1.0f, 0.05f}, core::SphericalDish{0.6f, 1.1f}});
}
TEST_F(Surfaces, OfRectangularTori) {
  check({core::RectangularTorus{0.5f, 1.2f, 0.5f, 4.0f}, core::RectangularTorus{0.7f, 1.0f, 0.8f, kFull},
         core::RectangularTorus{0.0f, 1.0f, 0.5f, 1.0f}});
}
TEST_F(Surfaces, OfPyramidsAndBoxes) {
  check({core::Pyramid{1.5f, 1.2f, 0.5f, 0.6f, 0.2f, 0.1f, 1.5f},
         core::Pyramid{0.5f, 0.6f, 1.5f, 1.2f, -0.4f, 0.7f, 0.4f},
         core::Pyramid{1.5f, 1.0f, 0.0f, 0.0f, 0.2f, 0.1f, 1.0f}, core::Box{1.4f, 1.2f, 1.0f}});
}

/// Rays that are parallel to an axis exactly, where quadratic terms are 0; and eyes on the sides of a solid's box, just
/// beside them and far beside them.
TEST_F(Surfaces, AlongTheAxesAndFromTheSidesOfTheirBoxes) {
  const core::Primitive primitives[] = {core::Cylinder{0.7f, 2.2f},
                                        core::Snout{0.7f, 0.7f, 1.6f, 0, 0, 0.2f, 0, 0, 0},
                                        core::Snout{1.0f, 0.5f, 1.6f, 0, 0, 0, 0, 0, 0},
                                        core::CircularTorus{1.0f, 0.35f, 4.0f},
                                        core::Sphere{1.8f},
                                        core::EllipticalDish{1.0f, 0.5f},
                                        core::SphericalDish{1.0f, 0.4f},
                                        core::RectangularTorus{0.5f, 1.2f, 0.5f, kFull},
                                        core::Pyramid{1.5f, 1.2f, 0.5f, 0.6f, 0.2f, 0.1f, 1.5f},
                                        core::Box{1.4f, 1.2f, 1.0f}};
  core::Scene scene;
  std::vector<Shape> shapes;
  for (const core::Primitive& primitive : primitives) {
    Shape shape{.primitive = primitive};
    shape.item = scene.add_primitive(scene.root(), primitive);
    shapes.push_back(shape);
  }
  Camera camera(*context, scene, kWidth, kHeight);
  for (const Shape& shape : shapes) {
    const core::AabbD box = core::bounds(shape.primitive, shape.world_from_item);
    const dvec3 middle = box.centre(), half = 0.5 * (box.max - box.min);
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {-1.0, 1.0}) {
        SCOPED_TRACE(testing::Message() << "item " << to_index(shape.item) << ", axis " << axis << ", side " << side);
        dvec3 out(0.0), up(0.0);
        out[axis] = side;
        up[(axis + 1) % 3] = 1.0;
        const View along = *View::orthographic({middle + 4.0 * out, middle, up}, 3.1, kAspect, -1.0, 20.0);
        compare(camera.draw(along, {&shape, 1}), look_at({&shape, 1}, along, kWidth, kHeight), kRayCast);
        for (const double beside : {-1e-3, -1e-5, 0.0, 1e-6, 1e-5, 1e-4, 1e-3, 0.1}) {
          SCOPED_TRACE(testing::Message() << beside << " beside");
          const dvec3 eye = middle + (1.0 + beside) * half * out + 0.31 * half * up;
          const View inwards = *View::perspective({eye, middle + 0.1 * up + 0.2 * out, up}, 1.2, kAspect, 1e-4);
          compare(camera.draw(inwards, {&shape, 1}), look_at({&shape, 1}, inwards, kWidth, kHeight), kRayCast);
        }
      }
  }
}

constexpr double kFewPixelsDistance = 100.0;  ///< a pixel is 1 m there

/// From a third of a pixel to nine pixels across, anywhere between the pixels' centres.
std::vector<Shape> add_small_shapes(core::Scene& scene, std::uint32_t seed) {
  const core::Primitive primitives[] = {core::Cylinder{0.3f, 1.0f},
                                        core::Snout{0.5f, 0.2f, 0.7f, 0.1f, 0, 0, 0, 0, 0},
                                        core::CircularTorus{0.4f, 0.1f, 2.0f},
                                        core::Sphere{1.0f},
                                        core::SphericalDish{0.5f, 0.2f},
                                        core::RectangularTorus{0.3f, 0.5f, 0.3f, kFull},
                                        core::Pyramid{0.6f, 0.5f, 0.2f, 0.2f, 0.1f, 0, 0.6f},
                                        core::Box{0.7f, 0.5f, 0.4f}};
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
  std::vector<Shape> shapes;
  for (int i = 0; i < 60; ++i) {
    Shape shape{.primitive = primitives[random() % std::size(primitives)]};
    const double size = std::exp(uniform(std::log(0.3), std::log(9.0))) * (random() % 3 == 0 ? -1.0 : 1.0);
    const dmat3 turned = turn(uniform(0.0, 6.0), {uniform(-1, 1), uniform(-1, 1), 1.1});
    const double x = uniform(-0.5, 0.5) * kWidth, depth = uniform(-5, 5), y = uniform(-0.5, 0.5) * kHeight;
    shape.world_from_item = {size * turned, {x, depth, y}};
    shape.item = scene.add_primitive(scene.root(), shape.primitive, shape.world_from_item);
    shapes.push_back(shape);
  }
  return shapes;
}

std::array<View, 2> few_pixel_views() {
  const Pose pose{{0, -kFewPixelsDistance, 0}, {0, 0, 0}, {0, 0, 1}};
  return {*View::perspective(pose, 2.0 * std::atan(0.5 * kHeight / kFewPixelsDistance), kAspect, 1.0),
          *View::orthographic(pose, kHeight, kAspect, 1.0, 200.0)};
}

TEST_F(Surfaces, OfWhatCoversFewPixels) {
  int shown = 0;
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    core::Scene scene;
    const std::vector<Shape> shapes = add_small_shapes(scene, seed);
    Camera camera(*context, scene, kWidth, kHeight);
    for (const View& view : few_pixel_views()) {
      const Compared compared = compare(camera.draw(view, shapes), look_at(shapes, view, kWidth, kHeight), kRayCast);
      shown += compared.clear + compared.edges + compared.silhouettes;
    }
  }
  EXPECT_GT(shown, 5000);
}

/// A pixel shows something exactly when the ray through one of its samples meets something.
TEST_F(Surfaces, OfWhatCoversFewSamples) {
  int shown = 0, empty = 0;
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    core::Scene scene;
    const std::vector<Shape> shapes = add_small_shapes(scene, seed);
    Camera camera(*context, scene, kWidth, kHeight, 4);
    for (const View& view : few_pixel_views()) {
      const Image image = camera.draw(view, shapes);
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          bool hit = false, missed = true;
          for (const glm::vec2& offset : camera.target().sample_offsets()) {
            const PixelHits around =
                look_around(shapes, view, kWidth, kHeight, double(x) + offset.x, double(y) - offset.y);
            hit = hit || around.hits == 5;
            missed = missed && around.hits == 0;
          }
          if (!hit && !missed) continue;  // by 1/32 pixel
          const std::uint8_t* colour = &image.colour.pixels[3 * (std::size_t(y) * kWidth + std::size_t(x))];
          bool background = true;
          for (std::size_t c = 0; c < 3; ++c)
            background = background && colour[c] == std::lround(255.0f * camera.background()[int(c)]);
          EXPECT_EQ(background, missed) << x << ", " << y;
          shown += hit;
          empty += missed;
        }
    }
  }
  EXPECT_GT(shown, 2000);
  EXPECT_GT(empty, 2000);
}

TEST_F(Surfaces, OfSolidsUnderSingularPlacementsAreNone) {
  core::Scene scene;
  std::vector<Shape> shapes;
  const core::Primitive primitives[] = {
      core::Cylinder{1, 2}, core::Snout{1, 0.5f, 2, 0, 0, 0, 0, 0, 0}, core::CircularTorus{1, 0.3f, 4},
      core::Sphere{2},      core::RectangularTorus{0.5f, 1, 1, 4},     core::Pyramid{1, 1, 2, 2, 0, 0, 1},
      core::Box{1, 2, 1}};
  for (const core::Primitive& primitive : primitives)
    for (const dmat3& flat : {dmat3(0.0), dmat3(1, 0, 0, 0, 1, 0, 0, 0, 0), dmat3(1, 2, 3, 2, 4, 6, 0, 0, 1)}) {
      Shape shape{.primitive = primitive};
      shape.item = scene.add_primitive(scene.root(), primitive, {flat, dvec3(0.0)});
      shapes.push_back(shape);
    }
  Camera camera(*context, scene, kWidth, kHeight);
  const Image image = camera.draw(*View::perspective({{3, 2, 1}, {0, 0, 0}, {0, 0, 1}}, 0.9, kAspect, 0.01), shapes);
  EXPECT_EQ(std::count(image.ids.ids.begin(), image.ids.ids.end(), 0u), kWidth * kHeight);
}

core::Mesh turned_inside_out(core::Mesh mesh) {
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) std::swap(mesh.indices[i], mesh.indices[i + 1]);
  return mesh;
}

TEST_F(Surfaces, OfMeshes) {
  const gpuprims::Tessellation coarse{.fixed_segments = 9};
  std::vector<core::Mesh> meshes = {
      gpuprims::tessellate(core::Sphere{1.8f}, coarse),
      gpuprims::tessellate(core::CircularTorus{1.0f, 0.4f, 4.0f}, coarse),
      gpuprims::tessellate(core::Snout{0.9f, 0.6f, 1.5f, 0.3f, 0.2f, 0.2f, -0.1f, 0.15f, 0.1f}, coarse),
      turned_inside_out(gpuprims::tessellate(core::Cylinder{0.7f, 1.5f}, coarse))};
  meshes.push_back(meshes[1]);
  meshes.back().normals.clear();  // flat triangles
  std::vector<Shape> shapes;
  for (const core::Mesh& mesh : meshes) shapes.push_back({.mesh = &mesh});
  check(shapes, kRasterised);
}

}  // namespace
}  // namespace sightline::tests::surfaces_test
