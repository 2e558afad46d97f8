// Search as you type, against plain loops and std::regex.
#include "sightline/apps/view/name_search.h"

#include <algorithm>
#include <regex>

#include <gtest/gtest.h>

#include "sightline/core/internal/ascii_case.h"
#include "sightline/importers/import.h"
#include "sightline/tests/view/random_scene.h"

namespace sightline::tests::name_search_test {
namespace {

using apps::NameIndex;
using apps::NameMatches;
using core::NodeId;
using core::Scene;
using Nodes = std::vector<NodeId>;

constexpr std::size_t kAll = ~std::size_t(0);

// --- random texts ----------------------------------------------------------------------------------------------------

/// Few letters, so that texts repeat and occur in one another.
std::string random_text(Random& random, std::string_view letters, std::size_t longest) {
  std::string text(random() % (longest + 1), ' ');
  for (char& c : text) c = letters[random() % letters.size()];
  return text;
}

using namespace std::string_view_literals;
constexpr std::string_view kBytes = "abABkK:1-\xC3\xA4\xFF\0\n"sv, kAscii = "abABxX1-."sv;
const char* const kKeys[] = {"Type", "TYPE", ":spec", "line:no", "k", "a"};

void name_nodes(Scene& scene, Random& random, std::string_view letters) {
  for (const NodeId node : nodes_of(scene)) {
    const std::size_t longest = random() % 50 == 0 ? 5000 : random() % 3 == 0 ? 2 : 12;
    scene.set_name(node, random_text(random, letters, longest));
    for (auto n = random() % 3; n > 0; --n)
      scene.set_attribute(node, kKeys[random() % std::size(kKeys)], random_text(random, letters, longest));
  }
}

/// A part of some text of the scene, in random case, or random letters.
std::string random_query(const Scene& scene, const Nodes& nodes, Random& random) {
  const NodeId node = nodes[random() % nodes.size()];
  const core::Scene::Attributes& attributes = scene.attributes(node);
  std::string text(scene.name(node));
  if (!attributes.empty() && random() % 2 == 0) text = attributes[random() % attributes.size()].second;
  if (random() % 8 == 0) text = random_text(random, kBytes, 6);
  const std::size_t first = random() % (text.size() + 1);
  text = text.substr(first, random() % 4 == 0 ? text.npos : random() % 8);
  for (char& c : text)
    if (random() % 2 == 0 && c >= 'a' && c <= 'z') c = char(c - 'a' + 'A');
  return random() % 3 == 0 ? std::string(kKeys[random() % std::size(kKeys)]) + ":" + text : text;
}

// --- the twin --------------------------------------------------------------------------------------------------------

bool holds(std::string_view text, std::string_view part) {
  const std::string in = core::lower_case(text);
  return in.find(core::lower_case(part)) != in.npos;
}

/// Nodes whose values of the key, or without a key whose name or any value, hold the text.
Nodes holding(const Scene& scene, std::string_view key, std::string_view text) {
  Nodes found;
  for (const NodeId node : nodes_of(scene)) {
    bool any = key.empty() && holds(scene.name(node), text);
    for (const auto& [other, value] : scene.attributes(node))
      any = any || ((key.empty() || core::same_but_for_case(other, key)) && holds(value, text));
    if (any) found.push_back(node);
  }
  return found;
}

Nodes slowly_found(const Scene& scene, std::string_view query) {
  for (std::size_t colon = query.size(); colon-- > 1;)
    if (query[colon] == ':' && !holding(scene, query.substr(0, colon), "").empty())
      return holding(scene, query.substr(0, colon), query.substr(colon + 1));
  return holding(scene, "", query);
}

void expect_found(const NameIndex& index, const std::string& query, bool regular_expression, const Nodes& expected) {
  SCOPED_TRACE("query " + testing::PrintToString(query.substr(0, 60)));
  const auto all = index.find({query, regular_expression}, kAll);
  ASSERT_TRUE(all) << all.error().message;
  EXPECT_EQ(all->nodes, expected);
  EXPECT_EQ(all->count, expected.size());
  const auto some = index.find({query, regular_expression}, 3);
  ASSERT_TRUE(some) << some.error().message;
  EXPECT_EQ(some->count, expected.size());
  EXPECT_EQ(some->nodes, Nodes(expected.begin(), expected.begin() + std::min<std::ptrdiff_t>(3, expected.size())));
}

TEST(NameSearch, FindsWhatHoldsTheText) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    Scene scene;
    grow(scene, random, seed == 0 ? 20'000 : random() % 400);
    name_nodes(scene, random, kBytes);
    const NameIndex index(scene);
    const Nodes nodes = nodes_of(scene);
    EXPECT_EQ(index.node_count(), nodes.size());
    for (int i = 0; i < (seed == 0 ? 20 : 60); ++i) {
      const std::string query = random_query(scene, nodes, random);
      expect_found(index, query, false, slowly_found(scene, query));
      if (HasFailure()) return;
    }
  }
}

TEST(NameSearch, OfNoTextFindsAllAndOfAKeyAllThatHaveIt) {
  Scene scene;
  const NodeId pipe = scene.add_node(scene.root(), "/PIPE"), other = scene.add_node(scene.root());
  scene.set_attribute(pipe, "Type", "");
  const NameIndex index(scene);
  expect_found(index, "", false, {scene.root(), pipe, other});
  expect_found(index, "tYPE:", false, {pipe});
  expect_found(index, ":", false, {});
  expect_found(NameIndex(), "", false, {});
  expect_found(NameIndex(), "a", false, {});
}

TEST(NameSearch, FindsLongTextsWithinLongNames) {
  Scene scene;
  std::string name(1'000'000, 'a');
  const NodeId without = scene.add_node(scene.root(), name);
  name[700'000] = 'b';
  const NodeId with = scene.add_node(scene.root(), name);
  const NodeId after = scene.add_node(scene.root(), "after");
  const NameIndex index(scene);
  expect_found(index, "b" + std::string(200'000, 'A'), false, {with});
  expect_found(index, "b" + std::string(300'000, 'A'), false, {});
  expect_found(index, name, false, {with});
  expect_found(index, name + "a", false, {});
  expect_found(index, "A", false, {without, with, after});
}

TEST(NameSearch, KeepsTheNamesThatItCopied) {
  Scene scene;
  const NodeId node = scene.add_node(scene.root(), "old");
  const NameIndex index(scene);
  scene.set_name(node, "new");
  expect_found(index, "old", false, {node});
  expect_found(NameIndex(scene), "old", false, {});
}

TEST(NameSearch, StopsWhenAsked) {
  Scene scene;
  scene.add_node(scene.root(), "pipe");
  std::stop_source stop;
  stop.request_stop();
  const auto found = NameIndex(scene).find({"pipe"}, kAll, stop.get_token());
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().message, importers::kCancelled);
}

// --- regular expressions ---------------------------------------------------------------------------------------------

#if SIGHTLINE_HAS_PCRE2

Nodes slowly_matched(const Scene& scene, const std::string& pattern) {
  const std::regex regex(pattern, std::regex::icase);
  Nodes matched;
  for (const NodeId node : nodes_of(scene)) {
    const std::string_view name = scene.name(node);
    bool matches = std::regex_search(name.begin(), name.end(), regex);
    for (const auto& [key, value] : scene.attributes(node)) matches = matches || std::regex_search(value, regex);
    if (matches) matched.push_back(node);
  }
  return matched;
}

/// A few atoms, some repeated or optional.
std::string random_pattern(Random& random) {
  const char* const atoms[] = {"a", "B", "x", "1", "-", "\\.", ".", "[ab]", "[^a-b]", "\\d", "\\w", "(ab|1)", "(?:x-)"};
  const char* const repeats[] = {"", "", "", "?", "*", "+", "{2}"};
  std::string pattern = random() % 4 == 0 ? "^" : "";
  for (auto n = 1 + random() % 4; n > 0; --n)
    pattern += std::string(atoms[random() % std::size(atoms)]) + repeats[random() % std::size(repeats)];
  return pattern + (random() % 4 == 0 ? "$" : random() % 8 == 0 ? "|^$" : "");
}

TEST(NameSearch, MatchesRegularExpressionsAsTheStandardLibraryDoes) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    Scene scene;
    grow(scene, random, random() % 300);
    for (const NodeId node : nodes_of(scene)) {
      scene.set_name(node, random_text(random, kAscii, 10));
      if (random() % 3 == 0) scene.set_attribute(node, "Type", random_text(random, kAscii, 10));
    }
    const NameIndex index(scene);
    for (int i = 0; i < 40; ++i) {
      const std::string pattern = random_pattern(random);
      expect_found(index, pattern, true, slowly_matched(scene, pattern));
      if (HasFailure()) return;
    }
  }
}

TEST(NameSearch, MatchesRegularExpressionsOfOneAttribute) {
  Scene scene;
  const NodeId valve = scene.add_node(scene.root(), "VALVE-1"), pipe = scene.add_node(scene.root(), "PIPE-2");
  scene.set_attribute(valve, "Type", "VALV");
  scene.set_attribute(pipe, "Type", "PIPE");
  const NameIndex index(scene);
  expect_found(index, "type:^(valv|elbo)$", true, {valve});
  expect_found(index, "(?:valve|pipe)-\\d", true, {valve, pipe});
}

TEST(NameSearch, MatchesCharactersOfUtf8AndPassesOverOtherBytes) {
  Scene scene;
  const NodeId utf8 = scene.add_node(scene.root(), "M\u00fcller"), latin1 = scene.add_node(scene.root(), "M\xfcller");
  const NameIndex index(scene);
  expect_found(index, "^m.ller$", true, {utf8});
  expect_found(index, "LLER", true, {utf8, latin1});
}

TEST(NameSearch, SaysWhereARegularExpressionIsWrong) {
  Scene scene;
  const NameIndex index(scene);
  const std::pair<const char*, const char*> cases[] = {
      {"pipe(", "after byte 5: missing closing parenthesis"},
      {"a[b", "after byte 3: missing terminating ]"},
      {"*", "after byte 0: quantifier does not follow"},
      {"\xff", "UTF-8"},
  };
  for (const auto& [pattern, expected] : cases) {
    const auto found = index.find({pattern, true}, kAll);
    ASSERT_FALSE(found) << pattern;
    EXPECT_EQ(found.error().message.find("regular expression, after byte "), 0u) << found.error().message;
    EXPECT_NE(found.error().message.find(expected), std::string::npos) << found.error().message;
  }
}

TEST(NameSearch, GivesUpOnRegularExpressionsThatTakeYears) {
  Scene scene;
  scene.add_node(scene.root(), std::string(1000, 'a') + "!");
  const auto found = NameIndex(scene).find({"(a+)+$", true}, kAll);
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find("too many steps"), std::string::npos) << found.error().message;
  EXPECT_LT(found.error().message.size(), 200u);
}

TEST(NameSearch, MatchesLongNamesWithoutDeepStacks) {
  Scene scene;
  const NodeId node = scene.add_node(scene.root(), std::string(200'000, 'a') + "b");
  expect_found(NameIndex(scene), "^(a|c)*b$", true, {node});
}

#else

TEST(NameSearch, SaysThatThereAreNoRegularExpressions) {
  Scene scene;
  const auto found = NameIndex(scene).find({"a", true}, kAll);
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find("PCRE2"), std::string::npos);
}

#endif

}  // namespace
}  // namespace sightline::tests::name_search_test
