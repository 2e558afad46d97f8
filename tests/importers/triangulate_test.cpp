#include "sightline/importers/internal/triangulate.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace sightline::importers::triangulate_test {
namespace {

using core::dvec3;
using core::vec3;

/// Sum of the triangles' areas, each counted positive when it runs counter-clockwise about `normal`.
struct Areas {
  double positive = 0.0, negative = 0.0;
};

Areas areas(const std::vector<vec3>& p, const std::vector<std::uint32_t>& indices, const dvec3& normal) {
  Areas out;
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    const dvec3 a(p[indices[i]]), b(p[indices[i + 1]]), c(p[indices[i + 2]]);
    const double area = 0.5 * glm::dot(glm::cross(b - a, c - a), normal);
    (area >= 0 ? out.positive : out.negative) += area;
  }
  return out;
}

double polygon_area(const std::vector<vec3>& p, std::size_t first, std::size_t count, const dvec3& normal) {
  return 0.5 * glm::dot(newell_normal(std::span(p).subspan(first, count)), normal);
}

struct Case {
  std::vector<vec3> vertices;
  std::vector<std::uint32_t> contours;
  dvec3 normal{0, 0, 1};
  double area = 0.0;

  /// A star-shaped ring around (x, y) in a plane turned by `turn`.
  void ring(std::mt19937& random, int count, double x, double y, double small, double large, const glm::dmat3& turn,
            bool reverse) {
    std::uniform_real_distribution<double> radius(small, large);
    const std::size_t first = vertices.size();
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * (reverse ? count - i : i) / count, r = radius(random);
      vertices.emplace_back(turn * dvec3(x + r * std::cos(angle), y + r * std::sin(angle), 3.0));
    }
    contours.push_back(std::uint32_t(count));
    normal = turn[2];
    area += (first == 0 ? 1 : -1) * std::abs(polygon_area(vertices, first, std::size_t(count), normal));
  }
};

glm::dmat3 random_turn(std::mt19937& random) {
  std::normal_distribution<double> gauss;
  const dvec3 a = glm::normalize(dvec3(gauss(random), gauss(random), gauss(random)));
  const dvec3 b = glm::normalize(glm::cross(a, dvec3(gauss(random), gauss(random), gauss(random))));
  return {b, glm::cross(a, b), a};
}

TEST(Triangulate, CoversStarsWithHolesExactlyOnce) {
  for (unsigned seed = 0; seed < 3000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const glm::dmat3 turn = seed % 3 == 0 ? glm::dmat3(1.0) : random_turn(random);
    Case c;
    c.ring(random, 3 + int(random() % 60), 0, 0, 5.0, 12.0, turn, false);
    if (random() % 2) {
      // Holes on a grid within the disc of radius 2.4, which even the coarsest outline contains.
      const int holes = int(random() % 9);
      for (int h = 0; h < holes; ++h)
        c.ring(random, 3 + int(random() % 9), (h % 3 - 1) * 1.2, (h / 3 - 1) * 1.2, 0.1, 0.5, turn, random() % 2);
    }
    std::vector<std::uint32_t> indices;
    triangulate_polygon(c.vertices, c.contours, 0, indices);
    const Areas got = areas(c.vertices, indices, c.normal);
    ASSERT_NEAR(got.positive, c.area, 1e-4 * c.area);
    ASSERT_NEAR(got.negative, 0.0, 1e-4 * c.area);
    ASSERT_EQ(indices.size() / 3, c.vertices.size() + 2 * (c.contours.size() - 1) - 2);
  }
}

TEST(Triangulate, KeepsTheDirectionOfTheOutline) {
  std::mt19937 random(7);
  for (const bool reverse : {false, true}) {
    Case c;
    c.ring(random, 20, 0, 0, 3, 9, glm::dmat3(1.0), reverse);
    std::vector<std::uint32_t> indices;
    triangulate_polygon(c.vertices, c.contours, 0, indices);
    const Areas got = areas(c.vertices, indices, dvec3(0, 0, reverse ? -1 : 1));
    EXPECT_NEAR(got.positive, c.area, 1e-4 * c.area);
    EXPECT_NEAR(got.negative, 0.0, 1e-9);
  }
}

TEST(Triangulate, AxisAlignedPlatesWithManyAlignedHoles) {
  // The usual perforated plate: all edges parallel, hole corners at equal heights, collinear vertices everywhere.
  std::vector<vec3> p = {{0, 0, 0}, {5, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}};
  std::vector<std::uint32_t> contours = {5};
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) {
      const float u = float(1 + 2 * x), v = float(1 + 2 * y);
      p.insert(p.end(), {{u, v, 0}, {u, v + 1, 0}, {u + 1, v + 1, 0}, {u + 1, v, 0}});
      contours.push_back(4);
    }
  std::vector<std::uint32_t> indices;
  triangulate_polygon(p, contours, 0, indices);
  const Areas got = areas(p, indices, {0, 0, 1});
  EXPECT_NEAR(got.positive, 84.0, 1e-9);
  EXPECT_NEAR(got.negative, 0.0, 1e-9);
}

