#include "sightline/importers/internal/text_encoding.h"

#include <gtest/gtest.h>

#include "sightline/importers/internal/text_scanner.h"

namespace sightline::importers::text_encoding_test {
namespace {

TEST(TextEncoding, ValidUtf8) {
  for (const char* good :
       {"", "plain", "\xc3\xbc", "\xe2\x82\xac", "\xf0\x9f\x94\xa7", "\xef\xbf\xbf", "\xf4\x8f\xbf\xbf"})
    EXPECT_TRUE(is_utf8(good)) << good;
  for (const char* bad :
       {"\xfc", "\x80", "\xc3", "\xc0\xaf", "\xc1\xbf", "\xe0\x9f\xbf", "\xed\xa0\x80", "\xf0\x8f\xbf\xbf",
        "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "a\xe2\x82", "\xe2\x82z", "\xff\xfe"})
    EXPECT_FALSE(is_utf8(bad)) << bad;
}

TEST(TextEncoding, Windows1252) {
  EXPECT_EQ(utf8_from_windows_1252("gr\xfcn \x80 \x93x\x94"), "gr\xc3\xbcn \xe2\x82\xac \xe2\x80\x9cx\xe2\x80\x9d");
  std::string all;
  for (int c = 0; c < 256; ++c) all += char(c);
  EXPECT_TRUE(is_utf8(utf8_from_windows_1252(all)));
  EXPECT_EQ(utf8_by_guess("\xc3\xbc"), "\xc3\xbc");
  EXPECT_EQ(utf8_by_guess("\xfc"), "\xc3\xbc");
}

TEST(TextEncoding, Utf16) {
  const auto decode = [](std::string_view bytes) { return utf8_from_utf16(std::as_bytes(std::span(bytes))); };
  using namespace std::string_view_literals;
  EXPECT_EQ(decode("\xff\xfe"
                   "a\0\xfc\0"sv),
            "a\xc3\xbc");
  EXPECT_EQ(decode("\xfe\xff"
                   "\0a\0\xfc"sv),
            "a\xc3\xbc");
  EXPECT_EQ(decode("\xfe\xff\xd8\x3d\xdd\x27"sv), "\xf0\x9f\x94\xa7");
  EXPECT_EQ(decode("\xfe\xff\xd8\x3d\0a\xdd\x27"sv),
            "\xef\xbf\xbd"
            "a\xef\xbf\xbd");  // lone surrogates
  EXPECT_EQ(decode("\xfe\xff\xd8"sv), "");
  EXPECT_FALSE(decode("plain"sv));
  EXPECT_FALSE(decode("\xff"sv));
}

TEST(TextEncoding, ExcerptsAreShortValidAndOnOneLine) {
  EXPECT_EQ(excerpt("a\tb\nc"), "'a b c'");
  EXPECT_EQ(excerpt("\xfc"), "'\xc3\xbc'");
  const std::string cut = excerpt(std::string(39, 'x') + "\xc3\xbc and more");
  EXPECT_EQ(cut, "'" + std::string(39, 'x') + "…'");
}

}  // namespace
}  // namespace sightline::importers::text_encoding_test
