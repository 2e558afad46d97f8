// Occluders within solids against the reference intersections: what a pixel holds, its line of sight meets.
#include "sightline/culling/occlusion/solid_occluders.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include <gtest/gtest.h>

#include "scenes.h"
#include "sightline/core/scene.h"
#include "sightline/culling/occlusion/internal/inner_occluders.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::tests::solid_occluders_test {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec3;
using core::Kind;
using core::Primitive;
using core::View;
using culling::SolidOccluders;

constexpr int kWidth = 72, kHeight = 48;
constexpr float kNothing = std::numeric_limits<float>::infinity();

/// About 1 in size, with needles and plates among them, slanted snouts, full turns, lengths below 0.
Primitive random_solid(Kind kind, Random& random) {
  const auto length = [&] { return float(magnitude(random, chance(random, 0.2) ? 1e-2 : 0.2, 2.0)); };
  const auto shift = [&] { return chance(random, 0.5) ? 0.0f : float(uniform(random, -1.0, 1.0)); };
  const auto angle = [&] { return chance(random, 0.1) ? 6.2831855f : float(uniform(random, 0.05, 6.3)); };
  Primitive made = primitive_of(kind, length, shift, angle);
  if (auto* torus = std::get_if<core::CircularTorus>(&made); torus && chance(random, 0.8))
    torus->tube_radius = torus->major_radius * float(uniform(random, 0.05, 1.0));
  if (auto* snout = std::get_if<core::Snout>(&made); snout && chance(random, 0.3)) {
    snout->bottom_shear_x = float(uniform(random, -0.5, 0.5));
    snout->top_shear_y = float(uniform(random, -0.5, 0.5));
  }
  if (auto* cylinder = std::get_if<core::Cylinder>(&made); cylinder && chance(random, 0.1)) cylinder->radius *= -1.0f;
  return made;
}

dmat3 random_linear(Random& random) {
  dmat3 linear = random_rotation(random);
  linear *= magnitude(random, 0.3, 3.0);
  if (chance(random, 0.3)) linear[whole(random, 0, 2)] *= -uniform(random, 0.3, 2.0);  // uneven, mirrored
  return linear;
}

View random_sight(Random& random, const dvec3& target) {
  const dvec3 from = random_direction(random), eye = target + magnitude(random, 2.0, 40.0) * from;
  const core::Pose pose{eye, target + point(random, 0.7), {0.1, 0.2, 1.0}};
  const double aspect = double(kWidth) / kHeight;
  if (chance(random, 0.3)) return *View::orthographic(pose, magnitude(random, 2.0, 10.0), aspect, -2.0, 100.0);
  const double near = magnitude(random, 1e-3, 1.0);
  return *View::perspective(pose, uniform(random, 0.2, 1.2), aspect, near);
}

/// Distances at which lines of sight enter a solid, of the image above.
class Reference {
 public:
  Reference(const View& view, const Primitive& solid, const Affine& world_from_item)
      : world_from_clip_(glm::inverse(view.clip_from_world())),
        forward_(-dvec3(glm::transpose(view.eye_from_world())[2])),
        eye_(view.eye()),
        solid_(solid),
        item_from_world_(glm::inverse(world_from_item.linear)),
        origin_(world_from_item.origin) {}

  /// Infinity: it passes by.
  double entry(int x, int y) const {
    const dvec3 near = at(x, y, 1.0), far = at(x, y, 0.25);
    const double start = glm::dot(forward_, near - eye_), rate = glm::dot(forward_, far - near);
    const gpuprims::Hits hits =
        gpuprims::intersect(solid_, {item_from_world_ * (near - origin_), item_from_world_ * (far - near)});
    for (int i = 0; i < hits.count; ++i)
      if (hits.hit[std::size_t(i)].t >= 0.0) return start + rate * hits.hit[std::size_t(i)].t;
    return kNothing;
  }

