#include "sightline/apps/report/heavy_parts.h"

#include <gtest/gtest.h>

#include "sightline/core/primitive.h"

namespace sightline::apps::heavy_parts_test {
namespace {

class HeavyParts : public testing::Test {
 protected:
  core::NodeId node(core::NodeId parent, const char* name) { return scene.add_node(parent, name); }
  void boxes(core::NodeId parent, int count) {
    for (int i = 0; i < count; ++i) scene.add_primitive(parent, core::Box{1.0f, 1.0f, 1.0f});
  }
  /// A fan of so many triangles.
  void fan(core::NodeId parent, std::uint32_t triangles) {
    core::Mesh mesh;
    mesh.positions = {{0, 0, 0}};
    for (std::uint32_t i = 0; i <= triangles; ++i) mesh.positions.push_back({1, float(i), 0});
    for (std::uint32_t i = 0; i < triangles; ++i)
      for (const std::uint32_t corner : {0u, i + 1, i + 2}) mesh.indices.push_back(corner);
    scene.add_mesh_instance(parent, scene.add_mesh(mesh).value());
  }
  std::vector<std::string> names(std::size_t most) {
    std::vector<std::string> names;
    for (const HeavyPart& part : heavy_parts(scene, most)) names.emplace_back(scene.name(part.node));
    return names;
  }

  core::Scene scene;
  core::NodeId file = node(scene.root(), "file");
};

using Names = std::vector<std::string>;

TEST_F(HeavyParts, AreSplitWhereTheyAreMostOfTheModel) {
  const core::NodeId zone = node(file, "zone");
  for (const char* name : {"a", "b", "c"}) boxes(node(zone, name), name[0] == 'b' ? 20 : name[0] == 'c' ? 15 : 10);
  boxes(node(file, "small"), 2);
  EXPECT_EQ(names(2), (Names{"b", "c"}));
  EXPECT_EQ(names(9).size(), 4u);
  const std::vector<HeavyPart> parts = heavy_parts(scene, 1);
  EXPECT_NEAR(parts[0].weight, 20.0 / 47.0, 1e-12);
  EXPECT_EQ(parts[0].items.size(), 20u);
}

TEST_F(HeavyParts, AreWholeWhereTheirOwnItemsWeighMore) {
  const core::NodeId pump = node(file, "pump");
  boxes(pump, 10);
  boxes(node(pump, "bolt"), 1);
  boxes(node(file, "rest"), 5);
  EXPECT_EQ(names(2), (Names{"pump", "rest"}));
}

TEST_F(HeavyParts, HiddenItemsWeighNothing) {
  const core::NodeId hidden = node(file, "hidden");
  boxes(hidden, 100);
  scene.set_visible(hidden, false);
  const core::NodeId insulation = node(file, "insulation");
  boxes(insulation, 100);
  scene.set_layers(insulation, core::kLayerInsulation);
  boxes(node(file, "seen"), 1);
  EXPECT_EQ(names(5), Names{"seen"});
  EXPECT_TRUE(heavy_parts(core::Scene(), 5).empty());
}

TEST_F(HeavyParts, AdviceFitsThem) {
  fan(node(file, "fine"), 6000);
  boxes(node(file, "many"), 1500);
  boxes(node(file, "few"), 3);
  fan(node(file, "coarse"), 20);
  const auto advice = [&](const char* name, bool from_surfaces) {
    for (const HeavyPart& part : heavy_parts(scene, 9))
      if (scene.name(part.node) == name) return advice_for(scene, part, from_surfaces);
    return std::string("not found");
  };
  EXPECT_EQ(advice("fine", true).find("coarser triangles"), 0u);
  EXPECT_EQ(advice("fine", false).find("levels of detail"), 0u);
  EXPECT_EQ(advice("many", false).find("leave out what is below a pixel"), 0u);
  EXPECT_EQ(advice("few", false).find("nothing"), 0u);
  EXPECT_EQ(advice("coarse", false).find("primitives in its meshes"), 0u);
  EXPECT_EQ(advice("coarse", true).find("nothing"), 0u);
}

}  // namespace
}  // namespace sightline::apps::heavy_parts_test
