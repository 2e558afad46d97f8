// Text in markup: whatever its bytes, it stays text.
#include "sightline/apps/common/markup.h"

#include <gtest/gtest.h>

namespace sightline::apps::markup_test {
namespace {

TEST(Markup, EscapesWhatIsMarkup) {
  EXPECT_EQ(escaped("a<b> & \"c\" 'd'"), "a&lt;b&gt; &amp; &quot;c&quot; &#39;d&#39;");
  EXPECT_EQ(escaped(""), "");
  EXPECT_EQ(escaped("tab\tline\nend"), "tab\tline\nend");
}

TEST(Markup, KeepsUtf8) {
  for (const char* text : {"Ä", "–", "漢", "😀", "\xef\xbf\xbd", "\xf4\x8f\xbf\xbd"}) EXPECT_EQ(escaped(text), text);
}

TEST(Markup, ReplacesWhatXmlDoesNotAllow) {
  const std::string replaced = "\xef\xbf\xbd";
  EXPECT_EQ(escaped(std::string_view("a\0b", 3)), "a" + replaced + "b");
  EXPECT_EQ(escaped("\x01\x1f"), replaced + replaced);
  EXPECT_EQ(escaped("\xe9t\xe9"), replaced + "t" + replaced) << "Latin-1";
  EXPECT_EQ(escaped("\xc3"), replaced) << "cut off";
  EXPECT_EQ(escaped("\xe2\x80<"), replaced + replaced + "&lt;") << "cut off before markup";
  EXPECT_EQ(escaped("\xc0\xbc"), replaced + replaced) << "an overlong '<'";
  EXPECT_EQ(escaped("\xed\xa0\x80"), replaced + replaced + replaced) << "a surrogate";
  EXPECT_EQ(escaped("\xef\xbf\xbe"), replaced + replaced + replaced) << "U+FFFE";
  EXPECT_EQ(escaped("\xf4\x90\x80\x80"), replaced + replaced + replaced + replaced) << "beyond U+10FFFF";
  EXPECT_EQ(escaped("\xff"), replaced);
}

}  // namespace
}  // namespace sightline::apps::markup_test