 private:
  dvec3 at(int x, int y, double z) const {
    const core::dvec4 p =
        world_from_clip_ * core::dvec4((2.0 * x + 1.0) / kWidth - 1.0, (2.0 * y + 1.0) / kHeight - 1.0, z, 1.0);
    return dvec3(p) / p.w;
  }
  core::dmat4 world_from_clip_;
  dvec3 forward_, eye_;
  const Primitive& solid_;
  dmat3 item_from_world_;
  dvec3 origin_;
};

core::VisibleSet all_of(const core::Snapshot& snapshot) {
  core::VisibleSet all;
  all.generation = snapshot.generation();
  all.ranges.push_back({0, core::Slot(snapshot.size())});
  return all;
}

std::vector<float> distances_of(const core::Snapshot& snapshot, const View& view, core::ThreadPool* threads = nullptr,
                                std::span<const float> drawn = {}) {
  SolidOccluders solids;
  culling::DepthPyramid pyramid;
  solids.begin(snapshot, view, kWidth, kHeight);
  solids.add(all_of(snapshot), threads);
  solids.build(pyramid, drawn, threads);
  std::vector<float> distances;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) distances.push_back(pyramid.row(0, y)[x]);
  return distances;
}

std::size_t covered(const std::vector<float>& distances) {
  return std::size_t(std::count_if(distances.begin(), distances.end(), [](float d) { return d < kNothing; }));
}

core::Scene scene_of(const Primitive& solid, const Affine& place) {
  core::Scene scene;
  scene.add_primitive(scene.root(), solid, place);
  return scene;
}

/// A random solid in a random placement, and a scene of it alone.
struct OneSolid {
  OneSolid(Kind kind, Random& random, const dvec3& middle)
      : place{random_linear(random), middle + point(random, 1.0)},
        solid(random_solid(kind, random)),
        scene(scene_of(solid, place)),
        snapshot(scene) {}

  Affine place;
  Primitive solid;
  core::Scene scene;
  core::Snapshot snapshot;
};

struct Pixels {
  std::size_t met = 0, found = 0;  // those of the solid, and of what it hides
};

/// Each pixel that holds a distance must meet the solid there or nearer.
Pixels expect_no_nearer(const std::vector<float>& distances, const Reference& reference) {
  Pixels pixels;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const double exact = reference.entry(x, y);
      const float distance = distances[std::size_t(y * kWidth + x)];
      if (distance < kNothing) {
        EXPECT_GE(distance, exact - 1e-7 * (1.0 + std::abs(exact))) << "pixel " << x << " " << y;
      }
      pixels.met += exact < kNothing;
      pixels.found += distance < kNothing;
    }
  return pixels;
}

/// By kind.
class SolidOccludersOf : public testing::TestWithParam<Kind> {};

