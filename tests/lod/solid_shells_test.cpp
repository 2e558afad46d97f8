// Which shells of a mesh count as solid.
#include "sightline/lod/internal/solid_shells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::solid_shells_test {
namespace {

using core::vec3;
using gpuprims::tessellate;
constexpr float kPi = std::numbers::pi_v<float>;

/// Several meshes in one, moved.
struct Soup {
  std::vector<vec3> positions;
  std::vector<std::uint32_t> indices;

  Soup& add(const core::Mesh& mesh, const vec3& offset = vec3(0.0f)) {
    const auto first = std::uint32_t(positions.size());
    for (const vec3& p : mesh.positions) positions.push_back(p + offset);
    for (const std::uint32_t i : mesh.indices) indices.push_back(first + i);
    return *this;
  }
  std::size_t solid() { return lod::solid_shells_first(positions, indices); }
};

core::Mesh box() {
  return tessellate(core::Primitive(core::Box{1.0f, 2.0f, 3.0f}));
}
core::Mesh ball() {
  return tessellate(core::Primitive(core::Sphere{2.0f}));
}
core::Mesh bend(float angle) {
  return tessellate(core::Primitive(core::CircularTorus{3.0f, 1.0f, angle}));
}
core::Mesh inside_out(core::Mesh mesh) {
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) std::swap(mesh.indices[i], mesh.indices[i + 1]);
  return mesh;
}
core::Mesh open(core::Mesh mesh) {
  mesh.indices.resize(mesh.indices.size() - 3);
  return mesh;
}
std::vector<std::array<std::uint32_t, 3>> triangles(const std::vector<std::uint32_t>& indices, std::size_t from = 0) {
  std::vector<std::array<std::uint32_t, 3>> list;
  for (std::size_t i = from; i < indices.size(); i += 3) list.push_back({indices[i], indices[i + 1], indices[i + 2]});
  return list;
}

TEST(SolidShells, AreClosedAndStarShaped) {
  const core::Primitive solids[] = {core::Box{1.0f, 2.0f, 3.0f},
                                    core::Cylinder{0.01f, 500.0f},
                                    core::Sphere{2.0f},
                                    core::Pyramid{1.0f, 1.0f, 2.0f, 2.0f, 0.3f, 0.1f, 1.0f},
                                    core::Snout{1.0f, 0.5f, 2.0f, 0.2f, 0.1f, 0.0f, 0.0f, 0.0f, 0.0f},
                                    core::EllipticalDish{1.0f, 0.3f},
                                    core::CircularTorus{3.0f, 1.0f, 0.5f * kPi}};
  for (const core::Primitive& solid : solids) {
    Soup soup;
    soup.add(tessellate(solid), {1000.0f, -200.0f, 30.0f});
    EXPECT_GT(soup.indices.size(), 0u);
    EXPECT_EQ(soup.solid(), soup.indices.size()) << "primitive " << solid.index();
  }
}

TEST(SolidShells, NeitherOpenNorInsideOutNorBent) {
  EXPECT_EQ(Soup().add(open(box())).solid(), 0u);
  EXPECT_EQ(Soup().add(open(ball())).solid(), 0u);
  EXPECT_EQ(Soup().add(inside_out(ball())).solid(), 0u);
  EXPECT_EQ(Soup().add(bend(1.5f * kPi)).solid(), 0u);
  EXPECT_EQ(Soup().add(bend(2.0f * kPi)).solid(), 0u);
  EXPECT_EQ(Soup().solid(), 0u);
}

/// What is flat is relative to a shell's size.
TEST(SolidShells, AreThoseOfAnySize) {
  for (const float scale : {1e-9f, 1e-6f, 1e-3f, 1e3f, 1e6f, 1e9f}) {
    SCOPED_TRACE(scale);
    Soup both;
    both.add(ball()).add(bend(1.5f * kPi), {9, 0, 0});
    for (vec3& p : both.positions) p *= scale;
    EXPECT_EQ(both.solid(), ball().indices.size());
  }
}

/// Two triangles, back to back, and a closed box one of whose triangles is turned.
TEST(SolidShells, EdgesMustRunBothWays) {
  Soup sheet;
  sheet.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  sheet.indices = {0, 1, 2, 0, 2, 1};
  EXPECT_EQ(sheet.solid(), 6u) << "closed, and of no volume";
  core::Mesh turned = box();
  std::swap(turned.indices[0], turned.indices[1]);
  EXPECT_EQ(Soup().add(turned).solid(), 0u);
}

/// Neither the first edges of a tetrahedron's triangles nor their last ones alone connect its corners.
TEST(SolidShells, HangTogetherByEveryEdge) {
  Soup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  soup.indices = {1, 0, 2, 0, 1, 3, 3, 2, 0, 2, 3, 1};
  EXPECT_EQ(soup.solid(), 12u);
}

/// Vertices doubled for their normals, at 0 and at -0.
TEST(SolidShells, HangTogetherByPositions) {
  core::Mesh corner = tessellate(core::Primitive(core::Box{2.0f, 2.0f, 2.0f}));
  for (vec3& p : corner.positions) p += vec3(1.0f);  // one corner at the origin
  bool flipped = false;
  for (vec3& p : corner.positions)
    if (p == vec3(0.0f) && (flipped = !flipped)) p = vec3(-0.0f);
  ASSERT_TRUE(flipped || corner.positions.size() > 8);
  Soup soup;
  soup.positions = corner.positions;
  soup.indices = corner.indices;
  EXPECT_EQ(soup.solid(), soup.indices.size());
}

