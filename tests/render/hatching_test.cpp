// Hatching of cut faces (EngineConfig::drawing.looks.hatching): every pixel of boxes, cylinders and meshes cut by
// random planes, against lines counted from the world's origin in double.
#include <random>

#include <gtest/gtest.h>

#include "sightline/engine/engine.h"
#include "sightline/render/image/image.h"
#include "sightline/tests/render/image_check.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests::hatching_test {
namespace {

using core::View;
using engine::Engine;
using engine::EngineConfig;
using engine::Hatching;

constexpr int kWidth = 160, kHeight = 120;
constexpr double kAspect = double(kWidth) / kHeight, kNear = 0.05, kPeriod = 1048576.0;
constexpr Hatching kHatching{0.8f, 6.0f};

/// Where a ray meets a plane.
dvec3 meeting(const PixelRay& ray, const core::Plane& plane) {
  return ray.origin - core::evaluate(plane, ray.origin) / glm::dot(plane.normal, ray.direction) * ray.direction;
}

/// The share of a pixel that lines cover, by the words of engine::Hatching and hatching.glsl.
double cover(const View& view, const core::Plane& plane, core::ItemId item, int x, int y, const Hatching& hatching) {
  const dvec3 n = glm::normalize(plane.normal), level = glm::cross(dvec3(0, 0, 1), n);
  const dvec3 along = glm::length(level) > 0.0 ? glm::normalize(level) : dvec3(1, 0, 0), up = glm::cross(n, along);
  const auto kind = int((to_index(item) * 0x9e3779b1u >> 16) * 6u >> 16);
  const dvec3 across = kind / 3 == 0 ? up + along : up - along;
  const auto place = [&](double px, double py) {
    return glm::dot(across, meeting(pixel_ray(view, kWidth, kHeight, px, py), plane));
  };
  const double metres = std::hypot(place(x + 0.5, y) - place(x - 0.5, y), place(x, y + 0.5) - place(x, y - 0.5));
  double wide = std::pow(2.0, -24);
  while (wide < metres * hatching.spacing) wide *= 2.0;
  const double at = (place(x, y) + kind % 3 * kPeriod / 3.0) / wide, line = std::round(at);
  const double width = std::max(1.0, hatching.spacing / 6.0);
  const double covered = std::clamp(0.5 * width + 0.5 - std::abs(at - line) * wide / metres, 0.0, 1.0);
  if (std::fmod(line, 2.0) == 0.0) return covered;
  const double t = std::clamp(std::log2(wide / (metres * hatching.spacing)) / 0.3, 0.0, 1.0);
  return covered * t * t * (3.0 - 2.0 * t);
}

class HatchingTest : public GlTest {
 protected:
  EngineConfig configured(const Hatching& hatching) {
    EngineConfig config;
    config.draw = config.drawing.ids = true;
    config.culling.culler = engine::CullerChoice::kCpu;
    config.width = kWidth;
    config.height = kHeight;
    config.context.application = &*context;
    config.drawing.looks.hatching = hatching;
    return config;
  }
  static image::Image image(Engine& engine, const View& view) {
    EXPECT_TRUE(engine.frame(view));
    return *engine.read_colour();
  }

  /// Boxes, cylinders and meshes about `centre`, light and dark ones.
  void fill(const dvec3& centre, double size) {
    const core::MaterialId colours[] = {scene.add_material({"light", {0.9f, 0.8f, 0.5f}}),
                                        scene.add_material({"dark", {0.1f, 0.12f, 0.2f}})};
    const core::Box box{float(size), float(size), float(size)};
    const core::MeshId mesh = scene.add_mesh(gpuprims::tessellate(box)).value();
    for (int i = 0; i < 9; ++i) {
      Shape shape{.primitive = box};
      shape.world_from_item = core::translation(centre + 1.2 * size * dvec3(i % 3 - 1, 0.2 * i - 1.0, i / 3 - 1));
      if (i % 3 == 1) shape.primitive = core::Cylinder{float(0.5 * size), float(2.0 * size)};
      shape.item = i % 3 == 2 ? scene.add_mesh_instance(scene.root(), mesh, shape.world_from_item)
                              : scene.add_primitive(scene.root(), shape.primitive, shape.world_from_item);
      scene.set_material(shape.item, colours[i % 2]);
      shapes.push_back(shape);
    }
  }