TEST_P(SolidOccludersOf, CoverOnlyWhatIsMetAndNoNearer) {
  std::size_t met = 0, found = 0;
  for (std::uint64_t seed = 1; seed <= 250; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const dvec3 middle = chance(random, 0.5) ? dvec3(0.0) : dvec3(4e5, 6e6, 100.0);
    const OneSolid one(GetParam(), random, middle);
    const View view = random_sight(random, middle);
    const Pixels pixels = expect_no_nearer(distances_of(one.snapshot, view), {view, one.solid, one.place});
    met += pixels.met;
    found += pixels.found;
  }
  EXPECT_GT(met, 20'000u);
  // The outline's margin takes much of small solids, the near plane cuts some, and tori have no occluder polygons at
  // their ends.
  const bool torus = GetParam() == Kind::kRectangularTorus || GetParam() == Kind::kCircularTorus;
  EXPECT_GT(found, met * (torus ? 33 : 55) / 100) << "of " << met;
  RecordProperty("percent_covered", int(100 * found / met));
}

/// What a section plane cuts hides nothing. What the near plane cuts hides nothing either, but boxes do where lines of
/// sight enter them beyond it.
TEST_P(SolidOccludersOf, HideNothingWhereTheyAreCut) {
  const bool clips = GetParam() == Kind::kBox;
  int cut = 0, whole_ones = 0, clipped = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const OneSolid one(GetParam(), random, dvec3(0.0));
    View view = random_sight(random, dvec3(0.0));
    if (chance(random, 0.5)) {
      const core::Pose pose{point(random, 2.0), point(random, 1.0), {0, 0, 1}};
      view = *View::perspective(pose, 1.0, double(kWidth) / kHeight, uniform(random, 0.1, 3.0));
    } else {
      const dvec3 normal = random_direction(random);
      view.sections = {{normal, -glm::dot(normal, point(random, 2.0))}};
    }
    const core::dvec4 near = glm::transpose(view.clip_from_world())[3] - glm::transpose(view.clip_from_world())[2];
    bool near_cuts = false, section_cuts = false;
    for (int i = 0; i < 200; ++i) {
      const dvec3 p = core::transform_point(one.place, random_point(one.solid, random));
      near_cuts = near_cuts || glm::dot(near, core::dvec4(p, 1.0)) < 0.0;
      for (const core::Plane& plane : view.sections)
        section_cuts = section_cuts || glm::dot(plane.normal, p) + plane.offset < 0;
    }
    const std::vector<float> distances = distances_of(one.snapshot, view);
    const std::size_t count = covered(distances);
    if (section_cuts || (near_cuts && !clips)) {
      ASSERT_EQ(count, 0u);
    } else if (near_cuts) {
      expect_no_nearer(distances, Reference(view, one.solid, one.place));
      clipped += count > 0;
    }
    cut += near_cuts || section_cuts;
    whole_ones += !near_cuts && count > 0;
  }
  EXPECT_GT(cut, 50);
  EXPECT_GT(whole_ones, 20);
  EXPECT_GE(clipped, clips ? 20 : 0);
}

/// The occluder polygon of a box begins a margin behind its faces. A section plane that cuts less than that leaves the
/// occluder polygon, and the cap lies in front of it.
TEST(SolidOccluders, BoxesCutByLessThanTheirMarginHideWhatLiesBehindTheirCaps) {
  constexpr float kSide = 2.0f, kLess = 0x1p-10f, kMore = 0x1p-9f;
  const auto box_cut_by = [](float depth) { return core::Box{kSide - depth, kSide, kSide}; };
  const double of_radius = SolidOccluders::kLostOfRadius * kSide / 2.0;
  const double of_box = SolidOccluders::kLostOfBox * kSide * std::sqrt(3.0);
  ASSERT_GT(of_radius + of_box, kLess);
  ASSERT_LT(of_radius + 2.0 * of_box, kMore);
  std::size_t found = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Affine place{random_rotation(random), point(random, 1.0)};
    const core::Scene scene = scene_of(box_cut_by(0.0f), place);
    const core::Snapshot snapshot(scene);
    View view = random_sight(random, place.origin);
    const dvec3 normal = -place.linear[0];
    const auto cut_by = [&](double depth) {
      view.sections = {{normal, kSide / 2.0 - depth - glm::dot(normal, place.origin)}};
      return distances_of(snapshot, view);
    };
    const Affine place_of_rest{place.linear, place.origin + kLess / 2.0 * normal};
    found += expect_no_nearer(cut_by(kLess), {view, box_cut_by(kLess), place_of_rest}).found;
    EXPECT_EQ(covered(cut_by(kMore)), 0u);
  }
  EXPECT_GT(found, 5'000u);
}

