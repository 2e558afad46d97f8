// Texts that are too long for their room keep both ends.
#include "sightline/apps/common/short_text.h"

#include <gtest/gtest.h>

namespace sightline::apps::short_text_test {
namespace {

/// Characters of UTF-8.
std::size_t length(std::string_view text) {
  std::size_t count = 0;
  for (const char c : text) count += (c & 0xc0) != 0x80;
  return count;
}
std::string in(std::size_t room, std::string_view text) {
  return shortened_to(text, [&](std::string_view t) { return length(t) <= room; });
}

TEST(ShortText, KeepsBothEnds) {
  EXPECT_EQ(in(20, "/PL-202001_HA/B1"), "/PL-202001_HA/B1");
  EXPECT_EQ(in(15, "FLANGE 1 of BRANCH /PL-202001_HA/B1"), "FLANGE 1 …HA/B1");
  EXPECT_EQ(in(15, "FLANGE 2 of BRANCH /PL-202001_HA/B4"), "FLANGE 2 …HA/B4");
  EXPECT_EQ(in(1, "ab"), "…");
  EXPECT_EQ(in(0, "ab"), "…") << "nothing is shorter";
  EXPECT_EQ(in(0, ""), "");
}

TEST(ShortText, NamesInATreeDoWithoutTheNameAbove) {
  const auto below = [](std::string_view above, std::string_view name, std::size_t room) {
    return shortened_below(above, name, [&](std::string_view t) { return length(t) <= room; });
  };
  EXPECT_EQ(below("/PL-1/B1", "FLANGE 1 of BRANCH /PL-1/B1", 27), "FLANGE 1 of BRANCH /PL-1/B1");
  EXPECT_EQ(below("/PL-1/B1", "FLANGE 1 of BRANCH /PL-1/B1", 20), "FLANGE 1 of BRANCH …");
  EXPECT_EQ(below("/PL-1/B1", "FLANGE 12 of BRANCH /PL-1/B1", 15), "FLANGE 12 of B…");
  EXPECT_EQ(below("/PL-1", "/PL-1/REDUCER-12", 8), "…UCER-12");
  EXPECT_EQ(below("/PL-202001_HA", "/PL-202001_HA/B1", 8), "…/B1");
  EXPECT_EQ(below("", "/PL-202001_HA/B1", 8), "/PL-2…B1");
  EXPECT_EQ(below("/PL-202001_HA", "pump", 8), "pump");
}

TEST(ShortText, KeepsCharactersWhole) {
  const std::string text = "äöüßéèñçåø日本語テスト/BÜGEL-Ä";
  for (std::size_t room = 1; room <= length(text); ++room) {
    const std::string kept = in(room, text);
    const std::size_t mark = kept.find("…");
    EXPECT_LE(length(kept), room);
    if (mark == kept.npos) continue;
    EXPECT_TRUE(text.starts_with(kept.substr(0, mark)));
    EXPECT_TRUE(text.ends_with(kept.substr(mark + 3)));
    EXPECT_GE(length(kept) + 2, room) << "nearly all of the room is used";
  }
}

}  // namespace
}  // namespace sightline::apps::short_text_test