TEST(Triangulate, FurtherOutlinesAreNotHoles) {
  const std::vector<vec3> p = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}};
  std::vector<std::uint32_t> indices;
  triangulate_polygon(p, std::vector<std::uint32_t>{4, 3}, 100, indices);
  ASSERT_EQ(indices.size(), 9u);
  for (std::uint32_t& i : indices) {
    ASSERT_GE(i, 100u);
    i -= 100;
  }
  EXPECT_NEAR(areas(p, indices, {0, 0, 1}).positive, 1.5, 1e-12);
}

TEST(Triangulate, ConcaveQuads) {
  for (std::size_t shift = 0; shift < 4; ++shift) {
    const vec3 dart[4] = {{0, 0, 0}, {4, 0, 0}, {1, 1, 0}, {0, 4, 0}};
    std::vector<vec3> p;
    for (std::size_t i = 0; i < 4; ++i) p.push_back(dart[(i + shift) % 4]);
    std::vector<std::uint32_t> indices;
    triangulate_polygon(p, std::vector<std::uint32_t>{4}, 0, indices);
    EXPECT_NEAR(areas(p, indices, {0, 0, 1}).positive, 4.0, 1e-12);
    EXPECT_NEAR(areas(p, indices, {0, 0, 1}).negative, 0.0, 1e-12);
  }
}

TEST(Triangulate, HalvesThatCancelOut) {
  for (unsigned seed = 0; seed < 1000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const glm::dmat3 turn = random_turn(random);
    std::vector<vec3> p;
    for (const dvec3& corner : {dvec3(0, 0, 0), dvec3(4, 0, 0), dvec3(0, 3, 0), dvec3(4, 3, 0)})
      p.emplace_back(turn * (corner + dvec3(seed % 7, 0, 0)));
    std::rotate(p.begin(), p.begin() + seed % 4, p.end());
    if (seed % 3 == 0) p.insert(p.begin() + 1, 0.5f * (p[0] + p[1]));  // five corners
    std::vector<std::uint32_t> indices;
    triangulate_polygon(p, std::vector<std::uint32_t>{std::uint32_t(p.size())}, 0, indices);
    double area = 0.0;
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3)
      area += 0.5 * glm::length(newell_normal(std::vector<vec3>{p[indices[i]], p[indices[i + 1]], p[indices[i + 2]]}));
    EXPECT_NEAR(area, 12.0, 1e-4);
    // There and back, or a line: nothing is enclosed.
    for (const std::vector<vec3>& nothing : {std::vector{p[0], p[1], p[2], p[1]}, {p[0], p[1], p[0], p[1]}}) {
      indices.clear();
      triangulate_polygon(nothing, std::vector<std::uint32_t>{4}, 0, indices);
      EXPECT_TRUE(indices.empty());
    }
  }
}

TEST(Triangulate, DegenerateInputGivesValidIndices) {
  for (unsigned seed = 0; seed < 4000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::vector<vec3> p;
    std::vector<std::uint32_t> contours;
    const int kinds = int(random() % 4), rings = 1 + int(random() % 5);
    for (int r = 0; r < rings; ++r) {
      contours.push_back(std::uint32_t(random() % 12));
      for (std::uint32_t i = 0; i < contours.back(); ++i) {
        const float a = float(random() % 3), b = float(random() % 3), c = float(random() % 3);
        if (kinds == 0) p.emplace_back(a, b, 0.0f);
        if (kinds == 1) p.emplace_back(a, a, a);
        if (kinds == 2) p.emplace_back(a * 1e30f, b * 1e-30f, c);
        if (kinds == 3) p.emplace_back(1e36f * a, -1e36f * b, 1e36f);
      }
    }
    std::vector<std::uint32_t> indices;
    triangulate_polygon(p, contours, 0, indices);
    ASSERT_EQ(indices.size() % 3, 0u);
    ASSERT_LE(indices.size() / 3, p.size() + 2 * contours.size());
    for (const std::uint32_t i : indices) ASSERT_LT(i, p.size());
  }
}

TEST(Triangulate, EndsOnHugePolygons) {
  std::mt19937 random(3);
  Case star;
  star.ring(random, 100000, 0, 0, 1, 100, glm::dmat3(1.0), false);
  std::vector<vec3> noise;
  for (int i = 0; i < 100000; ++i) noise.emplace_back(float(random() % 1000), float(random() % 1000), 0.0f);
  std::vector<std::uint32_t> holes(33333, 3), indices;
  for (const auto& [p, contours] : {std::pair{&star.vertices, star.contours}, {&noise, {100000}}, {&noise, holes}}) {
    indices.clear();
    triangulate_polygon(*p, contours, 0, indices);
    for (const std::uint32_t i : indices) ASSERT_LT(i, p->size());
  }
}

}  // namespace
}  // namespace sightline::importers::triangulate_test