/// A solid stays where one line of sight meets it no farther than what its pixel holds, though all others are hidden.
TEST_P(SolidOccludersOf, AreLeftOutOnlyWhereAllPixelsHideThem) {
  constexpr std::size_t kPixels = std::size_t(kWidth) * kHeight;
  int met = 0, hidden = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const dvec3 middle = chance(random, 0.5) ? dvec3(0.0) : dvec3(4e5, 6e6, 100.0);
    const OneSolid one(GetParam(), random, middle);
    View view = random_sight(random, middle);
    if (chance(random, 0.3)) {
      const core::Pose pose{middle + point(random, 2.0), middle + point(random, 1.0), {0, 0, 1}};
      view = *View::perspective(pose, 1.0, double(kWidth) / kHeight, 0.01);
    }
    SolidOccluders solids;
    solids.begin(one.snapshot, view, kWidth, kHeight);
    const Reference reference(view, one.solid, one.place);
    std::vector<float> distances(kPixels, -1e6f);
    std::vector<std::size_t> meeting;
    for (std::size_t i = 0; i < kPixels; ++i)
      if (reference.entry(int(i) % kWidth, int(i) / kWidth) < kNothing) meeting.push_back(i);
    const auto stays = [&] {
      culling::DepthPyramid pyramid;
      pyramid.build(distances, kWidth, kHeight);
      core::VisibleSet items = all_of(one.snapshot);
      solids.leave_out_occluded(items, pyramid);
      return items.count() > 0;
    };
    if (meeting.empty()) continue;
    ++met;
    hidden += !stays();
    for (int i = 0; i < 12; ++i) {
      const std::size_t pixel = meeting[std::size_t(whole(random, 0, int(meeting.size()) - 1))];
      const double entry = reference.entry(int(pixel) % kWidth, int(pixel) / kWidth);
      const float before = std::exchange(distances[pixel], float(entry));
      ASSERT_TRUE(stays()) << "pixel " << int(pixel) % kWidth << " " << int(pixel) / kWidth << " of " << meeting.size();
      distances[pixel] = before;
    }
  }
  EXPECT_GT(met, 150);
  const bool has_fronts =
      GetParam() == Kind::kCylinder || GetParam() == Kind::kSnout || GetParam() == Kind::kCircularTorus;
  EXPECT_GE(hidden, has_fronts ? met / 8 : 0) << "of " << met;
  RecordProperty("percent_hidden", 100 * hidden / met);
}

INSTANTIATE_TEST_SUITE_P(Kinds, SolidOccludersOf,
                         testing::Values(Kind::kPyramid, Kind::kBox, Kind::kRectangularTorus, Kind::kCircularTorus,
                                         Kind::kEllipticalDish, Kind::kSphericalDish, Kind::kSnout, Kind::kCylinder,
                                         Kind::kSphere),
                         [](const auto& kind) { return std::string(core::name_of(kind.param)); });

const View kFront = *View::perspective({{0, -10, 0}, {0, 0, 0}, {0, 0, 1}}, 0.6, double(kWidth) / kHeight, 0.1);

