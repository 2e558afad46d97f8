// What touches a section plane is whole: items of all sorts with a face in the plane, wherever the plane lies and
// however it is turned, drawn with each culler and traced, each pixel against the item that covers that place of it.
#include <random>

#include <gtest/gtest.h>

#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/raytrace/tracer.h"
#include "sightline/tests/render/pixel_reference.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests::section_faces_test {
namespace {

using core::dmat3;
using core::View;

constexpr int kWidth = 160, kHeight = 120, kCells = 6;

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * double(random()) / 4294967296.0;
}

/// How items lie to the plane.
enum class Side { kKept, kRemoved, kBoth, kIn, kCount };

/// A plane somewhere in the world, z = 0 of its frame, of which z < 0 is kept. Items touch it, one for each cell.
struct Site {
  core::Affine frame;
  double cell;  ///< metres
  core::Scene scene;
  std::vector<core::ItemId> items;
  std::vector<Side> sides;
};

core::Primitive random_shape(std::mt19937& random, double size, double height) {
  switch (random() % 3) {
    case 0:
      return core::Cylinder{float(0.5 * size), float(height)};
    case 1:
      return core::Snout{float(0.5 * size), float(0.5 * size), float(height), 0, 0, 0, 0, 0, 0};
    default:
      return core::Box{float(size), float(size), float(height)};
  }
}

void fill(Site& site, std::mt19937& random) {
  for (int i = 0; i < kCells * kCells; ++i) {
    const auto side = Side(random() % unsigned(Side::kCount));
    const double height = side == Side::kIn ? 0.0 : uniform(random, 0.01, 2.0) * site.cell;
    const core::Primitive shape = side == Side::kIn
                                      ? core::Primitive(core::Box{float(0.8 * site.cell), float(0.8 * site.cell), 0.0f})
                                      : random_shape(random, 0.8 * site.cell, height);
    const double z = side == Side::kKept ? -0.5 * height : side == Side::kRemoved ? 0.5 * height : 0.0;
    const core::dvec3 place{(i % kCells - 0.5 * (kCells - 1)) * site.cell,
                            (i / kCells - 0.5 * (kCells - 1)) * site.cell, z};
    const core::Affine placed{site.frame.linear, site.frame.linear * place + site.frame.origin};
    core::Scene& scene = site.scene;
    site.sides.push_back(side);
    site.items.push_back(
        random() % 2 == 0
            ? scene.add_primitive(scene.root(), shape, placed)
            : scene.add_mesh_instance(scene.root(), scene.add_mesh(gpuprims::tessellate(shape)).value(), placed));
  }
}

dmat3 random_turn(std::mt19937& random) {
  if (random() % 2 == 0) return dmat3(1.0);
  const dvec3 z = glm::normalize(dvec3(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, 0.1, 1)));
  const dvec3 x = glm::normalize(glm::cross(dvec3(0, 1, 0.1), z));
  return {x, glm::cross(z, x), z};
}

/// Sees the plane from the removed side, and sometimes from the kept one, straight on.
View random_view(const Site& site, std::mt19937& random) {
  const bool kept = random() % 4 == 0;
  const double away = uniform(random, 1.0, 20.0) * kCells * site.cell;
  const dvec3 towards =
      kept ? dvec3(0, 0, -1) : glm::normalize(dvec3(uniform(random, -1.5, 1.5), uniform(random, -1.5, 1.5), 1.0));
  const dvec3 eye = site.frame.linear * (away * towards) + site.frame.origin;
  const core::Pose pose{eye, site.frame.origin, site.frame.linear[1]};
  const double height = kCells * site.cell, aspect = double(kWidth) / kHeight;
  View view = kept || random() % 3 == 0
                  ? *View::orthographic(pose, height, aspect, 0.01 * away, 10.0 * away)
                  : *View::perspective(pose, 2.0 * std::atan(0.5 * height / away), aspect, 0.01 * away);
  const auto plane = [&](const dvec3& n, double offset) {
    const dvec3 normal = uniform(random, 0.5, 2.0) * (site.frame.linear * n);
    return core::Plane{normal, -glm::dot(normal, site.frame.origin + site.frame.linear * (offset * n))};
  };
  view.sections = {plane({0, 0, -1}, 0.0)};
  view.section_mode = random() % 2 == 0 ? core::SectionMode::kUnion : core::SectionMode::kIntersection;
  if (random() % 2 == 0)  // all of the items, or nothing of them
    view.sections.push_back(
        plane({1, 0, 0}, (view.section_mode == core::SectionMode::kUnion ? 100.0 : -100.0) * site.cell));
  return view;
}

