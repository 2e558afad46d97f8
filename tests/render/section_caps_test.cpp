// Section planes cut closed meshes open to filled faces: every pixel of random stacks of boxes, as meshes and as
// primitives, against the spans of its ray inside them (image_check.h).
#include <random>

#include <gtest/gtest.h>

#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/tests/render/image_check.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests::section_caps_test {
namespace {

using core::dmat3;
using core::View;

constexpr int kWidth = 96, kHeight = 72;
constexpr double kAspect = double(kWidth) / kHeight, kNear = 0.1;
constexpr Tolerance kTolerance{1e-5, 0.02};

core::Mesh mesh_of(const core::Box& box, bool inverted = false) {
  core::Mesh mesh = gpuprims::tessellate(box);
  if (inverted)
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) std::swap(mesh.indices[i], mesh.indices[i + 1]);
  return mesh;
}

/// An item that is a box: as a primitive, or as a mesh.
Shape add_box(core::Scene& scene, const core::Box& box, const core::Affine& placed, bool as_mesh,
              bool inverted = false) {
  Shape shape{.primitive = box};
  shape.world_from_item = placed;
  shape.item = as_mesh ? scene.add_mesh_instance(scene.root(), scene.add_mesh(mesh_of(box, inverted)).value(), placed)
                       : scene.add_primitive(scene.root(), box, placed);
  return shape;
}

/// How many clear pixels showed a cut face.
int check(Camera& camera, std::span<const Shape> shapes, const View& view, const Tolerance& tolerance = kTolerance) {
  const std::vector<PixelHits> seen = look_at(shapes, view, kWidth, kHeight);
  return compare(camera.draw(view, shapes), seen, tolerance).cut;
}

using SectionCaps = GlTest;

/// Boxes about the origin, some nested, some overlapping, turned, mirrored and sheared; every fourth is a primitive,
/// every third mesh inside out.
std::vector<Shape> add_random_boxes(core::Scene& scene, std::mt19937& random, int count) {
  const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
  std::vector<Shape> shapes;
  for (int i = 0; i < count; ++i) {
    const core::Box box{float(uniform(0.3, 2.5)), float(uniform(0.3, 2.5)), float(uniform(0.3, 2.5))};
    core::Affine placed;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) placed.linear[c][r] = (c == r ? 1.0 : 0.0) + uniform(-0.4, 0.4);
    if (i % 2 == 1) placed.linear[0] = -placed.linear[0];
    placed.origin = dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    shapes.push_back(add_box(scene, box, placed, i % 4 != 3, i % 3 == 2));
  }
  return shapes;
}

View random_cut(std::mt19937& random, int sections) {
  const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
  const auto direction = [&] { return glm::normalize(dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1) + 1e-3)); };
  View view = *View::perspective({6.0 * direction(), {0, 0, 0}, {0, 0, 1}}, 0.6, kAspect, kNear);
  for (int i = 0; i < sections; ++i) view.sections.push_back({direction(), uniform(-0.5, 0.5)});
  view.section_mode = random() % 2 ? core::SectionMode::kUnion : core::SectionMode::kIntersection;
  return view;
}

TEST_F(SectionCaps, FillStacksOfMeshesAndPrimitives) {
  constexpr unsigned kStacks = 60;
  core::Scene scene;
  std::vector<std::vector<Shape>> stacks;
  std::vector<View> views;
  for (unsigned seed = 0; seed < kStacks; ++seed) {
    std::mt19937 random(seed);
    stacks.push_back(add_random_boxes(scene, random, 1 + int(seed % 9)));
    views.push_back(random_cut(random, 1 + int(seed % 3)));
  }
  Camera camera(*context, scene, kWidth, kHeight);
  int cut = 0;
  for (unsigned seed = 0; seed < kStacks; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    // Planes are moved outwards by rounding, and so is, by much more, where two of them meet at a small angle.
    cut += check(camera, stacks[seed], views[seed], {kTolerance.depth, kTolerance.degrees, 1});
  }
  EXPECT_GT(cut, 15000) << "hardly anything was cut";
}

TEST_F(SectionCaps, NameTheInnerSolidOfANestedPairByItsOwnCrossings) {
  // The point cut is in the outer box alone although the inner one's far wall comes first behind it.
  core::Scene scene;
  const Shape boxes[] = {add_box(scene, {4, 4, 4}, {}, true),
                         add_box(scene, {1, 1, 1}, core::translation({0, 1.2, 0}), true)};
  Camera camera(*context, scene, kWidth, kHeight);
  View view = *View::perspective({{0, -8, 0.5}, {0, 0, 0}, {0, 0, 1}}, 0.7, kAspect, kNear);
  view.sections = {{{0, 1, 0}, 0.0}};
  EXPECT_GT(check(camera, boxes, view), 1000);
  view.sections = {{{0, 1, 0}, -1.2}};  // through both
  EXPECT_GT(check(camera, boxes, view), 1000);
}