TEST(SolidOccluders, LeaveOutWhatHidesNothing) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  core::Scene scene;
  const core::MaterialId glass = scene.add_material({.name = "glass", .alpha = 0.5f});
  const core::ItemId wall = scene.add_primitive(scene.root(), core::Box{1, 1, 1}, {}, glass);
  scene.add_primitive(scene.root(), core::Line{-1, 1});
  const core::Mesh mesh = gpuprims::tessellate(core::Sphere{2.0f});
  scene.add_mesh_instance(scene.root(), scene.add_mesh(mesh).value());
  for (const Primitive& flat : std::initializer_list<Primitive>{
           core::Cylinder{1, 0}, core::Cylinder{0, 1}, core::Sphere{0}, core::CircularTorus{1, 0, 1},
           core::CircularTorus{1, 0.5f, 0}, core::CircularTorus{1, 2, 1}, core::Snout{0, 0, 1, 0, 0, 0, 0, 0, 0},
           core::Snout{1, 1, 1, 0, 0, 1.5f, 0, 1.5f, 0}, core::EllipticalDish{1, 0}, core::SphericalDish{0, 1},
           core::RectangularTorus{1, 1, 1, 1}, core::Pyramid{1, 1, 0, 0, 0, 0, 0}, core::Box{1, 0, 1}})
    scene.add_primitive(scene.root(), flat);
  scene.add_primitive(scene.root(), core::Box{1, 1, 1}, {dmat3(1, 0, 0, 0, 1, 0, 1, 1, 0), dvec3(0.0)});  // singular
  const core::Snapshot snapshot(scene);
  EXPECT_EQ(covered(distances_of(snapshot, kFront)), 0u);
  scene.set_material(wall, core::MaterialId{});
  EXPECT_GT(covered(distances_of(core::Snapshot(scene), kFront)), 0u) << "opaque";

  // Parameters that no scene takes.
  std::vector<culling::OccluderPolygon> polygons;
  for (int kind = 0; kind < core::kPrimitiveKindCount; ++kind)
    for (int bad = 0; bad < core::parameter_count(Kind(kind)); ++bad)
      for (const float value : {nan, std::numeric_limits<float>::infinity()}) {
        float parameters[9] = {1, 0.3f, 0.7f, 1, 1, 1, 1, 0, 0};
        parameters[bad] = value;
        culling::add_inner_occluders(Kind(kind), parameters, core::translation({0, 5, 0}), {true, {}}, 1e-3, 1e-3,
                                     polygons);
      }
  culling::OccluderRaster raster;
  raster.begin(kFront, kWidth, kHeight);
  for (const culling::OccluderPolygon& polygon : polygons) {
    const bool finite = std::all_of(polygon.points().begin(), polygon.points().end(),
                                    [](const dvec3& p) { return core::is_finite(p); });
    const culling::WholeSolid solid{{dvec3(-1.0, 4.0, -1.0), dvec3(1.0, 6.0, 1.0)}, 1};
    EXPECT_TRUE(finite || !raster.add_within({&solid, 1}, {&polygon, 1}));
  }
}

/// So far away in front of the eye, or beside.
dvec3 random_middle(Random& random, double far) {
  const double z = uniform(random, -0.6 * far, 0.6 * far), x = uniform(random, -far, far);
  return {x, far, z};
}

/// A convex polygon of four corners in front of or beside the eye, bent or not, perhaps with numbers that are of no
/// use.
std::array<dvec3, 4> random_quad(Random& random, double far) {
  const double size = magnitude(random, 1e-3, 0.4) * far;
  const dvec3 middle = random_middle(random, far);
  const dvec3 u = size * random_direction(random), v = size * random_direction(random);
  std::array<dvec3, 4> quad{middle + u, middle + v, middle - uniform(random, 0.3, 1.0) * u, middle - v};
  if (chance(random, 0.2)) quad[0] += 0.1 * size * random_direction(random);
  if (chance(random, 0.05)) quad[std::size_t(whole(random, 0, 3))].y = std::numeric_limits<double>::quiet_NaN();
  if (chance(random, 0.05)) quad[1] = {quad[1].x, quad[0].y, quad[0].z};  // level
  if (chance(random, 0.05)) quad[2] = quad[3] = quad[0];
  return quad;
}

culling::OccluderPolygon occluder_of(const std::array<dvec3, 4>& quad, int count) {
  culling::OccluderPolygon polygon;
  polygon.count = count;
  polygon.hexahedron = false;
  for (int i = 0; i < count; ++i)
    polygon.corners[std::size_t(i)] = quad[std::size_t(count == 8 ? i / 2 : std::min(i, 3))];
  return polygon;
}

culling::OccluderPolygon parallelogram(const dvec3& middle, const dvec3& u, const dvec3& v) {
  return occluder_of({middle - u - v, middle + u - v, middle + u + v, middle - u + v}, 4);
}

/// From the origin along y, or a little upwards.
View random_front(Random& random) {
  const core::Pose pose{{0, 0, 0}, {0, 1, chance(random, 0.5) ? 0.1 : 0.0}, {0, 0, 1}};
  return chance(random, 0.3) ? *View::orthographic(pose, 20.0, 1.5, -1.0, 1e4)
                             : *View::perspective(pose, 1.0, 1.5, 0.1);
}

