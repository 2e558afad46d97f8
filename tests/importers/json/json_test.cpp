// JSON values against nlohmann's: the same texts, errors and order of keys for random values and damaged texts.
#include "sightline/importers/json/internal/json.h"

#include <cmath>
#include <limits>
#include <random>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace sightline::json::json_test {
namespace {

using Sorted = nlohmann::json;
using Ordered = nlohmann::ordered_json;

constexpr auto kReplace = nlohmann::detail::error_handler_t::replace;

template <class Twin>
std::string text_of(const Twin& twin, int indent = -1) {
  return twin.dump(indent, ' ', false, kReplace);
}

/// A value, and twins of the same content with either order of keys.
struct Twins {
  Value value;
  Sorted sorted;
  Ordered ordered;

  template <class T>
  static Twins of(const T& content) {
    return {content, content, content};
  }
};

class RandomValues {
 public:
  explicit RandomValues(unsigned seed) : random_(seed) {}

  Twins value(int depth) {
    switch (random_() % (depth > 0 ? 10 : 7)) {
      case 0:
        return Twins::of(nullptr);
      case 1:
        return Twins::of(random_() % 2 == 0);
      case 2:
        return Twins::of(integer());
      case 3:
        return Twins::of(std::uint64_t(integer()));
      case 4:
        return Twins::of(number());
      case 5:
        return Twins::of(float(number()));
      case 6:
        return Twins::of(text());
      case 7:
        return array(depth);
      default:
        return object(depth);
    }
  }

  std::size_t below(std::size_t n) { return random_() % n; }

  std::string text() {
    static const std::string kParts[] = {"a",
                                         "B",
                                         "\"",
                                         "\\",
                                         "/",
                                         "\n",
                                         "\t",
                                         std::string(1, '\0'),
                                         "\x1f",
                                         "\x7f",
                                         "\xc3\xa9",
                                         "\xe2\x82\xac",
                                         "\xf0\x9f\x98\x80",
                                         "\xff",
                                         "\xc3",
                                         "\xed\xa0\x80",
                                         "\xe2\x82",
                                         "\xc0\x80",
                                         "\xf4\x90\x80\x80",
                                         "\u2028"};
    std::string made;
    for (auto n = random_() % 6; n > 0; --n) made += kParts[below(std::size(kParts))];
    return made;
  }

 private:
  std::int64_t integer() {
    using Limits = std::numeric_limits<std::int64_t>;
    const std::int64_t kinds[] = {0,
                                  -1,
                                  1,
                                  Limits::min(),
                                  Limits::max(),
                                  std::int64_t(random_() << 32 | random_()),
                                  std::int64_t(random_() % 100)};
    return kinds[below(std::size(kinds))];
  }

  double number() {
    using Limits = std::numeric_limits<double>;
    const double kinds[] = {0.0,
                            -0.0,
                            1.0,
                            0.1,
                            1e300,
                            -1e300,
                            1e15,
                            1e16,
                            123456789.123,
                            5e-324,
                            Limits::max(),
                            Limits::min(),
                            Limits::infinity(),
                            -Limits::infinity(),
                            Limits::quiet_NaN(),
                            std::ldexp(double(random_()), int(random_() % 200) - 100)};
    return kinds[below(std::size(kinds))];
  }

  Twins array(int depth) {
    Twins made{Value::array(), Sorted::array(), Ordered::array()};
    for (auto n = random_() % 5; n > 0; --n) {
      const Twins element = value(depth - 1);
      made.value.push_back(element.value);
      made.sorted.push_back(element.sorted);
      made.ordered.push_back(element.ordered);
    }
    return made;
  }

  Twins object(int depth) {
    Twins made{Value::object(), Sorted::object(), Ordered::object()};
    for (auto n = random_() % 8; n > 0; --n) {
      const std::string key = text();
      const Twins member = value(depth - 1);
      made.value[key] = member.value;
      made.sorted[key] = member.sorted;
      made.ordered[key] = member.ordered;
      if (random_() % 8 > 0) continue;
      made.value.erase(key);
      made.sorted.erase(key);
      made.ordered.erase(key);
    }
    return made;
  }

