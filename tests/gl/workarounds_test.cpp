#include "sightline/gl/workarounds.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

#include "sightline/gl/internal/shader_source.h"

namespace sightline::gl {
namespace {

TEST(Workarounds, TheTableIsInOrderAndComplete) {
  std::set<std::string_view> names;
  ASSERT_EQ(workaround_facts().size(), kWorkaroundCount);
  for (std::size_t i = 0; i < kWorkaroundCount; ++i) {
    const WorkaroundFacts& facts = workaround_facts()[i];
    EXPECT_EQ(std::size_t(facts.workaround), i);
    EXPECT_TRUE(names.insert(facts.name).second) << facts.name;
    EXPECT_FALSE(facts.fault.empty() || facts.way.empty() || facts.report.empty()) << facts.name;
  }
}

TEST(Workarounds, SwitchesAreReadAndLaterOnesCount) {
  const auto switches = WorkaroundSwitches::parse("plain-depth=on,no-timer=off,plain-depth=off,four-samples=on");
  ASSERT_TRUE(switches);
  EXPECT_TRUE(switches->named[Workaround::kPlainDepth]);
  EXPECT_FALSE(switches->on[Workaround::kPlainDepth]);
  EXPECT_TRUE(switches->named[Workaround::kNoTimer]);
  EXPECT_TRUE(switches->on[Workaround::kFourSamples]);
  EXPECT_FALSE(switches->named[Workaround::kSmallBlocks]);
  const auto none = WorkaroundSwitches::parse("");
  ASSERT_TRUE(none);
  const WorkaroundSwitches both = switches->with(*WorkaroundSwitches::parse("four-samples=off"));
  EXPECT_FALSE(both.on[Workaround::kFourSamples]);
  EXPECT_TRUE(both.named[Workaround::kPlainDepth]);
}

TEST(Workarounds, BadSwitchesAreRefusedWithAllNames) {
  for (const char* text : {"plain-depth", "plain-depth=", "plain-depth=1", "plain_depth=on", "=on", ",", "no-timer=on,x=on"}) {
    const auto switches = WorkaroundSwitches::parse(text);
    ASSERT_FALSE(switches) << text;
    for (const WorkaroundFacts& facts : workaround_facts())
      EXPECT_NE(switches.error().message.find(facts.name), std::string::npos) << text << ": " << facts.name;
  }
}

TEST(Workarounds, AFailedCheckTurnsItsOwnOnUnlessASwitchSaysOtherwise) {
  for (const WorkaroundFacts& facts : workaround_facts()) {
    DriverTest test;
    test.results.fill(CheckResult::kPassed);
    EXPECT_FALSE(choose_workarounds(test, {})[facts.workaround]);
    test.results[std::size_t(facts.check)] = CheckResult::kFailed;
    const std::string name(facts.name);
    for (const WorkaroundFacts& other : workaround_facts())
      EXPECT_EQ(choose_workarounds(test, {})[other.workaround], other.check == facts.check) << name;
    EXPECT_FALSE(choose_workarounds(test, *WorkaroundSwitches::parse(name + "=off"))[facts.workaround]);
    const auto on = *WorkaroundSwitches::parse(name + "=on");
    EXPECT_TRUE(choose_workarounds({}, on)[facts.workaround]);
    test.results.fill(CheckResult::kPassed);
    EXPECT_EQ(choose_workarounds(test, on)[facts.workaround], facts.workaround != Workaround::kAddBaseVertex);
  }
}

TEST(Workarounds, ShadersKnowOfTheirs) {
  Workarounds on;
  EXPECT_TRUE(with_workarounds({}, on).defines.empty());
  on.set(Workaround::kPlainDepth, true);
  on.set(Workaround::kAddBaseVertex, true);
  const ShaderContext context = with_workarounds({}, on);
  EXPECT_EQ(context.defines, (std::vector<std::string>{"PLAIN_DEPTH", "ADD_BASE_VERTEX"}));
  EXPECT_EQ(context.extensions, std::vector<std::string>{"GL_ARB_shader_draw_parameters"});
}

}  // namespace
}  // namespace sightline::gl