/// Quads and octagons are rasterised eight at a time. With a corner twice they have five corners, as occluder polygons
/// that are rasterised one by one, or eight. Then sides and area are the same.
TEST(SolidOccluders, OccluderPolygonsAreTheSameManyAtOnceAndOneByOne) {
  std::size_t covered_pixels = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const View view = random_front(random);
    const int width = whole(random, 1, 150), height = whole(random, 1, 100);
    std::vector<culling::WholeSolid> solids;
    std::array<std::vector<culling::OccluderPolygon>, 3> polygons;  // of four, five and eight corners
    for (int i = whole(random, 1, 30); i > 0; --i) {
      const double far = magnitude(random, 0.3, 100.0);
      const double wide = chance(random, 0.3) ? magnitude(random, 10.0, 1e13) : 3.0;  // then places are less exact
      const core::AabbD box{{-3 * far, 0.5 * far, -3 * far}, {wide * far, 2 * far, 3 * far}};
      solids.push_back({box, std::uint32_t(whole(random, 0, 3))});
      for (std::uint32_t k = 0; k < solids.back().polygons; ++k) {
        const std::array<dvec3, 4> quad = random_quad(random, far);
        polygons[0].push_back(occluder_of(quad, 4));
        polygons[1].push_back(occluder_of(quad, 5));
        polygons[2].push_back(occluder_of(quad, 8));
      }
    }
    const auto image_of = [&](std::size_t form) {
      culling::OccluderRaster raster;
      raster.begin(view, width, height);
      raster.add_within(solids, polygons[form]);
      std::vector<float> distances(std::size_t(width * height));
      raster.distances(distances);
      return distances;
    };
    const std::vector<float> expected = image_of(1);
    covered_pixels += covered(expected);
    for_each_instruction_set([&] {
      ASSERT_EQ(image_of(0), expected) << "quads";
      ASSERT_EQ(image_of(2), expected) << "octagons";
    });
  }
  EXPECT_GT(covered_pixels, 300'000u);
}

/// Parallelograms against lines of sight through pixel centres.
TEST(SolidOccluders, QuadsAreOccludedOnlyByAllTheirPixels) {
  std::size_t met = 0, hidden = 0, quads = 0;
  for (std::uint64_t seed = 1; seed <= 600; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const View view = random_front(random);
    const core::dmat4 world_from_clip = glm::inverse(view.clip_from_world());
    const dvec3 forward = -dvec3(glm::transpose(view.eye_from_world())[2]);
    const int width = whole(random, 1, 60), height = whole(random, 1, 40);
    std::vector<culling::OccluderPolygon> polygons;
    std::vector<std::array<dvec3, 3>> spans;  // middle and half sides
    for (int i = whole(random, 1, 20); i > 0; --i) {
      const double far = magnitude(random, 0.5, 100.0), size = magnitude(random, 1e-2, 0.4) * far;
      const dvec3 middle = random_middle(random, far);
      const dvec3 u = size * random_direction(random), along = random_direction(random),
                  v = magnitude(random, 0.01, 1.0) * size * along;
      spans.push_back({middle, u, v});
      polygons.push_back(parallelogram(middle, u, v));
    }
    std::vector<float> distances(std::size_t(width * height), float(magnitude(random, 0.5, 50.0)));
    for (float& d : distances)
      if (chance(random, 0.02)) d = kNothing;
    culling::DepthPyramid pyramid;
    pyramid.build(distances, width, height);
    culling::OccluderRaster raster;
    raster.begin(view, width, height);
    std::vector<std::uint8_t> seen, others;
    raster.find_seen(polygons, pyramid, 0.0, seen);
    for_each_instruction_set([&] {
      raster.find_seen(polygons, pyramid, 0.0, others);
      ASSERT_EQ(others, seen);
    });
    for (std::size_t i = 0; i < spans.size(); ++i) {
      const auto& [middle, u, v] = spans[i];
      const dvec3 normal = glm::cross(u, v);
      bool is_met = false;
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const auto at = [&](double z) {
            const core::dvec4 p =
                world_from_clip * core::dvec4((2.0 * x + 1.0) / width - 1.0, (2.0 * y + 1.0) / height - 1.0, z, 1.0);
            return dvec3(p) / p.w;
          };
          const dvec3 near = at(1.0), along = at(0.25) - near;
          const double t = glm::dot(middle - near, normal) / glm::dot(along, normal);
          const dvec3 at_plane = near + t * along, from = at_plane - middle;
          const double a = glm::dot(glm::cross(from, v), normal) / glm::dot(normal, normal);
          const double b = glm::dot(glm::cross(u, from), normal) / glm::dot(normal, normal);
          is_met = is_met || (t > 0.0 && std::abs(a) < 1.0 - 1e-9 && std::abs(b) < 1.0 - 1e-9 &&
                              glm::dot(forward, at_plane) < double(distances[std::size_t(y * width + x)]));
        }
      if (is_met) {
        ASSERT_EQ(seen[i], 1) << "quad " << i;
      }
      ++quads, met += is_met, hidden += seen[i] == 0;
    }
  }
  EXPECT_GT(met, quads / 10);
  EXPECT_GT(hidden, quads / 10);
}