  std::mt19937_64 random_;
};

/// Compares the parsers on one text: in file order, and with sorted keys.
void expect_parsed_alike(const std::string& text) {
  const Ordered ordered = Ordered::parse(text, nullptr, false);
  const Sorted twin = Sorted::parse(text, nullptr, false);
  const auto parsed = parse(text), in_order = parse(text, {.sort = true});
  ASSERT_EQ(parsed.has_value(), !ordered.is_discarded()) << text;
  ASSERT_EQ(in_order.has_value(), !twin.is_discarded()) << text;
  if (!parsed) return;
  EXPECT_EQ(parsed->dump(), text_of(ordered)) << text;
  EXPECT_EQ(in_order->dump(), text_of(twin)) << text;
  EXPECT_EQ(sorted(*parsed).dump(), text_of(twin)) << text;
  EXPECT_EQ(parsed->is_number_unsigned(), twin.is_number_unsigned()) << text;
  EXPECT_EQ(parsed->is_number_float(), twin.is_number_float()) << text;
}

TEST(Json, RandomValuesAreWrittenAndParsedLikeByTheTwin) {
  for (unsigned seed = 1; seed <= 3000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomValues random(seed);
    const Twins twins = random.value(5);
    for (const int indent : {-1, 0, 1, 4}) {
      ASSERT_EQ(twins.value.dump(indent), text_of(twins.ordered, indent));
      ASSERT_EQ(sorted(twins.value).dump(indent), text_of(twins.sorted, indent));
    }
    expect_parsed_alike(text_of(twins.ordered, 1));
    if (HasFailure()) return;
  }
}

TEST(Json, DamagedTextsFailLikeTheTwin) {
  static const std::string kInserted[] = {"{",  "}", "[",     "]", ",",    ":",      "\"",
                                          "\\", "-", "1e999", "0", "\xff", "\\ud800"};
  for (unsigned seed = 1; seed <= 3000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomValues random(seed);
    std::string text = text_of(random.value(4).ordered);
    for (auto times = 1 + random.below(2); times > 0 && !text.empty(); --times) {
      const std::size_t at = random.below(text.size());
      if (random.below(2) == 0)
        text.erase(at, 1 + random.below(3));
      else
        text.insert(at, kInserted[random.below(std::size(kInserted))]);
    }
    expect_parsed_alike(text);
    if (HasFailure()) return;
  }
}

TEST(Json, ErrorsTellTheByteAndTheTwinsReason) {
  for (const std::string text :
       {"", "{", "[1,]", "{\"a\" 1}", "\"\xff\"", "nul", "[1] 2", "{\"a\":1,}", "01", "\n\n  ?"}) {
    const auto parsed = parse(text);
    ASSERT_FALSE(parsed) << text;
    EXPECT_EQ(parsed.error().kind, ParseError::Kind::kSyntax);
    try {
      const Sorted twin = Sorted::parse(text);
      FAIL() << text << twin;
    } catch (const Sorted::parse_error& error) {
      EXPECT_EQ(parsed.error().byte, error.byte > 0 ? error.byte - 1 : 0) << text;
      EXPECT_TRUE(std::string_view(error.what()).ends_with(": " + parsed.error().reason)) << parsed.error().reason;
    }
  }
  const auto large = parse("[1e999]");
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().kind, ParseError::Kind::kRange);
  EXPECT_EQ(large.error().reason, "number overflow parsing '1e999'");
}

