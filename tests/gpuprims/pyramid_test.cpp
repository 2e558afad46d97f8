#include <gtest/gtest.h>

#include "intersection_twin.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims::pyramid_test {
namespace {

using core::dvec2;
using twin::LVec;

struct Solid {
  core::Pyramid shape;

  // Straight from the definition in core/primitive.h.
  bool inside(const LVec& p) const {
    const long double part = p.z / shape.height;
    if (std::fabs(part) > 0.5L) return false;
    const long double bottom = 0.5L - part, top = 0.5L + part;
    return std::fabs(p.x - part * shape.offset_x) <= 0.5L * (bottom * shape.bottom_x + top * shape.top_x) &&
           std::fabs(p.y - part * shape.offset_y) <= 0.5L * (bottom * shape.bottom_y + top * shape.top_y);
  }
  long double lateral(const LVec&) const { return 0.0L; }
  std::vector<dvec3> cap_normals() const {
    const double h = shape.height;
    const dvec2 lean = dvec2(shape.offset_x, shape.offset_y) / h;
    const dvec2 narrowing = 0.5 * dvec2(shape.bottom_x - shape.top_x, shape.bottom_y - shape.top_y) / h;
    return {{0, 0, -1},
            {0, 0, 1},
            {-1, 0, lean.x + narrowing.x},
            {1, 0, -lean.x + narrowing.x},
            {0, -1, lean.y + narrowing.y},
            {0, 1, -lean.y + narrowing.y}};
  }
  dvec3 half() const {
    const core::AabbD box = core::bounds(shape, {});
    return glm::max(glm::abs(box.min), glm::abs(box.max));
  }
  double size() const { return glm::length(half()); }
  double feature() const { return shape.height; }
};

core::Pyramid random_pyramid(twin::Random& random) {
  const double scale = random.log_uniform(-6, 6);
  const auto length = [&](double low, double high) { return float(scale * random.log_uniform(low, high)); };
  core::Pyramid p{};
  p.bottom_x = length(-1, 1);
  p.bottom_y = length(-1, 1);
  p.top_x = length(-1, 1);
  p.top_y = length(-1, 1);
  p.height = length(-2, 2);
  switch (random.below(6)) {
    case 0:
      p.top_x = p.top_y = 0.0f;
      break;  // a point
    case 1:
      p.top_x = 0.0f;
      break;  // a ridge
    case 2:
      p.bottom_x = p.top_y = 0.0f;
      break;  // two edges across each other
    case 3:
      p.top_x = p.bottom_x, p.top_y = std::nextafterf(p.bottom_y, 0.0f);
      break;
    default:
      break;
  }
  if (random.below(2)) {
    p.offset_x = float(scale * random.uniform(-2, 2));
    p.offset_y = float(scale * random.uniform(-2, 2));
  }
  return p;
}

TEST(Pyramid, AgreesWithTheMarchingTwin) {
  twin::run(6000, 0.125, [](twin::Random& random) { return Solid{random_pyramid(random)}; });
}

TEST(Pyramid, HeightZeroIsTheHullOfBothEndsWithTwoSides) {
  const core::Pyramid flat{2.0f, 2.0f, 1.0f, 1.0f, 6.0f, 0.0f, 0.0f};  // ends about x = -3 and x = 3
  for (const double x : {-3.5, 0.0, 3.25}) {
    const Hits hits = intersect(flat, {{x, 0.3, 5.0}, {0.0, 0.0, -2.0}});
    ASSERT_EQ(hits.count, 2) << x;
    EXPECT_EQ(hits.hit[0].t, 2.5);
    EXPECT_EQ(hits.hit[0].normal.z, 1.0);
    EXPECT_EQ(hits.hit[1].t, 2.5);
    EXPECT_EQ(hits.hit[1].normal.z, -1.0);
  }
  EXPECT_EQ(intersect(flat, {{0.0, 0.85, 5.0}, {0.0, 0.0, -1.0}}).count, 0) << "beside the hull, within its box";
  EXPECT_EQ(intersect(flat, {{3.6, 0.0, 5.0}, {0.0, 0.0, -1.0}}).count, 0);
  EXPECT_EQ(intersect(flat, {{-9.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}).count, 0) << "edge on";
}

TEST(Pyramid, WithoutWidthItHasTwoSides) {
  const core::Pyramid sheet{0.0f, 2.0f, 0.0f, 2.0f, 1.0f, 0.0f, 2.0f};  // leans: x = z / 2
  const Hits hits = intersect(sheet, {{-4.0, 0.5, 0.5}, {2.0, 0.0, 0.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_EQ(hits.hit[0].t, 2.125);
  EXPECT_EQ(hits.hit[1].t, 2.125);
  EXPECT_LT(hits.hit[0].normal.x, 0.0);
  EXPECT_GT(hits.hit[1].normal.x, 0.0);
  EXPECT_EQ(intersect(sheet, {{0.25, -5.0, 0.5}, {0.0, 1.0, 0.0}}).count, 0) << "edge on";
  EXPECT_EQ(intersect(core::Pyramid{0, 0, 0, 0, 0, 0, 2.0f}, {{-4.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}).count, 0);
}

TEST(Pyramid, ThroughTheApex) {
  const core::Pyramid p{2.0f, 2.0f, 0.0f, 0.0f, 0.0f, 0.0f, 2.0f};
  const Hits hits = intersect(p, {{0.0, 0.0, 5.0}, {0.0, 0.0, -1.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_EQ(hits.hit[0].t, 4.0);
  EXPECT_EQ(hits.hit[1].t, 6.0);
}

TEST(Pyramid, OpenEndsDropTheirCrossingOnly) {
  const core::Pyramid p{2.0f, 2.0f, 1.0f, 1.0f, 0.0f, 0.0f, 2.0f};
  const Ray along{{0.1, 0.2, 3.0}, {0.0, 0.0, -1.0}};
  EXPECT_EQ(intersect(p, along).count, 2);
  EXPECT_EQ(intersect(p, along, {false, false}).count, 0);
  const Hits bottom = intersect(p, along, {true, false});
  ASSERT_EQ(bottom.count, 1);
  EXPECT_EQ(bottom.hit[0].t, 4.0);
  EXPECT_EQ(intersect(p, {{-5.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}, {false, false}).count, 2);
}

}  // namespace
}  // namespace sightline::gpuprims::pyramid_test
