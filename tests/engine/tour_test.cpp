// The tour of a model, whatever its bounds and items are.
#include "sightline/engine/tour.h"

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/item_bounds.h"

namespace sightline::tests::tour_test {
namespace {

using core::AabbD;
using core::CameraKey;
using core::CameraPath;
using core::CameraSample;
using core::dvec3;
using core::is_finite;
using core::ItemBounds;
using core::vec3;
using engine::make_tour;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

void expect_flyable(const CameraPath& path, double least_distance) {
  ASSERT_GT(path.keys().size(), 10u);
  EXPECT_GT(path.near, 0.0);
  EXPECT_EQ(path.far, core::kInfiniteFar);
  for (int i = 0; i <= 1000; ++i) {
    const CameraSample s = path.sample(path.begin() + (path.end() - path.begin()) * i / 1000.0);
    ASSERT_TRUE(is_finite(s.pose.eye) && is_finite(s.pose.target) && is_finite(s.pose.up)) << "sample " << i;
    ASSERT_GT(glm::length(s.pose.target - s.pose.eye), least_distance) << "sample " << i;
    ASSERT_NEAR(glm::length(s.pose.up), 1.0, 1e-9);
    ASSERT_NEAR(s.fovy, path.keys().front().fovy, 1e-9);
    ASSERT_TRUE(core::View::perspective(s.pose, s.fovy, 1.5, path.near, path.far).has_value()) << "sample " << i;
  }
}

TEST(MakeTour, FliesThroughRandomBoxes) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0), exponent(-3.0, 6.0);
    AabbD box;
    const double far = seed % 3 == 0 ? 1e7 : 10.0, scale = std::pow(10.0, exponent(rng));
    const dvec3 centre = (dvec3(unit(rng), unit(rng), unit(rng)) - 0.5) * far;
    const dvec3 half = dvec3(unit(rng), unit(rng), unit(rng)) * scale;
    box.grow(centre - half);
    box.grow(centre + half);
    if (seed % 5 == 0) box.max[int(seed / 5 % 3)] = box.min[int(seed / 5 % 3)];
    std::vector<dvec3> places;
    for (unsigned i = 0; i < seed % 50; ++i)
      places.push_back(box.min + dvec3(unit(rng), unit(rng), unit(rng)) * box.size());
    const CameraPath path = make_tour(box, places, 10.0 + seed);
    EXPECT_NEAR(path.end() - path.begin(), 10.0 + seed, 1e-9);
    expect_flyable(path, 1e-3 * glm::length(half));
  }
}

TEST(MakeTour, WorksForDegenerateBounds) {
  const double e37 = 1e37;
  const AabbD boxes[] = {{},
                         {dvec3(0), dvec3(0)},
                         {dvec3(1e7), dvec3(1e7)},
                         {dvec3(-e37), dvec3(e37)},
                         {dvec3(-1e300), dvec3(1e300)},
                         {dvec3(e37), dvec3(e37)},
                         {dvec3(0), dvec3(1e-300)},
                         {dvec3(1e7), dvec3(1e7 + 1e-8)},
                         {dvec3(0), dvec3(0, 0, 5)},
                         {dvec3(0), dvec3(7, 3, 0)},
                         {dvec3(-kInf), dvec3(kInf)},
                         {dvec3(kNaN), dvec3(kNaN)}};
  int index = 0;
  for (const AabbD& box : boxes) {
    SCOPED_TRACE("box " + std::to_string(index++));
    expect_flyable(make_tour(box, {}), 0.0);
    expect_flyable(make_tour(box, {dvec3(kNaN), dvec3(1, 2, 3), dvec3(kInf)}), 0.0);
  }
}

TEST(MakeTour, BadDurationFallsBackToAMinute) {
  for (const double duration : {0.0, -1.0, kNaN, kInf}) EXPECT_NEAR(make_tour(AabbD(), {}, duration).end(), 60.0, 1e-9);
}

TEST(MakeTour, IsDeterministicAndVisitsDensePlaces) {
  AabbD box;
  box.grow(dvec3(0));
  box.grow(dvec3(400, 100, 60));
  std::vector<dvec3> places(1000, dvec3(333, 22, 11));
  places.insert(places.end(), 10, dvec3(50, 80, 40));
  const CameraPath a = make_tour(box, places), b = make_tour(box, places);
  ASSERT_EQ(a.keys().size(), b.keys().size());
  bool visits_dense = false, visits_sparse = false;
  for (std::size_t i = 0; i < a.keys().size(); ++i) {
    EXPECT_EQ(a.keys()[i].pose.eye, b.keys()[i].pose.eye);
    visits_dense = visits_dense || glm::length(a.keys()[i].pose.target - dvec3(333, 22, 11)) < 1e-6;
    visits_sparse = visits_sparse || glm::length(a.keys()[i].pose.target - dvec3(50, 80, 40)) < 1e-6;
  }
  EXPECT_TRUE(visits_dense);
  EXPECT_TRUE(visits_sparse);
  bool walks = false;
  for (const CameraKey& key : a.keys()) walks = walks || std::fabs(key.pose.eye.z - 1.7) < 1e-9;
  EXPECT_TRUE(walks) << "nobody walks at eye height";
}

TEST(MakeTour, NearFollowsTheSize) {
  const auto near_of = [](double size) { return make_tour({dvec3(0), dvec3(size, 0, 0)}, {}).near; };
  EXPECT_NEAR(near_of(1000.0), 0.1, 1e-9);
  EXPECT_NEAR(near_of(10.0), 0.01, 1e-9);
  EXPECT_NEAR(near_of(1e7), 10.0, 1e-9);
  EXPECT_NEAR(near_of(0.1), 0.001, 1e-9) << "a small model must not be cut away";
}

TEST(MakeTour, OfItemsStaysWithThemWhateverLiesFarOff) {
  ItemBounds items;
  items.origin = dvec3(1e6, 0.0, 0.0);
  items.resize(5000);
  for (std::size_t i = 0; i < 4990; ++i) {
    const vec3 p(float(i % 100), float(i / 100), 0.0f);
    items.set(i, {p, p + 1.0f});
  }
  const CameraPath near = make_tour(items, items.fitted_bounds(), 30.0);
  EXPECT_NEAR(near.end(), 30.0, 1e-9);
  std::vector<dvec3> places;
  for (std::size_t i = 0; i < 4990; ++i)
    places.push_back(items.origin + 0.5 * (dvec3(items.box(i).min) + dvec3(items.box(i).max)));
  const CameraPath twin = make_tour(items.world_bounds(), places, 30.0);
  ASSERT_EQ(near.keys().size(), twin.keys().size());
  for (std::size_t i = 0; i < twin.keys().size(); ++i) {
    EXPECT_EQ(near.keys()[i].pose.eye, twin.keys()[i].pose.eye);
    EXPECT_EQ(near.keys()[i].pose.target, twin.keys()[i].pose.target);
  }

  items.set(4999, {vec3(1e6f), vec3(1e6f)});
  const CameraPath far = make_tour(items, items.fitted_bounds(), 30.0);
  for (const CameraKey& key : far.keys()) EXPECT_LT(glm::length(key.pose.eye - items.origin), 1000.0);
  EXPECT_TRUE(make_tour(ItemBounds(), ItemBounds().fitted_bounds()).keys().size() > 10u);
}

}  // namespace
}  // namespace sightline::tests::tour_test
