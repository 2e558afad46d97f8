// Meshes and materials of a scene.
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/tests/core/primitive_samples.h"
#include "sightline/tests/core/scene_samples.h"

namespace sightline::core::scene_meshes_test {
namespace {

using tests::Ids;
using tests::kPipe;
using tests::Random;
using tests::triangle;
using tests::uniform;

TEST(SceneMeshes, RefusesMeshesWhoseCountsOrIndicesDoNotFit) {
  struct Case {
    const char* expected;
    void (*spoil)(Mesh&);
  };
  const Case cases[] = {
      {"indices below 3, the number of positions, found 3", [](Mesh& m) { m.indices[1] = 3; }},
      {"indices below 3, the number of positions, found 4294967295", [](Mesh& m) { m.indices[2] = kNone; }},
      {"indices below 0, the number of positions, found 2", [](Mesh& m) { m.positions.clear(); }},
      {"three indices for each triangle, found 2", [](Mesh& m) { m.indices.pop_back(); }},
      {"three indices for each triangle, found 4", [](Mesh& m) { m.indices.push_back(0); }},
      {"no normals or one for each of 3 positions, found 2", [](Mesh& m) { m.normals.resize(2); }},
      {"no normals or one for each of 3 positions, found 4", [](Mesh& m) { m.normals.resize(4); }},
      {"polygons that hold all of 1 contours, found 0", [](Mesh& m) { m.contour_sizes = {3}; }},
      {"polygons that hold all of 1 contours, found 2",
       [](Mesh& m) {
         m.contour_sizes = {3}, m.polygon_contours = {1, 1};
       }},
      {"polygons that hold all of 0 contours, found 1", [](Mesh& m) { m.polygon_contours = {1}; }},
      {"contours that hold all of 3 positions, found 2",
       [](Mesh& m) { m.contour_sizes = {2}, m.polygon_contours = {1}; }},
      {"contours that hold all of 3 positions, found 0", [](Mesh& m) { m.polygon_contours = {0}; }},
      {"contours that hold all of 3 positions, found 4294967299",  // and not, rounded to 32 bits, 3
       [](Mesh& m) {
         m.contour_sizes = {kNone, 4}, m.polygon_contours = {2};
       }},
  };
  for (const auto& [expected, spoil] : cases) {
    Scene scene;
    Mesh mesh = triangle();
    mesh.name = "pump";
    spoil(mesh);
    const auto added = scene.add_mesh(mesh);
    ASSERT_FALSE(added) << expected;
    EXPECT_EQ(added.error().message, std::string("mesh \"pump\": expected ") + expected);
    EXPECT_EQ(scene.mesh_slots(), 0u);
  }
  Scene scene;
  Mesh polygons = triangle();
  polygons.contour_sizes = {1, 2};
  polygons.polygon_contours = {0, 2};
  polygons.normals.resize(3);
  EXPECT_TRUE(scene.add_mesh(polygons)) << "of odd polygons nothing is said";
}

/// Whatever is taken may be asked about.
TEST(SceneMeshes, MeshesThatAreTakenAreSafe) {
  Random random(5);
  int taken = 0, refused = 0;
  for (int round = 0; round < 20'000; ++round) {
    Mesh mesh;
    mesh.positions.resize(random() % 6);
    for (vec3& p : mesh.positions) p = {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
    mesh.indices.resize(random() % 3 * 3 + (random() % 8 == 0));
    for (std::uint32_t& index : mesh.indices) index = std::uint32_t(random() % 6);
    bool fits = mesh.indices.size() % 3 == 0;
    for (const std::uint32_t index : mesh.indices) fits = fits && index < mesh.positions.size();
    Scene scene;
    const auto added = scene.add_mesh(mesh);
    ASSERT_EQ(bool(added), fits) << "round " << round;
    fits ? ++taken : ++refused;
    if (added) (void)enclosure(scene.mesh(*added));
  }
  EXPECT_GT(taken, 1000);
  EXPECT_GT(refused, 1000);
}

TEST(SceneMeshes, HandlesOfMeshesAndMaterialsStayStale) {
  Scene scene;
  const MeshId kept = scene.add_mesh(triangle()).value(), gone = scene.add_mesh(triangle()).value();
  const MaterialId paint = scene.add_material({}), scratched = scene.add_material({});
  scene.remove_mesh(gone);
  scene.remove_material(scratched);
  const Scene::Mark mark = scene.mark();
  const MeshId tried = scene.add_mesh(triangle()).value();
  const MaterialId tried_paint = scene.add_material({});
  scene.take_back(mark, {});
  const MeshId fresh = scene.add_mesh(triangle()).value();
  const MaterialId fresh_paint = scene.add_material({});
  ASSERT_EQ(fresh.index, tried.index) << "the place was to be given out again";
  ASSERT_EQ(fresh_paint.index, tried_paint.index);
  for (const MeshId id : {gone, tried, MeshId{}}) EXPECT_FALSE(scene.contains(id)) << id.index;
  for (const MeshId id : {kept, fresh}) {
    EXPECT_TRUE(scene.contains(id));
    EXPECT_EQ(scene.mesh_at(id.index), id);
  }
  for (const MaterialId id : {scratched, tried_paint, MaterialId{}}) EXPECT_FALSE(scene.contains(id)) << id.index;
  for (const MaterialId id : {paint, fresh_paint}) {
    EXPECT_TRUE(scene.contains(id));
    EXPECT_EQ(scene.material_at(id.index), id);
  }
  EXPECT_FALSE(scene.mesh_at(gone.index).valid());
  EXPECT_FALSE(scene.material_at(scratched.index).valid());
  EXPECT_FALSE(scene.material_at(kNone).valid());
  const ItemId item = scene.add_mesh_instance(scene.root(), fresh, {}, fresh_paint);
  EXPECT_EQ(scene.mesh_of(item), fresh);
  EXPECT_EQ(scene.item_material(item), fresh_paint);
  // What comes from another scene is as new as what is added here.
  Scene other;
  const MaterialId theirs = other.add_material({.name = "theirs"});
  other.remove_material(other.add_material({}));
  other.add_mesh_instance(other.add_node(other.root()), other.add_mesh(triangle()).value(), {}, theirs);
  scene.append(scene.root(), std::move(other));
  EXPECT_EQ(scene.material(scene.item_material(ItemId{to_index(item) + 1})).name, "theirs");
  EXPECT_TRUE(scene.contains(scene.mesh_of(ItemId{to_index(item) + 1})));
  EXPECT_FALSE(scene.material_at(scene.material_slots() - 1).valid());
}

TEST(SceneMeshes, WithoutTheirMaterialItemsInherit) {
  Scene scene;
  const MaterialId red = scene.add_material({}), blue = scene.add_material({});
  const NodeId above = scene.add_node(scene.root()), below = scene.add_node(above);
  scene.set_material(above, red);
  scene.set_material(below, blue);
  const ItemId plain = scene.add_primitive(below, kPipe), painted = scene.add_primitive(below, kPipe, {}, blue),
               other = scene.add_primitive(scene.root(), kPipe, {}, red);
  ASSERT_TRUE(scene.commit());
  scene.remove_material(blue);
  EXPECT_EQ(scene.state(plain).material, red.index);
  EXPECT_EQ(scene.state(painted).material, red.index);
  EXPECT_FALSE(scene.item_material(painted).valid());
  EXPECT_FALSE(scene.material(below).valid());
  const auto delta = scene.commit();
  EXPECT_EQ(delta->changed, (Ids{plain, painted}));
  EXPECT_EQ(delta->materials, std::vector{blue.index});
  scene.remove_material(red);
  EXPECT_EQ(scene.commit()->changed, (Ids{plain, painted, other}));
  for (const ItemId item : {plain, painted, other}) EXPECT_EQ(scene.state(item).material, kNone);
}

TEST(SceneMeshes, MeshBoundsFollowTheVerticesNotTheirBox) {
  Scene scene;
  Mesh needle;
  needle.positions = {{0, 0, 0}, {10, 10, 0}};
  const ItemId item = scene.add_mesh_instance(scene.root(), scene.add_mesh(needle).value());
  const double c = std::sqrt(0.5);
  const AabbD box = scene.bounds_under(item, {{{c, c, 0}, {-c, c, 0}, {0, 0, 1}}, dvec3(0.0)});
  EXPECT_NEAR(box.size().x, 0.0, 1e-6) << "turned upright";
  EXPECT_NEAR(box.max.y, 10.0 * std::sqrt(2.0), 1e-6);
  const ItemId nothing = scene.add_mesh_instance(scene.root(), scene.add_mesh({}).value());
  EXPECT_TRUE(scene.bounds_under(nothing, {}).empty());
  EXPECT_TRUE(scene.commit()) << "empty meshes may be committed";
}

/// Turned by right angles at most, the box of the vertices' box is that of the vertices, to the bit.
TEST(SceneMeshes, MeshBoundsAreThoseOfTheVertices) {
  Random random(7);
  for (int round = 0; round < 2000; ++round) {
    SCOPED_TRACE(testing::Message() << "seed 7, round " << round);
    Scene scene;
    Mesh mesh;
    for (int i = 0; i < 9; ++i)
      mesh.positions.emplace_back(uniform(random, -1, 1), uniform(random, -1e3, 1e3), uniform(random, 5, 6));
    const ItemId item = scene.add_mesh_instance(scene.root(), scene.add_mesh(mesh).value());
    Affine place = translation({uniform(random, -1e6, 1e6), uniform(random, -1, 1), 0.0});
    place.linear = dmat3(0.0);
    const int shift = int(random() % 3);
    for (int i = 0; i < 3; ++i)
      if (random() % 5 > 0) place.linear[i][(i + shift) % 3] = uniform(random, -2, 2);
    AabbD wanted;
    for (const vec3& p : mesh.positions) wanted.grow(transform_point(place, dvec3(p)));
    const dvec3 pad =
        16.0 * std::numeric_limits<double>::epsilon() * glm::max(glm::abs(wanted.min), glm::abs(wanted.max));
    const AabbD box = scene.bounds_under(item, place);
    ASSERT_EQ(box.min, wanted.min - pad);
    ASSERT_EQ(box.max, wanted.max + pad);
  }
}

}  // namespace
}  // namespace sightline::core::scene_meshes_test