/// Sides and corners through pixel centres.
TEST(SolidOccluders, QuadsAreSeenWhereTheyTouchAnUnoccludedPixel) {
  constexpr int kSize = 16;  // pixels of a metre; centres lie at halves
  const View view = *View::orthographic({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, double(kSize), 1.0, -1.0, 100.0);
  culling::OccluderRaster raster;
  raster.begin(view, kSize, kSize);
  const auto seen = [&](const culling::OccluderPolygon& quad, int x, int y) {
    std::vector<float> distances(std::size_t(kSize * kSize), 1.0f);
    distances[std::size_t(y * kSize + x)] = kNothing;
    culling::DepthPyramid pyramid;
    pyramid.build(distances, kSize, kSize);
    std::vector<std::uint8_t> found;
    raster.find_seen({&quad, 1}, pyramid, 0.0, found);
    return found[0] == 1;
  };
  const auto quad_of = [](double left, double right, double bottom, double top) {
    return occluder_of({dvec3{left, 5, bottom}, dvec3{right, 5, bottom}, dvec3{right, 5, top}, dvec3{left, 5, top}}, 4);
  };
  const culling::OccluderPolygon level = quad_of(-2.5, 3.5, -4.5, 1.5);
  const culling::OccluderPolygon askew =
      occluder_of({dvec3{-2.5, 5, 0.5}, {0.5, 5, -2.5}, {3.5, 5, 0.5}, {0.5, 5, 3.5}}, 4);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const double at_x = x + 0.5 - kSize / 2, at_z = y + 0.5 - kSize / 2;
      const bool in_level = at_x >= -2.5 && at_x <= 3.5 && at_z >= -4.5 && at_z <= 1.5;
      const bool in_askew = std::abs(at_x - 0.5) + std::abs(at_z - 0.5) <= 3.0;
      EXPECT_EQ(seen(level, x, y), in_level) << x << " " << y;
      EXPECT_EQ(seen(askew, x, y), in_askew) << x << " " << y;
    }
}