  struct Counts {
    int cut = 0, lined = 0;
  };
  /// Compares every clear pixel of an image with the plain one. `may_differ`: share of those of cut faces.
  Counts check(Engine& plain, Engine& hatched, const View& view, const Hatching& hatching = kHatching,
               double may_differ = 0.0) {
    const image::Image before = image(plain, view), after = image(hatched, view);
    const image::IdImage ids = *hatched.read_ids();
    Counts counts;
    int wrong = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const std::size_t pixel = std::size_t(y * kWidth + x);
        const PixelHits around = look_around(shapes, view, kWidth, kHeight, x, y);
        if (!around.clear() || around.centre().items.size() > 1) continue;  // where items overlap, either may show
        if (around.hits > 0 && ids.ids[pixel] != to_index(around.centre().items[0]) + 1) ++wrong;
        const PixelRay ray = pixel_ray(view, kWidth, kHeight, x, y);
        double share = 0.0;
        if (around.hits > 0 && around.centre().cut) {
          const dvec3 point = ray.origin + around.centre().depth * ray.direction;
          const auto plane = std::min_element(
              view.sections.begin(), view.sections.end(), [&](const core::Plane& a, const core::Plane& b) {
                return std::abs(core::evaluate(a, point)) < std::abs(core::evaluate(b, point));
              });
          share = hatching.strength * cover(view, *plane, core::ItemId{ids.ids[pixel] - 1}, x, y, hatching);
          ++counts.cut;
        }
        counts.lined += share > 0.5 * hatching.strength;
        const auto* from = &before.pixels[3 * pixel];
        const double light = 0.299 * from[0] + 0.587 * from[1] + 0.114 * from[2];
        for (int channel = 0; channel < 3; ++channel) {
          const double expected = from[channel] * (1.0 - share) + (light < 0.3 * 255.0 ? 255.0 : 0.0) * share;
          if (std::abs(expected - after.pixels[3 * pixel + std::size_t(channel)]) <= (share == 0.0 ? 1.0 : 5.0))
            continue;
          if (++wrong <= 4 && may_differ == 0.0)
            ADD_FAILURE() << x << ", " << y << ": " << int(after.pixels[3 * pixel + std::size_t(channel)]) << ", not "
                          << expected << ", before " << int(from[channel]) << ", share " << share;
          break;
        }
      }
    EXPECT_LE(wrong, may_differ * counts.cut) << "of " << counts.cut << " pixels of cut faces";
    return counts;
  }

  core::Scene scene;
  std::vector<Shape> shapes;
};

class HatchingAtPlaces : public HatchingTest, public testing::WithParamInterface<double> {};
INSTANTIATE_TEST_SUITE_P(, HatchingAtPlaces, testing::Values(0.0, 3000.0, 1e7),
                         [](const auto& place) { return "m" + std::to_string(long(place.param)); });

/// Any planes and cameras, perspective and parallel, near and far, and sizes from millimetres to hundreds of metres.
TEST_P(HatchingAtPlaces, LiesWhereTheWorldSays) {
  const unsigned seed = 5;
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
  const auto direction = [&] { return glm::normalize(dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1) + 1e-3)); };
  Counts all;
  for (const double size : {0.02, 1.0, 300.0}) {
    if (size < 1.0 && GetParam() > 1e6) continue;  // eyes themselves are known to 2e-9 m there
    const dvec3 centre = GetParam() * dvec3(1.0, -0.7, 0.3);
    scene = core::Scene();
    shapes.clear();
    fill(centre, size);
    auto plain = Engine::create(scene, configured({})), hatched = Engine::create(scene, configured(kHatching));
    ASSERT_TRUE(plain && hatched);
    for (int i = 0; i < 8; ++i) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", size " << size << ", image " << i);
      const dvec3 aside = direction();
      const core::Pose pose{centre + uniform(2.5, 9.0) * size * aside, centre, {0, 0, 1}};
      View view = i % 3 == 2 ? *View::orthographic(pose, uniform(1.0, 5.0) * size, kAspect, -1e3 * size, 1e3 * size)
                             : *View::perspective(pose, 0.7, kAspect, kNear * size);
      const dvec3 normals[] = {direction(), {0, 0, -1}, {0, 1, 0}, {1e-7, 0, -1}};
      const dvec3 normal = normals[i % 4] * (glm::dot(normals[i % 4], aside) < 0.0 ? 1.0 : -1.0);
      view.sections.push_back({normal * uniform(0.5, 2.0), 0.0});
      view.sections[0].offset = -glm::dot(view.sections[0].normal, centre + uniform(-0.3, 0.3) * size * direction());
      if (i % 2 == 1) {
        view.sections.push_back({direction(), 0.0});
        view.sections[1].offset = -glm::dot(view.sections[1].normal, centre);
        view.section_mode = i % 4 == 1 ? core::SectionMode::kUnion : core::SectionMode::kIntersection;
      }
      const Counts counts = check(*plain, *hatched, view);
      all.cut += counts.cut;
      all.lined += counts.lined;
    }
  }
  EXPECT_GT(all.cut, 20000);
  EXPECT_GT(all.lined, all.cut / 30);
  EXPECT_LT(all.lined, all.cut / 4);
}

