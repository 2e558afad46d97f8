// Which shells of a mesh count as solid.
#include "sightline/lod/internal/solid_shells.h"

#include <algorithm>
#include <numbers>

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