TEST(SolidShells, ComeFirstAndNothingIsLost) {
  Soup soup;
  soup.add(open(box())).add(ball(), {10, 0, 0}).add(bend(2.0f * kPi), {20, 0, 0}).add(box(), {30, 0, 0});
  const auto before = triangles(soup.indices);
  const std::size_t solid = soup.solid();
  EXPECT_EQ(solid, ball().indices.size() + box().indices.size());
  for (std::size_t i = 0; i < soup.indices.size(); ++i) {
    const float x = soup.positions[soup.indices[i]].x;
    EXPECT_EQ(i < solid, (x > 8.0f && x < 12.0f) || x > 28.0f) << i;
  }
  auto after = triangles(soup.indices), sorted = before;
  std::sort(after.begin(), after.end());
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(after, sorted);
  // In their order.
  const auto others = triangles(soup.indices, solid);
  auto at = before.begin();
  for (const auto& triangle : others) {
    at = std::find(at, before.end(), triangle);
    ASSERT_NE(at, before.end());
  }
}

/// An octahedron of which each edge is halved, with corners at random distances from a point inside: 32 triangles.
Soup any_star(std::mt19937& random, double roughness) {
  const auto in = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  Soup soup;
  std::map<std::array<float, 3>, std::uint32_t> number;
  const auto corner = [&](const vec3& at) {
    const auto [place, fresh] = number.try_emplace({at.x, at.y, at.z}, std::uint32_t(soup.positions.size()));
    if (fresh) soup.positions.push_back(at);
    return place->second;
  };
  for (int octant = 0; octant < 8; ++octant) {
    const vec3 x(octant & 1 ? -1 : 1, 0, 0), y(0, octant & 2 ? -1 : 1, 0), z(0, 0, octant & 4 ? -1 : 1);
    const bool odd = bool(octant & 1) != (bool(octant & 2) != bool(octant & 4));
    const vec3 a = odd ? y : x, b = odd ? x : y, ab = 0.5f * (a + b), bz = 0.5f * (b + z), za = 0.5f * (z + a);
    for (const vec3& at : {a, ab, za, ab, b, bz, za, bz, z, ab, bz, za}) soup.indices.push_back(corner(at));
  }
  const vec3 shift(in(-9, 9), in(-9, 9), in(-9, 9));
  for (vec3& p : soup.positions) p = p * float(std::exp(in(-roughness, roughness))) + shift;
  return soup;
}

/// How far inside of all planes of triangles a point can lie, of the points where three planes meet; below 0: outside.
double most_inside(const Soup& soup) {
  std::vector<core::dvec4> planes;
  for (std::size_t i = 0; i < soup.indices.size(); i += 3) {
    const auto at = [&](std::size_t k) { return core::dvec3(soup.positions[soup.indices[i + k]]); };
    const core::dvec3 normal = glm::normalize(glm::cross(at(1) - at(0), at(2) - at(0)));
    planes.emplace_back(normal, -glm::dot(normal, at(0)));
  }
  double best = -1e9;
  for (std::size_t i = 0; i < planes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      for (std::size_t k = 0; k < j; ++k) {
        const core::dmat3 rows =
            glm::transpose(core::dmat3(core::dvec3(planes[i]), core::dvec3(planes[j]), core::dvec3(planes[k])));
        if (std::abs(glm::determinant(rows)) < 1e-9) continue;
        const core::dvec3 p = glm::inverse(rows) * -core::dvec3(planes[i].w, planes[j].w, planes[k].w);
        double least = 0.0;
        for (std::size_t m = 0; m < planes.size() && least > best; ++m)
          if (m != i && m != j && m != k) least = std::min(least, -glm::dot(planes[m], core::dvec4(p, 1.0)));
        best = std::max(best, least);
      }
  return best;
}

/// A twin that finds a point inside of all planes by trying all that three of them have in common.
TEST(SolidShells, AreStarShapedByATwinToo) {
  int found = 0, missed = 0, others = 0;
  for (std::uint32_t seed = 1; seed <= 600; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Soup soup = any_star(random, 0.4 * double(1 + seed % 4));
    for (vec3& p : soup.positions)
      if (seed % 3 == 0 && random() % 9 == 0) p.x += 1.0f;
    const bool star = most_inside(soup) > -1e-6;
    const bool solid = soup.solid() > 0;
    ASSERT_TRUE(star || !solid);
    ++(solid ? found : star ? missed : others);
  }
  EXPECT_GT(others, 50);
  EXPECT_LE(missed, found / 200) << "a centre is found in nearly all that have one";
}

/// The hollow of a box within a box is inside out; a mesh may have both.
TEST(SolidShells, AHollowIsNoneOfThem) {
  core::Mesh inner = inside_out(box());
  for (vec3& p : inner.positions) p *= 0.5f;
  Soup soup;
  soup.add(inner).add(box());
  EXPECT_EQ(soup.solid(), box().indices.size());
}

}  // namespace
}  // namespace sightline::solid_shells_test