/// A parallel eye may stand kilometres behind what it sees of a plane.
TEST_F(HatchingTest, StaysExactBeforeADistantParallelEye) {
  fill({0, 0, 0}, 0.05);
  auto plain = Engine::create(scene, configured({})), hatched = Engine::create(scene, configured(kHatching));
  ASSERT_TRUE(plain && hatched);
  const dvec3 aside = glm::normalize(dvec3(0.3, -1.0, 0.4));
  View view = *View::orthographic({2e4 * aside, {0, 0, 0}, {0, 0, 1}}, 0.2, kAspect, 1.9e4, 2.1e4);
  view.sections = {{{0, 1, 0}, 0.003}};
  // What is cut is known to a millimetre only, so that other items show at a few pixels.
  EXPECT_GT(check(*plain, *hatched, view, kHatching, 0.01).lined, 200);
}

/// Moved by whole periods, all is the same.
TEST_F(HatchingTest, IsTheSameFarFromTheOrigin) {
  const dvec3 far(10.0 * kPeriod, -3.0 * kPeriod, kPeriod);
  image::Image seen[2];
  for (const bool moved : {false, true}) {
    scene = core::Scene();
    shapes.clear();
    const dvec3 centre = moved ? far : dvec3(0.0);
    fill(centre, 1.0);
    auto engine = Engine::create(scene, configured(kHatching));
    ASSERT_TRUE(engine);
    View view = *View::perspective({centre + dvec3(2.25, -6.0, 3.5), centre, {0, 0, 1}}, 0.7, kAspect, kNear);
    view.sections = {{{0, 1, 0}, -centre.y - 0.125}, {{0, 0, -1}, centre.z + 0.5}};
    seen[moved] = image(*engine, view);
  }
  const auto difference = image::compare(seen[0], seen[1]);
  ASSERT_TRUE(difference);
  EXPECT_LT(difference->pixels, kWidth * kHeight / 500) << "at edges";
}

/// Strength, spacing and width as asked for; switched without a new engine, and off as if it had never been on.
TEST_F(HatchingTest, ConfigureSwitchesIt) {
  fill({0, 0, 0}, 1.0);
  auto plain = Engine::create(scene, configured({})), engine = Engine::create(scene, configured({}));
  ASSERT_TRUE(plain && engine);
  View view = *View::perspective({{2.0, -5.0, 3.0}, {0, 0, 0}, {0, 0, 1}}, 0.7, kAspect, kNear);
  view.sections = {{{0, 1, 0}, 0.1}};
  const image::Image before = image(*engine, view);
  for (const Hatching& hatching : {Hatching{1.0f, 6.0f}, {0.4f, 24.0f}, {0.7f, 4.0f}}) {
    EngineConfig changed = engine->config();
    changed.drawing.looks.hatching = hatching;
    ASSERT_TRUE(engine->configure(changed));
    EXPECT_GT(check(*plain, *engine, view, hatching).lined, 100);
  }
  EngineConfig changed = engine->config();
  changed.drawing.looks.hatching = {};
  ASSERT_TRUE(engine->configure(changed));
  EXPECT_EQ(image::compare(image(*engine, view), before)->max, 0);
  for (const Hatching& bad : {Hatching{1.5f, 8.0f}, {std::nanf(""), 8.0f}, {1.0f, 1.0f}, {1.0f, HUGE_VALF}}) {
    changed.drawing.looks.hatching = bad;
    const auto done = engine->configure(changed);
    ASSERT_FALSE(done);
    EXPECT_NE(done.error().message.find("hatching"), std::string::npos) << done.error().message;
  }
}

}  // namespace
}  // namespace sightline::tests::hatching_test