/// The item whose face, or cut face, is in the plane where a ray meets it, well within the item's rim; or none. From
/// the kept side others stand before the plane.
const core::ItemId* item_there(const Site& site, const dvec3& world, double rim, bool from_kept) {
  const dvec3 p = glm::transpose(site.frame.linear) * (world - site.frame.origin) / site.cell + 0.5 * kCells;
  const int column = int(std::floor(p.x)), row = int(std::floor(p.y));
  if (column < 0 || column >= kCells || row < 0 || row >= kCells) return nullptr;
  const std::size_t cell = std::size_t(row * kCells + column);
  if (from_kept && site.sides[cell] != Side::kRemoved && site.sides[cell] != Side::kIn) return nullptr;
  const double from_middle = std::hypot(p.x - column - 0.5, p.y - row - 0.5);
  return from_middle < 0.39 - rim / site.cell ? &site.items[cell] : nullptr;
}

/// How many pixels were compared, and how many differed.
struct Compared {
  int pixels = 0, traced = 0, drawn = 0, deep = 0;
};

void compare(const Site& site, const View& view, const raytrace::Tracer& tracer, const render::RenderTarget& target,
             Compared& sum) {
  const image::IdImage ids = target.read_ids();
  const image::DepthImage depth = target.read_depth(view);
  const double pixel = 3.0 * kCells * site.cell / kHeight;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const PixelRay ray = pixel_ray(view, kWidth, kHeight, x, y);
      const core::Plane& plane = view.sections[0];
      const double slope = glm::dot(plane.normal, ray.direction), t = -core::evaluate(plane, ray.origin) / slope;
      const dvec3 point = ray.origin + t * ray.direction;
      const core::ItemId* const item = item_there(site, point, pixel, slope < 0.0);
      if (!item) continue;
      ++sum.pixels;
      const auto hit = tracer.nearest({ray.origin, ray.direction, ray.t_near}, raytrace::filter_of(view));
      sum.traced += !hit || !*hit || (*hit)->item != *item || glm::distance((*hit)->point, point) > 1e-4 * t;
      const std::size_t at = std::size_t(y * kWidth + x);
      sum.drawn += ids.ids[at] != to_index(*item) + 1;
      sum.deep += !(std::abs(double(depth.metres[at]) - t) < 1e-4 * t);
    }
}

using SectionFaces = GlTest;

TEST_F(SectionFaces, AreWholeInThePlane) {
  Compared all;
  for (unsigned seed = 0; seed < 36; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    Site site;
    constexpr double kFar[] = {0.0, 1e6, -1e7};
    site.cell = std::pow(10.0, uniform(random, -1.0, 1.5));
    site.frame = {random_turn(random), kFar[seed % 3] * dvec3(1.0, 0.7, 0.1) + dvec3(uniform(random, -9, 9), 3.1, 0.0)};
    fill(site, random);
    engine::EngineConfig config;
    config.draw = config.drawing.ids = true;
    config.width = kWidth;
    config.height = kHeight;
    config.context.application = &*context;
    config.culling.culler = seed % 2 == 0 ? engine::CullerChoice::kGpu : engine::CullerChoice::kCpu;
    auto engine = engine::Engine::create(site.scene, config);
    ASSERT_TRUE(engine) << engine.error().message;
    const core::Snapshot snapshot(site.scene);
    const auto tracer = raytrace::Tracer::create(snapshot);
    ASSERT_TRUE(tracer);
    Compared of_site;
    for (int i = 0; i < 3; ++i) {
      const View view = random_view(site, random);
      ASSERT_TRUE(engine->frame(view));
      engine->finish();
      compare(site, view, *tracer, engine::EngineParts::drawing(*engine)->target(), of_site);
    }
    EXPECT_EQ(of_site.traced, 0) << "of " << of_site.pixels;
    EXPECT_EQ(of_site.drawn, 0) << "of " << of_site.pixels;
    EXPECT_EQ(of_site.deep, 0) << "of " << of_site.pixels;
    all.pixels += of_site.pixels;
  }
  EXPECT_GT(all.pixels, 150000) << "hardly anything was seen";
}

}  // namespace
}  // namespace sightline::tests::section_faces_test
