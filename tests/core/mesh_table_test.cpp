// Tables of meshes against plain vectors, and lists that were copied from them: those never change.
#include "sightline/core/mesh_table.h"

#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"

namespace sightline::core::mesh_table_test {
namespace {

std::shared_ptr<const Mesh> named(int number) {
  auto mesh = std::make_shared<Mesh>();
  mesh->name = std::to_string(number);
  return mesh;
}

using Twin = std::vector<std::string>;  // names; empty where there is no mesh

void expect_same(const MeshList& list, const Twin& twin) {
  ASSERT_EQ(list.size(), twin.size());
  for (std::size_t i = 0; i < twin.size(); ++i) {
    ASSERT_EQ(list[i].name, twin[i]) << i;
    ASSERT_EQ(list.share(i) == nullptr, twin[i].empty()) << i;
  }
  ASSERT_TRUE(list[twin.size()].name.empty());
}

TEST(MeshTable, IsAVectorWhoseListsNeverChange) {
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    MeshTable table;
    Twin twin;
    std::vector<std::pair<MeshList, Twin>> lists;
    int number = 0;
    for (int step = 0; step < 60; ++step) {
      switch (random() % 7) {
        case 0:
        case 1:
          for (auto n = random() % 150; n > 0; --n) {
            table.push_back(named(++number));
            twin.push_back(std::to_string(number));
          }
          break;
        case 2: {
          std::vector<std::uint32_t> gone;
          for (auto n = random() % 5; n > 0 && !twin.empty(); --n)
            gone.push_back(std::uint32_t(random() % twin.size()));
          table.remove(gone);
          for (const std::uint32_t index : gone) twin[index].clear();
          break;
        }
        case 5:
          for (auto n = random() % 5; n > 0 && !twin.empty(); --n) {
            const std::size_t index = random() % twin.size();
            if (!twin[index].empty()) continue;
            table.set(index, named(++number));
            twin[index] = std::to_string(number);
          }
          break;
        case 3:
          if (random() % 4 == 0 && !twin.empty()) {
            twin.resize(random() % twin.size());
            table.truncate(twin.size());
          }
          break;
        case 4: {
          MeshTable other = table;  // both go on from here
          other.push_back(named(++number));
          if (random() % 2) {
            table = std::move(other);
            twin.push_back(std::to_string(number));
          } else {
            table.push_back(nullptr);
            twin.emplace_back();
          }
          break;
        }
        default:
          lists.emplace_back(table.list(), twin);
      }
      ASSERT_NO_FATAL_FAILURE(expect_same(table.list(), twin));
    }
    for (const auto& [list, was] : lists) ASSERT_NO_FATAL_FAILURE(expect_same(list, was));
  }
}

TEST(MeshTable, KeepsNoMeshThatNobodyHas) {
  MeshTable table;
  std::vector<std::weak_ptr<const Mesh>> meshes;
  for (int i = 0; i < 200; ++i) {
    auto mesh = named(i);
    meshes.push_back(mesh);
    table.push_back(std::move(mesh));
  }
  MeshList list = table.list();
  const std::uint32_t gone[] = {3, 150};
  table.remove(gone);
  EXPECT_FALSE(meshes[3].expired()) << "the list has it";
  list = table.list();
  EXPECT_TRUE(meshes[3].expired() && meshes[150].expired());
  EXPECT_FALSE(meshes[4].expired());
  table.truncate(100);
  list = {};
  EXPECT_TRUE(meshes[120].expired());
  EXPECT_FALSE(meshes[99].expired());
}

TEST(MeshTable, ASnapshotKeepsMeshesThatTheSceneRemoves) {
  Mesh triangle;
  triangle.name = "triangle";
  triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.indices = {0, 1, 2};
  Scene scene;
  const MeshId mesh = scene.add_mesh(triangle).value();
  const ItemId item = scene.add_mesh_instance(scene.root(), mesh);
  ASSERT_TRUE(scene.commit());
  Snapshot snapshot(scene);
  const Slot slot = snapshot.slot(item);
  scene.remove_item(item);
  scene.remove_mesh(mesh);
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(scene.add_mesh(triangle));
  EXPECT_EQ(snapshot.mesh(slot).name, "triangle");
  const auto delta = scene.commit();
  ASSERT_TRUE(delta);
  EXPECT_EQ(snapshot.mesh(slot).name, "triangle");
  snapshot.apply(*delta);
  EXPECT_EQ(snapshot.slot(item), kNone);
}

}  // namespace
}  // namespace sightline::core::mesh_table_test
