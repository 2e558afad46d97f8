#include <gtest/gtest.h>

#include "intersection_twin.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims::box_test {
namespace {

using twin::LVec;

struct Solid {
  core::Box shape;
  bool inside(const LVec& p) const {
    const LVec h(half());
    return std::fabs(p.x) <= h.x && std::fabs(p.y) <= h.y && std::fabs(p.z) <= h.z;
  }
  long double lateral(const LVec&) const { return 0.0L; }
  std::vector<dvec3> cap_normals() const {
    return {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
  }
  dvec3 half() const { return 0.5 * dvec3(shape.size_x, shape.size_y, shape.size_z); }
  double size() const { return glm::length(half()); }
  double feature() const { return std::min({shape.size_x, shape.size_y, shape.size_z}); }
};

TEST(Box, AgreesWithTheMarchingTwin) {
  twin::run(6000, 0.25, [](twin::Random& random) {
    const double scale = random.log_uniform(-6, 6);
    const auto length = [&] { return float(scale * random.log_uniform(-2, 2)); };
    const float x = length(), y = length();
    return Solid{{x, y, length()}};
  });
}

void expect_two_sides(const core::Box& flat, int axis) {
  SCOPED_TRACE(testing::Message() << "axis " << axis);
  dvec3 origin(0.25), direction(0.0);
  origin[axis] = 5.0;
  direction[axis] = -2.0;
  const Hits hits = intersect(flat, {origin, direction});
  ASSERT_EQ(hits.count, 2);
  EXPECT_EQ(hits.hit[0].t, 2.5);
  EXPECT_EQ(hits.hit[0].normal[axis], 1.0);
  EXPECT_EQ(hits.hit[1].t, 2.5);
  EXPECT_EQ(hits.hit[1].normal[axis], -1.0);
  origin[axis] = 0.0;
  std::swap(direction[axis], direction[(axis + 1) % 3]);
  EXPECT_EQ(intersect(flat, {origin, direction}).count, 0) << "edge on";
}

TEST(Box, SizeZeroAlongAnAxisHasTwoSides) {
  for (int axis = 0; axis < 3; ++axis) {
    float sizes[] = {1.0f, 1.0f, 1.0f};
    sizes[axis] = 0.0f;
    expect_two_sides({sizes[0], sizes[1], sizes[2]}, axis);
  }
}

TEST(Box, SizeZeroAlongTwoAxesIsNothing) {
  EXPECT_EQ(intersect(core::Box{0.0f, 0.0f, 2.0f}, {{-5.0, 0.0, 0.5}, {1.0, 0.0, 0.0}}).count, 0);
  EXPECT_EQ(intersect(core::Box{0.0f, 0.0f, 0.0f}, {{-5.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}).count, 0);
}

TEST(Box, AlongAnAxisAndThroughACorner) {
  const core::Box box{2.0f, 4.0f, 6.0f};
  const Hits along = intersect(box, {{0.5, -1.5, -10.0}, {0.0, 0.0, 2.0}});
  ASSERT_EQ(along.count, 2);
  EXPECT_EQ(along.hit[0].t, 3.5);
  EXPECT_EQ(along.hit[1].t, 6.5);
  EXPECT_EQ(intersect(box, {{1.5, -1.5, -10.0}, {0.0, 0.0, 2.0}}).count, 0) << "parallel, beside";
  const Hits corners = intersect(box, {{-2.0, -4.0, -6.0}, {1.0, 2.0, 3.0}});
  ASSERT_EQ(corners.count, 2);
  EXPECT_NEAR(corners.hit[0].t, 1.0, 1e-15);
  EXPECT_NEAR(corners.hit[1].t, 3.0, 1e-15);
}

}  // namespace
}  // namespace sightline::gpuprims::box_test
