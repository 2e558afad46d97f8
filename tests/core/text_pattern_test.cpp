#include "sightline/core/internal/text_pattern.h"

#include <random>
#include <regex>
#include <string>

#include <gtest/gtest.h>

namespace sightline::core::text_pattern_test {
namespace {

using Random = std::mt19937;

bool fits(const std::string& pattern, const std::string& text) {
  const auto made = TextPattern::regular(pattern);
  EXPECT_TRUE(made) << pattern << ": " << made.error().message;
  return made && made->fits(text);
}

/// A few atoms, some repeated or optional. Groups are not repeated without end, which would take the standard library
/// years.
std::string random_pattern(Random& random, int depth) {
  const char* const atoms[] = {"a", "B", "x", "1", "-", "\\.", ".", "[ab]", "[^a-b]", "\\d", "\\w", "\\S", "[x\\d]"};
  const char* const repeats[] = {"", "", "", "?", "{2}", "{0,2}", "*", "+", "{1,}", "*?"};
  std::string pattern = random() % 6 == 0 ? "^" : "";
  for (auto n = 1 + random() % 3; n > 0; --n) {
    const bool group = depth > 0 && random() % 3 == 0;
    pattern += group ? (random() % 2 == 0 ? "(" : "(?:") + random_pattern(random, depth - 1) + ")"
                     : std::string(atoms[random() % std::size(atoms)]);
    pattern += repeats[random() % (group ? 5 : std::size(repeats))];
  }
  if (random() % 6 == 0) pattern += "$";
  return random() % 4 == 0 ? pattern + "|" + random_pattern(random, 0) : pattern;
}

TEST(TextPattern, FindsWhatTheStandardLibraryFinds) {
  constexpr unsigned kSeed = 20261129;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  Random random(kSeed);
  constexpr std::string_view kLetters = "abABxX1-. ";
  for (int i = 0; i < 2000; ++i) {
    const std::string pattern = random_pattern(random, 1);
    const std::regex regex(pattern, std::regex::icase);
    for (int k = 0; k < 5; ++k) {
      std::string text(random() % 8, ' ');
      for (char& c : text) c = kLetters[random() % kLetters.size()];
      ASSERT_EQ(fits(pattern, text), std::regex_search(text, regex)) << pattern << " in \"" << text << '"';
    }
  }
}

TEST(TextPattern, WildcardsFitTheWhole) {
  const auto fits = [](const char* pattern, const char* text) { return TextPattern::wildcards(pattern).fits(text); };
  EXPECT_TRUE(fits("PIPE-*", "pipe-"));
  EXPECT_TRUE(fits("*-*-*", "a--b"));
  EXPECT_TRUE(fits("P?PE[1]", "PIPE[1]")) << "brackets stand for themselves";
  EXPECT_TRUE(fits("", ""));
  EXPECT_TRUE(fits("*", "\xff\xc3")) << "bytes that are no characters";
  EXPECT_FALSE(fits("PIPE-?", "PIPE-"));
  EXPECT_FALSE(fits("PIPE-2", "PIPE-21"));
  EXPECT_FALSE(fits("IPE*", "PIPE-2"));
}

TEST(TextPattern, SeesCharactersOfUtf8) {
  EXPECT_TRUE(fits("^m.ller$", "M\u00fcller"));
  EXPECT_TRUE(fits("[\u00e0-\u00ff]", "M\u00fcller"));
  EXPECT_FALSE(fits("^m.ller$", "M\xfcller")) << "a byte that is no character";
  EXPECT_TRUE(fits("ller", "M\xfcller"));
  EXPECT_TRUE(fits("^\U0001f6e2{2}$", "\U0001f6e2\U0001f6e2"));
}

TEST(TextPattern, SaysWhereItIsWrong) {
  for (const char* const wrong : {"(", ")", "a)b", "[a", "[]", "*", "a|+", "a{", "a{2,1}", "a{1001}", "\\q", "\\",
                                  "\xff", "(?=a)", "[b-a]", "[\\D]", "((a{1000}){1000}){1000}"}) {
    const auto made = TextPattern::regular(wrong);
    ASSERT_FALSE(made) << wrong;
    EXPECT_EQ(made.error().message.find("regular expression, after byte "), 0u) << made.error().message;
  }
  EXPECT_FALSE(TextPattern::regular(std::string(100'000, '(')));
  std::string many = "a{1000}";
  for (int i = 0; i < 100; ++i) many += "|a{1000}";
  EXPECT_FALSE(TextPattern::regular(many));
}

TEST(TextPattern, TakesTimeInProportionToTheText) {
  EXPECT_FALSE(fits("(a+)+$", std::string(1'000'000, 'a') + "!"));
  EXPECT_TRUE(fits("^(a|c)*b$", std::string(1'000'000, 'a') + "b"));
  EXPECT_TRUE(fits("((a*)*)*b", "aab"));
}

}  // namespace
}  // namespace sightline::core::text_pattern_test