TEST_F(SectionCaps, LeaveOpenMeshesOpen) {
  core::Scene scene;
  core::Mesh sheet = mesh_of({2, 2, 2});
  sheet.indices.resize(sheet.indices.size() - 6);
  Shape shape{.mesh = &sheet};
  shape.closed = false;
  shape.item = scene.add_mesh_instance(scene.root(), scene.add_mesh(sheet).value());
  Camera camera(*context, scene, kWidth, kHeight);
  View view = *View::perspective({{0.3, -8, 0.1}, {0, 0, 0}, {0, 0, 1}}, 0.5, kAspect, kNear);
  view.sections = {{{0, 1, 0}, 0.0}};
  EXPECT_EQ(check(camera, {&shape, 1}, view), 0);
}

/// Boxes on both sides of the plane and across it. Neighbouring triangles share pixels, each by other samples.
TEST_F(SectionCaps, CountCrossingsOncePerPixelOfManySamples) {
  core::Scene scene;
  const double c = std::cos(0.4), s = std::sin(0.4);
  const dmat3 turn = dmat3(c, s, 0, -s, c, 0, 0, 0, 1) * dmat3(1, 0, 0, 0, c, s, 0, -s, c);
  const Shape boxes[] = {add_box(scene, {1.5, 1.5, 1.5}, {turn, {-2, 2.5, 0}}, true),
                         add_box(scene, {1.5, 1.5, 1.5}, {turn, {0, 0, 0}}, true),
                         add_box(scene, {1.5, 1.5, 1.5}, {turn, {2, -2.5, 0}}, true)};
  Camera camera(*context, scene, kWidth, kHeight, 4);
  View view = *View::perspective({{0.5, -9, 1}, {0, 0, 0}, {0, 0, 1}}, 0.6, kAspect, kNear);
  view.sections = {{{0.1, 1, 0}, 0.0}};
  // A pixel's id and depth are those of a sample, which may lie anywhere within it; normals are averaged.
  Image image = camera.draw(view, boxes);
  image.normals = {};
  const std::vector<PixelHits> seen = look_at(boxes, view, kWidth, kHeight, 0.5);
  EXPECT_GT(compare(image, seen, kTolerance).cut, 200);
}

/// What an engine notes of meshes, and of pixels, follows edits and sizes.
TEST_F(SectionCaps, FollowEditsAndSizes) {
  core::Scene scene;
  std::vector<Shape> boxes = {add_box(scene, {1, 2, 1}, core::translation({-1, 0, 0}), true)};
  engine::EngineConfig config;
  config.draw = config.drawing.ids = true;
  config.culling.rebuild_share = 0.0;
  config.width = 64;
  config.height = 48;
  config.context.application = &*context;
  auto engine = engine::Engine::create(scene, config);
  ASSERT_TRUE(engine) << engine.error().message;
  const core::MeshId mesh = scene.mesh_of(boxes[0].item);
  const auto expect_shown = [&](int width, int height) {
    SCOPED_TRACE(testing::Message() << width << " x " << height << ", " << boxes.size() << " boxes");
    ASSERT_TRUE(engine->resize(width, height));
    View view = *View::perspective({{0.3, -7, 1}, {0, 0, 0}, {0, 0, 1}}, 0.7, double(width) / height, kNear);
    view.sections = {{{0.1, 1, 0.05}, 0.1}};
    for (int frame = 0; frame < 2; ++frame) {  // what the first leaves behind is not counted in the second
      ASSERT_TRUE(engine->frame(view));
      engine->finish();
      const render::RenderTarget& target = engine::EngineParts::drawing(*engine)->target();
      const Image image{view, target.read_colour(), target.read_depth(view), target.read_ids(), {}};
      EXPECT_GT(compare(image, look_at(boxes, view, width, height), kTolerance).cut, 50);
    }
  };
  const std::pair<int, int> sizes[] = {{64, 48}, {64, 80}, {31, 57}, {96, 48}, {96, 48}};
  for (std::size_t step = 0; step < std::size(sizes); ++step) {
    const auto& [width, height] = sizes[step];
    ASSERT_NO_FATAL_FAILURE(expect_shown(width, height));
    Shape added = boxes[0];  // overlaps the one before
    added.world_from_item = core::translation({-0.3 + 0.7 * double(step), 0.2 * double(step), 0.3});
    added.item = scene.add_mesh_instance(scene.root(), mesh, added.world_from_item);
    boxes.push_back(added);
    ASSERT_TRUE(engine->commit());
    ASSERT_NO_FATAL_FAILURE(expect_shown(width, height));
  }
}

TEST(Enclosure, TellsSolidsFromSheets) {
  core::Mesh mesh = mesh_of({1, 2, 3});
  EXPECT_EQ(core::enclosure(mesh), core::Enclosure::kInside);
  EXPECT_EQ(core::enclosure(mesh_of({1, 2, 3}, true)), core::Enclosure::kOutside);
  std::swap(mesh.indices[0], mesh.indices[1]);
  EXPECT_EQ(core::enclosure(mesh), core::Enclosure::kNothing) << "one triangle turned";
  mesh = mesh_of({1, 2, 3});
  mesh.indices.resize(mesh.indices.size() - 3);
  EXPECT_EQ(core::enclosure(mesh), core::Enclosure::kNothing) << "one triangle missing";
  EXPECT_EQ(core::enclosure({}), core::Enclosure::kNothing);
}

}  // namespace
}  // namespace sightline::tests::section_caps_test
