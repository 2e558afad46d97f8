#include "sightline/analysis/query/conditions.h"

#include <algorithm>

#include "sightline/analysis/measure/distances.h"
#include "sightline/tests/analysis/query/plant.h"
#include "sightline/tests/core/primitive_samples.h"

namespace sightline::query::conditions_test {
namespace {

using core::ItemId;

class Conditions : public tests::QueryTest {
 protected:
  using Items = std::vector<ItemId>;

  Items find(const char* text) {
    const auto items = find_items(scene, text);
    EXPECT_TRUE(items) << text << ": " << (items ? "" : items.error().message);
    EXPECT_TRUE(check_query(text)) << text;
    return items ? *items : Items{};
  }
  std::string error(const char* text) {
    const auto items = find_items(scene, text);
    return items ? "none" : items.error().message;
  }
};

TEST_F(Conditions, AllMustHold) {
  EXPECT_EQ(find("System=CW"), (Items{pipe, body, wheel}));
  EXPECT_EQ(find("System=CW & Type=Gate"), (Items{body, wheel}));
  EXPECT_EQ(find("System=CW & @kind=box"), (Items{pipe, wheel}));
  EXPECT_EQ(find("System=CW & @kind=box & @size<50cm"), (Items{wheel}));
  EXPECT_EQ(find("LINE-1 & LINE-10"), Items{});
  EXPECT_EQ(find(" LINE-1  &  @kind = SPHERE "), (Items{body}));
}

TEST_F(Conditions, NumbersAreComparedWithThoseThatValuesBeginWith) {
  EXPECT_EQ(find("DN>=150"), (Items{pipe, hot}));
  EXPECT_EQ(find("DN>150"), (Items{hot}));
  EXPECT_EQ(find("dn < 150"), (Items{body, wheel}));
  EXPECT_EQ(find("DN<=80"), (Items{body, wheel}));
  EXPECT_EQ(find("@size>=1"), (Items{pipe, hot}));
  EXPECT_EQ(find("@size>1000mm"), (Items{hot}));
  EXPECT_EQ(find("@size<=5in"), (Items{other}));
}

TEST_F(Conditions, ValuesAreOfTheNearestNodeAndPartsOfAnyAbove) {
  EXPECT_EQ(find("DN=150 mm"), (Items{pipe, body, wheel}));
  EXPECT_EQ(find("DN==150 mm"), (Items{pipe}));
  EXPECT_EQ(find("dn==*MM"), (Items{pipe, body, wheel}));
  EXPECT_EQ(find("DN!=150 mm"), (Items{body, wheel, hot, other}));
}

TEST_F(Conditions, HaveOpposites) {
  EXPECT_EQ(find("System!=CW"), (Items{hot, other}));
  EXPECT_EQ(find("!System=CW"), (Items{hot, other}));
  EXPECT_EQ(find("!!System=CW"), find("System=CW"));
  EXPECT_EQ(find("!LINE-1 & !b.ifc"), (Items{hot}));
  EXPECT_EQ(find("@kind!=box"), (Items{body, other}));
  EXPECT_EQ(find("!DN>=150"), (Items{body, wheel, other})) << "what has no value, too";
  EXPECT_EQ(find("@file=*.ifc"), (Items{other}));
  EXPECT_EQ(find("@material=Steel"), (Items{pipe}));
}

TEST_F(Conditions, NearIsMeasuredBetweenSurfaces) {
  // The valve's sphere begins 1.25 m beyond the pipe's box, the hot line's box 6.375 m beyond the wheel.
  EXPECT_EQ(find("@near<=1.26m of VALVE"), (Items{pipe}));
  EXPECT_EQ(find("@near<=1240mm of VALVE"), Items{});
  EXPECT_EQ(find("@near<=6.4 of VALVE"), (Items{pipe, hot}));
  EXPECT_EQ(find("!@near<=6.4 of VALVE"), (Items{body, wheel, other}));
  EXPECT_EQ(find("@near<=100 of VALVE & @kind=sphere"), (Items{other}));
}

TEST_F(Conditions, NamesWithSignsArePartsStill) {
  const core::NodeId odd = node(b, "a>b", {{"Note", "x < y"}});
  const ItemId item = box(odd, 30.0, 1.0f);
  EXPECT_EQ(find("a>b"), Items{item});
  EXPECT_EQ(find("Note=x < y"), Items{item});
  EXPECT_EQ(find("re:^a.b$"), Items{item});
}

TEST_F(Conditions, TellQueriesFromParts) {
  for (const char* query : {"a & b", "!a", "@kind=box", "DN>=5", "DN!=5", "@kind", "@nothing=1", "a & "})
    EXPECT_TRUE(is_query(query)) << query;
  for (const char* part : {"a", "R&D", "KEY=VALUE", "re:a|b", "a>b", "/SITE/PIPE-1"})
    EXPECT_FALSE(is_query(part)) << part;
}

TEST_F(Conditions, SayWhatIsWrong) {
  EXPECT_EQ(error("LIN & LINE-1"), "no part fits \"LIN\"");
  EXPECT_EQ(error("Sys>=5"), "no item has a value for \"Sys\"; keys: System, DN, Type");
  EXPECT_EQ(error(""), "expected a condition, found \"\"");
  EXPECT_EQ(error("a & "), "expected a condition, found \"\"");
  EXPECT_EQ(error("@kind"), "expected a key, a sign and a value, found \"@kind\"");
  EXPECT_EQ(error("@kind>3"), "expected @kind with = or !=, found \"@kind>3\"");
  EXPECT_EQ(error("@size=3"), "expected @size with <, <=, > or >= and a length, found \"@size=3\"");
  EXPECT_EQ(error("@size>3 miles"), "expected @size with <, <=, > or >= and a length, found \"@size>3 miles\"");
  EXPECT_EQ(error("@near<=-1 of VALVE"), "expected @near<=LENGTH of PART, found \"@near<=-1 of VALVE\"");
  EXPECT_EQ(error("@near<=1"), "expected @near<=LENGTH of PART, found \"@near<=1\"");
  EXPECT_EQ(error("@near<=1 of nobody"), "no part fits \"nobody\"");
  EXPECT_EQ(error("@colour=red"), "expected @kind, @material, @layer, @file, @size or @near, found \"@colour\"");
  EXPECT_FALSE(check_query("VALVE & re:("));
  EXPECT_FALSE(check_query("@near<=1 of re:("));
}

/// All pairs, measured.
TEST(NearItems, AreThoseOfAllPairs) {
  constexpr unsigned kSeed = 11;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  tests::Random random(kSeed);
  core::Scene scene;
  const core::NodeId part = scene.add_node(scene.root(), "part"), rest = scene.add_node(scene.root(), "rest");
  const auto add = [&](core::NodeId node) {
    const core::dvec3 at(tests::uniform(random, -5.0, 5.0), tests::uniform(random, -5.0, 5.0),
                         tests::uniform(random, -5.0, 5.0));
    const core::Primitive primitive =
        random() % 2 == 0 ? core::Primitive(core::Sphere{1.0f}) : core::Box{0.7f, 0.7f, 0.7f};
    return scene.add_primitive(node, primitive, core::Affine{core::dmat3(1.0), at});
  };
  std::vector<ItemId> there, others;
  for (int i = 0; i < 8; ++i) there.push_back(add(part));
  for (int i = 0; i < 150; ++i) others.push_back(add(rest));
  for (const double distance : {0.0, 0.25, 1.0, 20.0}) {
    std::vector<ItemId> expected;
    for (const ItemId item : others)
      if (std::any_of(there.begin(), there.end(), [&](ItemId one) {
            const auto found =
                measure::distance(*measure::Item::create(scene, item), *measure::Item::create(scene, one));
            return found.distance - found.error <= distance;
          }))
        expected.push_back(item);
    EXPECT_EQ(*find_items(scene, "@near<=" + std::to_string(distance) + " of part"), expected) << distance;
  }
}

}  // namespace
}  // namespace sightline::query::conditions_test
