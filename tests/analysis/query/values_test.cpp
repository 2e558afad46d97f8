#include "sightline/analysis/query/values.h"

#include <map>

#include "sightline/tests/analysis/query/plant.h"
#include "sightline/tests/core/primitive_samples.h"

namespace sightline::query::values_test {
namespace {

using core::ItemId;
using ValuesTest = tests::QueryTest;

/// "value 2, value 1, without 3"
std::string words(const Values& values) {
  std::string text;
  for (const Values::Value& value : values.all) text += value.text + " " + std::to_string(value.items) + ", ";
  return text + "without " + std::to_string(values.without);
}
std::string words(const core::Scene& scene, std::string_view key) {
  const auto values = values_of(scene, key);
  return values ? words(*values) : values.error().message;
}

TEST_F(ValuesTest, AreThoseOfTheNearestNode) {
  EXPECT_EQ(words(scene, "dn"), "80 mm 2, 150 mm 1, 300 1, without 1");
  EXPECT_EQ(words(scene, "System"), "CW 3, HW 1, without 1");
  const auto values = values_of(scene, "DN");
  ASSERT_TRUE(values);
  EXPECT_EQ(values->all[values->of_item[to_index(pipe)]].text, "150 mm");
  EXPECT_EQ(values->all[values->of_item[to_index(wheel)]].text, "80 mm");
  EXPECT_EQ(values->of_item[to_index(other)], core::kNone);
}

TEST_F(ValuesTest, KindMaterialLayerFileAndSizeAreOfAllItems) {
  scene.set_layers(line10, core::kLayerInsulation);
  scene.set_visible(line10, false);
  EXPECT_EQ(words(scene, "@kind"), "box 3, sphere 2, without 0");
  EXPECT_EQ(words(scene, "@Material"), "#ff0000 1, Steel 1, without 3");
  EXPECT_EQ(words(scene, "@layer"), "model 4, insulation 1, without 0");
  EXPECT_EQ(words(scene, "@file"), "a.rvm 4, b.ifc 1, without 0");
  EXPECT_EQ(words(scene, "@size"), "0.125 1, 0.25 1, 0.5 1, 1 1, 2 1, without 0");
}

TEST_F(ValuesTest, KeysAreListedWithWhatHasThem) {
  const std::vector<Key> keys = attribute_keys(scene);
  ASSERT_EQ(keys.size(), 3u);
  EXPECT_EQ(keys[0].name, "DN");
  EXPECT_EQ(keys[0].items, 4u);
  EXPECT_EQ(keys[0].values, 3u);
  EXPECT_EQ(keys[1].name, "System");
  EXPECT_EQ(keys[1].items, 4u);
  EXPECT_EQ(keys[1].values, 3u);
  EXPECT_EQ(keys[2].name, "Type");
  EXPECT_EQ(keys[2].items, 2u);
}

TEST_F(ValuesTest, AKeyThatNothingHasNamesOthers) {
  EXPECT_EQ(words(scene, "Sys"), "no item has a value for \"Sys\"; keys: System, DN, Type");
  EXPECT_EQ(words(scene, "@colour"),
            "no item has a value for \"@colour\"; keys: @kind, @material, @layer, @file, @size");
  EXPECT_FALSE(values_of(core::Scene(), "@kind"));
  EXPECT_TRUE(attribute_keys(core::Scene()).empty());
}

TEST(Values, BeginWithNumbers) {
  EXPECT_EQ(number_of("150 mm"), 150.0);
  EXPECT_EQ(number_of(" +1.5e3bar"), 1500.0);
  EXPECT_EQ(number_of("-0.25"), -0.25);
  for (const char* none : {"", "DN150", "nan", "inf", "1e999", "--1", "+-1"})
    EXPECT_EQ(number_of(none), std::nullopt) << none;
}

/// The value of an item by walking up from it, and keys by asking each item for each key.
TEST(Values, AreAsWalkingUpFromEachItemFindsThem) {
  constexpr unsigned kSeed = 7;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  tests::Random random(kSeed);
  const char* const names[] = {"A", "a", "B", "C"};
  for (int round = 0; round < 20; ++round) {
    core::Scene scene;
    std::vector<core::NodeId> nodes{scene.root()};
    for (int i = 0; i < 200; ++i) {
      const core::NodeId node = scene.add_node(nodes[random() % nodes.size()]);
      while (random() % 2 == 0) scene.set_attribute(node, names[random() % 4], std::to_string(random() % 5));
      while (random() % 3 != 0) scene.add_primitive(node, core::Sphere{1.0f});
      if (i % 10 == 9) {
        scene.remove_node(node);
        continue;
      }
      nodes.push_back(node);
    }
    std::map<std::string, std::uint32_t> with;
    for (const std::string key : {"a", "b", "c"}) {
      const auto values = values_of(scene, key);
      ASSERT_TRUE(values);
      std::uint32_t without = 0;
      for (std::size_t i = 0; i < scene.item_slots(); ++i) {
        if (!scene.contains_item(ItemId(i))) {
          EXPECT_EQ(values->of_item[i], core::kNone);
          continue;
        }
        const std::string* value = nullptr;
        for (core::NodeId node = scene.node_of(ItemId(i)); node.valid() && !value; node = scene.parent(node))
          for (const auto& [name, text] : scene.attributes(node))
            if (!value && (name == key || name == std::string(1, char(key[0] - 32)))) value = &text;
        ASSERT_EQ(value != nullptr, values->of_item[i] != core::kNone);
        if (!value) {
          ++without;
          continue;
        }
        EXPECT_EQ(values->all[values->of_item[i]].text, *value);
        ++with[key];
      }
      EXPECT_EQ(values->without, without);
    }
    for (const Key& key : attribute_keys(scene)) EXPECT_EQ(key.items, with[std::string(1, char(key.name[0] | 32))]);
  }
}

}  // namespace
}  // namespace sightline::query::values_test