TEST(SolidOccluders, QuadsOfWhichNothingIsKnownAreSeen) {
  culling::OccluderRaster raster;
  raster.begin(kFront, kWidth, kHeight);
  culling::DepthPyramid pyramid;
  pyramid.build(std::vector<float>(std::size_t(kWidth) * kHeight, 1.0f), kWidth, kHeight);
  const auto seen = [&](const dvec3& middle, const dvec3& u, const dvec3& v) {
    std::vector<std::uint8_t> found;
    const culling::OccluderPolygon quad = parallelogram(middle, u, v);
    raster.find_seen({&quad, 1}, pyramid, 0.0, found);
    return found == std::vector<std::uint8_t>{1};
  };
  // Relative to the eye, which looks along y.
  EXPECT_FALSE(seen({0, 5, 0}, {1, 0, 0}, {0, 0, 1})) << "behind all pixels";
  EXPECT_FALSE(seen({50, 5, 0}, {1, 0, 0}, {0, 0, 1})) << "beside the image";
  EXPECT_TRUE(seen({0, 0.5, 0}, {0.1, 0, 0}, {0, 0, 0.1})) << "in front";
  EXPECT_TRUE(seen({0, 5, 0}, {1, 0, 0}, {0, 1, 0})) << "edge-on";
  EXPECT_TRUE(seen({0, 5, 0}, {1, 0, 0}, {2, 0, 0})) << "without area";
  EXPECT_TRUE(seen({0, 5, 0}, {1, 0, 0}, {0, 6, 1})) << "reaches behind the eye";
  EXPECT_TRUE(seen({0, 5, std::numeric_limits<double>::quiet_NaN()}, {1, 0, 0}, {0, 0, 1}));
  EXPECT_TRUE(seen({0, 1e40, 0}, {1e39, 0, 0}, {0, 0, 1e39})) << "too far";
}

/// The image is equal with any number of threads, and nearer where something drawn is.
TEST(SolidOccluders, AreTheSameOnThreadsAndJoinWhatIsDrawn) {
  Random random(3);
  core::Scene scene;
  for (int i = 0; i < 3000; ++i)
    scene.add_primitive(scene.root(), random_solid(Kind(whole(random, 0, 8)), random),
                        {0.2 * random_linear(random), point(random, 3.0)});
  const core::Snapshot snapshot(scene);
  const std::vector<float> expected = distances_of(snapshot, kFront);
  core::ThreadPool threads(4);
  EXPECT_EQ(distances_of(snapshot, kFront, &threads), expected);
  EXPECT_GT(covered(expected), expected.size() / 3);
  std::vector<float> drawn(expected.size()), nearer = expected;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    drawn[i] = float(uniform(random, 5.0, 15.0));
    nearer[i] = std::min(nearer[i], drawn[i]);
  }
  EXPECT_EQ(distances_of(snapshot, kFront, nullptr, drawn), nearer);
}

/// A row of pipes and elbows without gaps hides a wall of boxes behind it.
TEST(SolidOccluders, FeedTheOcclusionTest) {
  core::Scene scene;
  for (int i = 0; i < 9; ++i)
    scene.add_primitive(scene.root(), core::Cylinder{0.3f, 6.0f}, core::translation({0.5 * i - 2.0, 0, 0}));
  const core::Snapshot snapshot(scene);
  SolidOccluders solids;
  culling::DepthPyramid pyramid;
  solids.begin(snapshot, kFront, kWidth, kHeight);
  solids.add(all_of(snapshot));
  solids.build(pyramid);
  const culling::OcclusionTest test(kFront, dvec3(0.0), kWidth, kHeight, pyramid);
  EXPECT_TRUE(test.occluded({{-1.5f, 1, -1}, {1.5f, 2, 1}}));
  EXPECT_FALSE(test.occluded({{-1.5f, -1, -1}, {1.5f, 2, 1}}));
  EXPECT_FALSE(test.occluded({{-1.5f, 1, -1}, {5.0f, 2, 1}}));
  solids.begin(snapshot, kFront, kWidth, kHeight);
  solids.build(pyramid);
  EXPECT_FALSE(test.occluded({{-1.5f, 1, -1}, {1.5f, 2, 1}})) << "begun anew";
}

}  // namespace
}  // namespace sightline::tests::solid_occluders_test
