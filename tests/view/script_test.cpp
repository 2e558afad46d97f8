// Scripts: what lines say, which events they become, what they expect.
#include "sightline/apps/view/script.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

namespace sightline::apps::script_test {
namespace {

using Type = Event::Type;

core::Expected<std::vector<Event>> events(const std::string& line) {
  return events_of(parse_script(line).at(0));
}

TEST(ScriptTest, LinesAreCommandsWithAnArgument) {
  const auto steps = parse_script("# comment\n\n  fit  \r\nexpect /a/b   = 3\n\ttype two words");
  ASSERT_EQ(steps.size(), 3u);
  EXPECT_EQ(steps[0].line, 3);
  EXPECT_EQ(steps[0].name, "fit");
  EXPECT_EQ(steps[0].argument, "");
  EXPECT_EQ(steps[1].line, 4);
  EXPECT_EQ(steps[1].argument, "/a/b   = 3");
  EXPECT_EQ(steps[2].argument, "two words");
  EXPECT_FALSE(read_script("/no/such/script"));
}

TEST(ScriptTest, MouseAndKeysBecomeEvents) {
  const auto click = events("click 30 40 ctrl right");
  ASSERT_TRUE(click && click->size() == 3);
  EXPECT_EQ((*click)[0].type, Type::kCursor);
  EXPECT_EQ((*click)[1].key, GLFW_MOUSE_BUTTON_RIGHT);
  EXPECT_EQ((*click)[1].mods, GLFW_MOD_CONTROL);
  EXPECT_TRUE((*click)[1].down && !(*click)[2].down);
  EXPECT_EQ((*click)[2].at, core::dvec2(30, 40));

  const auto drag = events("drag 0 0 8 4 middle");
  ASSERT_TRUE(drag && drag->size() == 7);
  EXPECT_EQ((*drag)[3].at, core::dvec2(4, 2));
  EXPECT_EQ(drag->back().at, core::dvec2(8, 4));

  const auto bent = events("drag 0 0 8 4 8 12 shift");
  ASSERT_TRUE(bent && bent->size() == 11);
  EXPECT_EQ((*bent)[5].at, core::dvec2(8, 4));
  EXPECT_EQ((*bent)[7].at, core::dvec2(8, 8));
  EXPECT_EQ(bent->back().at, core::dvec2(8, 12));

  const auto key = events("press ctrl+shift+z");
  ASSERT_TRUE(key && key->size() == 2);
  EXPECT_EQ(key->front().key, GLFW_KEY_Z);
  EXPECT_EQ(key->front().mods, GLFW_MOD_CONTROL | GLFW_MOD_SHIFT);
  EXPECT_EQ(events("press f12")->front().key, GLFW_KEY_F12);
  EXPECT_EQ(events("press escape")->front().key, GLFW_KEY_ESCAPE);

  const auto text = events("type aß");
  ASSERT_TRUE(text && text->size() == 2);
  EXPECT_EQ(text->back().text, "ß");
  EXPECT_EQ(events("wheel -2")->front().wheel, -2.0);
  EXPECT_TRUE(events("fit")->empty());
}

TEST(ScriptTest, BadArgumentsAreNamed) {
  for (const char* line : {"click 3", "click a b", "click 1 2 wrong", "drag 1 2 3", "drag 1 2", "drag 1 2 3 4 5",
                           "press nokey", "press hyper+z", "wheel", "wheel 1 2", "move 1"}) {
    const auto made = events(line);
    ASSERT_FALSE(made) << line;
    EXPECT_EQ(made.error().message.find(parse_script(line)[0].name + ": expected "), 0u) << made.error().message;
  }
}

TEST(ScriptTest, ExpectationsCompareNumbersAndTexts) {
  const std::pair<std::string, const char*> good[] = {
      {"3", "= 3"},         {"3", "= 3.0"},           {"10", "> 9"},      {"2", "<= 2"},        {"2", "!= 3"},
      {"\"cpu\"", "= cpu"}, {"\"cpu\"", "= \"cpu\""}, {"true", "= true"}, {"[1,2]", "= [1,2]"}, {"-1.5", "< -1"}};
  for (const auto& [value, demand] : good) EXPECT_TRUE(*fulfils(value, demand)) << value << ' ' << demand;
  for (const char* demand : {"= C:\\a", "= \"C:\\a\"", "= \"C:\\\\a\""})
    EXPECT_TRUE(*fulfils(R"("C:\\a")", demand)) << demand;
  const std::pair<std::string, const char*> bad[] = {
      {"3", "= 4"}, {"10", "< 9"}, {"\"cpu\"", "= gpu"}, {"false", "= true"}, {"3", "!= 3"}};
  for (const auto& [value, demand] : bad) EXPECT_FALSE(*fulfils(value, demand)) << value << ' ' << demand;
  EXPECT_FALSE(fulfils("3", "~ 3"));
  EXPECT_FALSE(fulfils("3", ""));
}

}  // namespace
}  // namespace sightline::apps::script_test
