#include "sightline/apps/view/attribute_list.h"

#include "sightline/analysis/query/conditions.h"
#include "sightline/tests/analysis/query/plant.h"

namespace sightline::apps::attribute_list_test {
namespace {

using AttributeListTest = tests::QueryTest;

TEST_F(AttributeListTest, HasKeysAndTheValuesOfOne) {
  AttributeList list(scene);
  ASSERT_EQ(list.keys().size(), 3u + query::own_keys().size());
  EXPECT_EQ(list.keys().front().name, "DN");
  EXPECT_EQ(list.keys().back().name, "@size");
  list.choose("DN");
  EXPECT_EQ(list.values().all.size(), 3u);
  EXPECT_TRUE(list.has_numbers());
  list.choose("System");
  EXPECT_EQ(list.values().all.size(), 2u);
  EXPECT_FALSE(list.has_numbers());
  scene.set_attribute(line10, "SYSTEM", "CW");
  list.follow_scene();
  EXPECT_EQ(list.values().all.size(), 1u);
  EXPECT_TRUE(AttributeList(core::Scene()).keys().size() == query::own_keys().size());
}

/// The conditions that a click makes are true of the items that the list has counted.
TEST_F(AttributeListTest, ConditionsHoldForWhatWasCounted) {
  AttributeList list(scene);
  for (const query::Key& key : list.keys()) {
    list.choose(key.name);
    for (const query::Values::Value& value : list.values().all) {
      const auto found = query::find_items(scene, condition_of(key.name, value.text));
      ASSERT_TRUE(found) << key.name << " " << value.text << ": " << found.error().message;
      EXPECT_EQ(found->size(), value.items) << key.name << " " << value.text;
    }
  }
  EXPECT_EQ(condition_of_range("DN", "80", ""), "DN>=80");
  EXPECT_EQ(condition_of_range("DN", "80", "2e2"), "DN>=80 & DN<=2e2");
  EXPECT_FALSE(condition_of_range("DN", "", ""));
  EXPECT_FALSE(condition_of_range("DN", "80 mm", ""));
}

TEST_F(AttributeListTest, PropertiesAreTables) {
  scene.set_attribute(valve, "Note", "a, \"b\"");
  const core::ItemId items[] = {pipe, wheel, other};
  EXPECT_EQ(properties_table(scene, items, ','),
            "path,kind,System,DN,Type,Note\n"
            "a.rvm//LINE-1,box,CW,150 mm,,\n"
            "a.rvm//LINE-1//VALVE,box,CW,80 mm,Gate,\"a, \"\"b\"\"\"\n"
            "b.ifc,sphere,,,,\n");
  const std::string one = properties_table(scene, std::span(items, 1), '\t');
  EXPECT_EQ(one.find("path\ta.rvm//LINE-1\nkind\tbox\n"), 0u) << one;
  EXPECT_NE(one.find("\nSystem\tCW\nDN\t150 mm\n"), std::string::npos) << one;
}

}  // namespace
}  // namespace sightline::apps::attribute_list_test