TEST(Json, IntegersKeepTheirKindAtTheirLimits) {
  for (const std::string text : {"0", "-0", "9223372036854775807", "9223372036854775808", "18446744073709551615",
                                 "18446744073709551616", "-9223372036854775808", "-9223372036854775809", "1.0", "1e2"})
    expect_parsed_alike(text);
  EXPECT_EQ(parse("18446744073709551615")->get<std::uint64_t>(), std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(parse("-9223372036854775808")->get<std::int64_t>(), std::numeric_limits<std::int64_t>::min());
  EXPECT_FALSE(Value(1).is_number_unsigned());
  EXPECT_TRUE(Value(1u).is_number_unsigned());
}

TEST(Json, TheLastMemberWithAKeyCounts) {
  for (const std::string text : {R"({"b":1,"a":2,"b":3})", R"({"a":1,"a":2})", R"({"":0,"":{"x":1,"x":2},"A":[]})"})
    expect_parsed_alike(text);
  EXPECT_EQ(parse(R"({"b":1,"a":2,"b":3})")->dump(), R"({"b":3,"a":2})");
}

TEST(Json, DeepTextsAreParsedAndFreedWithoutRecursion) {
  constexpr int kDepth = 1'000'000;
  std::string text;
  for (int i = 0; i < kDepth; ++i) text += i % 2 == 0 ? "[" : "{\"a\":";
  const std::string open = text;
  for (int i = kDepth; i-- > 0;) text += i % 2 == 0 ? "]" : "}";
  EXPECT_FALSE(parse(open));
  text.replace(open.size() - 5, 5, "{    ");  // the innermost object is empty
  EXPECT_TRUE(parse(text));
}

TEST(Json, TooDeepTextsAreRefusedAtTheBracket) {
  EXPECT_TRUE(parse("[[\"[[[\"]]", {.max_depth = 2}));
  const auto deep = parse("[0, [{}]]", {.max_depth = 2});
  ASSERT_FALSE(deep);
  EXPECT_EQ(deep.error().kind, ParseError::Kind::kDepth);
  EXPECT_EQ(deep.error().byte, 5u);
  EXPECT_EQ(deep.error().reason, "expected at most 2 nested arrays and objects");
}

TEST(Json, BracesMakeWhatTheTwinMakes) {
  const std::string text = "t";
  EXPECT_EQ((Value{{"a", 1}, {"b", {1, 2.5, "x"}}, {"c", {{"d", nullptr}}}}).dump(),
            text_of(Ordered{{"a", 1}, {"b", {1, 2.5, "x"}}, {"c", {{"d", nullptr}}}}));
  EXPECT_EQ((Value{{"b", 1}, {"a", 2}, {"b", 3}}).dump(), text_of(Ordered{{"b", 1}, {"a", 2}, {"b", 3}}));
  EXPECT_EQ((Value{{1, 2}, {"a", 2}}).dump(), text_of(Ordered{{1, 2}, {"a", 2}}));
  EXPECT_EQ((Value{{"a", {}}, {"b", Value::array()}}).dump(), text_of(Ordered{{"a", {}}, {"b", Ordered::array()}}));
  EXPECT_EQ(Value::array({{"a", 1}}).dump(), text_of(Ordered::array({{"a", 1}})));
  EXPECT_EQ((Value{text, text}).dump(), text_of(Ordered{text, text}));
  EXPECT_EQ(Value(std::vector<int>{1, 2}).dump(), "[1,2]");
  EXPECT_EQ(Value(std::array{0.5f, 2.0f}).dump(), "[0.5,2.0]");
  Value list;
  list.push_back({{"a", 1}});
  list.push_back({1, 2});
  EXPECT_EQ(list.dump(), R"([{"a":1},[1,2]])");
}

TEST(Json, MembersAreFoundInAnyOrder) {
  Value value = {{"b", 1}, {"a", 2}};
  for (const Value& with : {value, sorted(value)}) {
    EXPECT_EQ(with.at("a"), 2);
    EXPECT_EQ(with.at("b"), 1);
    EXPECT_EQ(with.find("c"), with.end());
    EXPECT_TRUE(with.contains("a"));
    EXPECT_EQ(with.value("a", 0), 2);
    EXPECT_EQ(with.value("c", 7), 7);
    EXPECT_EQ(with, value);
  }
  value["0"] = "first";
  value.update({{"a", "new"}, {"z", 1}});
  EXPECT_EQ(value.dump(), R"({"b":1,"a":"new","0":"first","z":1})");
  value.erase("a");
  EXPECT_EQ(value.dump(), R"({"b":1,"0":"first","z":1})");
  EXPECT_EQ(sorted(value).dump(), R"({"0":"first","b":1,"z":1})");
  std::string keys;
  for (const auto& [key, member] : value.items()) keys += key;
  EXPECT_EQ(keys, "b0z");
}

TEST(Json, AccessorsRefuseOtherKinds) {
  const Value text = "text", list = {1, 2};
  EXPECT_THROW((void)text.get<int>(), TypeError);
  EXPECT_THROW((void)list.get<bool>(), TypeError);
  EXPECT_THROW((void)list.get<std::string>(), TypeError);
  EXPECT_THROW((void)text.get<std::vector<int>>(), TypeError);
  EXPECT_THROW((void)list.at(2), TypeError);
  EXPECT_THROW((void)list.at("a"), TypeError);
  EXPECT_THROW((void)list.items(), TypeError);
  EXPECT_THROW(Value(1).push_back(2), TypeError);
  EXPECT_EQ(list.get<std::vector<int>>(), (std::vector{1, 2}));
}

TEST(Json, ValuesCompareByContent) {
  EXPECT_EQ(Value(1), Value(1u));
  EXPECT_EQ(Value(1), Value(1.0));
  EXPECT_NE(Value(-1), Value(std::numeric_limits<std::uint64_t>::max()));
  EXPECT_LT(Value(-1), Value(std::numeric_limits<std::uint64_t>::max()));
  EXPECT_LT(Value(2), 2.5);
  EXPECT_NE(Value(std::nan("")), Value(std::nan("")));
  EXPECT_NE(Value("1"), Value(1));
  EXPECT_NE(Value(true), Value(1));
  EXPECT_EQ((Value{{"a", 1}, {"b", 2}}), (Value{{"b", 2}, {"a", 1}}));
  EXPECT_NE((Value{{"a", 1}, {"b", 2}}), (Value{{"a", 1}, {"c", 2}}));
  EXPECT_FALSE(Value("a") < Value(1) || Value("a") > Value(1));
}

TEST(Json, PointersNameValues) {
  Value value = {{"a", {{"b/c", {1, 2}}, {"~", 3}, {"", 4}}}};
  EXPECT_EQ(*value.find_pointer(""), value);
  EXPECT_EQ(*value.find_pointer("/a/b~1c/1"), 2);
  EXPECT_EQ(*value.find_pointer("/a/~0"), 3);
  EXPECT_EQ(*value.find_pointer("/a/"), 4);
  for (const char* missing : {"a", "/b", "/a/b~1c/2", "/a/b~1c/01", "/a/b~1c/x", "/a/~0/x"})
    EXPECT_EQ(value.find_pointer(missing), nullptr) << missing;
}

TEST(Json, CopiesAreTheirOwn) {
  Value first = {{"a", {1, 2}}};
  const Value second = first;
  first["a"].push_back(3);
  first["a"][0] = first;  // a value may become part of itself
  EXPECT_EQ(second.dump(), R"({"a":[1,2]})");
  EXPECT_EQ(first.dump(), R"({"a":[{"a":[1,2,3]},2,3]})");
  std::ostringstream out;
  out << second;
  EXPECT_EQ(out.str(), second.dump());
}

}  // namespace
}  // namespace sightline::json::json_test
