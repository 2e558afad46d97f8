// Numbers of text files: the short way to read decimals gives what std::from_chars gives, to the bit.
#include "sightline/importers/internal/text_scanner.h"

#include <bit>
#include <random>
#include <string>

#include <gtest/gtest.h>

namespace sightline::importers::text_scanner_test {
namespace {

TextScanner scanner(const std::string& text) {
  return TextScanner(std::as_bytes(std::span(text)));
}

/// What the scanner must make of a word: its twin without the short way.
std::uint64_t bits_of(std::string_view word) {
  double value = 0.0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && stop == word.data() + word.size() ? std::bit_cast<std::uint64_t>(value) : ~0ull;
}

void expect_same(const std::string& word) {
  double value = 0.0;
  const auto found = scanner(word).number(value);
  ASSERT_EQ(found == TextScanner::Found::kNumber, bits_of(word) != ~0ull) << word;
  if (found == TextScanner::Found::kNumber) {
    ASSERT_EQ(std::bit_cast<std::uint64_t>(value), bits_of(word)) << word;
  }
}

TEST(TextScanner, DecimalsAreThoseOfFromChars) {
  for (const char* word : {"0",
                           "-0",
                           "0.0",
                           "-0.0",
                           ".5",
                           "-.5",
                           "5.",
                           "-5.",
                           ".",
                           "-",
                           "-.",
                           "1.5.2",
                           "1-2",
                           "12a",
                           "1e5",
                           "999999999999999",
                           "9999999999999999",
                           "0.999999999999999",
                           "0.000000000000001",
                           "0.0000000000000001",
                           "123456789.12345678",
                           "9007199254740993",
                           "000000000000000001"})
    expect_same(word);
  std::mt19937_64 random(1);
  for (int i = 0; i < 200000; ++i) {
    std::string word = random() % 2 ? "-" : "";
    const std::size_t digits = 1 + random() % 18, point = random() % 20;
    for (std::size_t d = 0; d < digits; ++d) {
      if (d == point) word += '.';
      word += char('0' + random() % 10);
    }
    expect_same(word);
  }
}

TEST(TextScanner, LinesOfEverySystem) {
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    const std::string text = " 1 2\t" + end + end + "word 3";
    TextScanner lines = scanner(text);
    double value = 0.0;
    EXPECT_EQ(lines.number_in_line(value), TextScanner::Found::kNumber);
    const std::string_view second = lines.rest();
    EXPECT_EQ(lines.number_in_line(value), TextScanner::Found::kNumber);
    EXPECT_EQ(value, 2.0);
    EXPECT_EQ(lines.number_in_line(value), TextScanner::Found::kEnd);
    lines.back_to(second);
    EXPECT_EQ(lines.number_in_line(value), TextScanner::Found::kNumber);
    EXPECT_TRUE(lines.at_line_end());
    EXPECT_TRUE(lines.next_line());
    EXPECT_EQ(lines.word_in_line(), "");
    EXPECT_TRUE(lines.next_line());
    EXPECT_EQ(lines.word_in_line(), "word");
    EXPECT_EQ(lines.number(value), TextScanner::Found::kNumber);
    EXPECT_FALSE(lines.next_line());
  }
}

}  // namespace
}  // namespace sightline::importers::text_scanner_test
