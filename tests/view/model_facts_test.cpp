#include "sightline/apps/view/model_facts.h"

#include <gtest/gtest.h>

namespace sightline::apps {
namespace {

TEST(ModelFacts, FindWhatIsOdd) {
  core::Scene scene;
  const core::NodeId node = scene.add_node(scene.root(), "plant");
  for (int i = 0; i < 40; ++i)
    scene.add_primitive(node, core::Box{1, 1, 1}, core::translation({double(i % 7), double(i / 7), 0.0}));
  core::FittedBounds fitted{{{-1, -1, -1}, {7, 7, 1}}, 0};
  EXPECT_TRUE(findings(scene, fitted).empty());
  const core::ItemId flat = scene.add_primitive(node, core::Cylinder{0.0f, 2.0f});
  const core::ItemId far = scene.add_primitive(node, core::Box{1, 1, 1}, core::translation({1e6, 0.0, 0.0}));
  fitted.outliers = 1;
  const auto found = findings(scene, fitted);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].items, std::vector{far});
  EXPECT_EQ(found[0].words, "1 item lies too far from all others: fitted views leave it out");
  EXPECT_EQ(found[1].items, std::vector{flat});
  EXPECT_EQ(found[1].words, "1 item has no volume");
}

TEST(ModelFacts, TellFilesAndExtents) {
  core::Scene scene;
  scene.add_primitive(scene.root(), core::Box{1, 1, 1});
  FileStates states([] { return 0.0; });
  const auto facts = model_facts({"/none/a.rvm"}, states, scene, {{0, 0, 1}, {12, 3, 5}}, {Units::kMillimetres, 0});
  ASSERT_EQ(facts.size(), 7u);
  EXPECT_EQ(facts[0], (Fact{"a.rvm", "no longer there"}));
  EXPECT_EQ(facts[1], (Fact{"items", "1"}));
  EXPECT_EQ(facts[2], (Fact{"along X", "12,000 mm"}));
  EXPECT_EQ(facts[6], (Fact{"to", "12,000  3,000  5,000"}));
}

}  // namespace
}  // namespace sightline::apps
