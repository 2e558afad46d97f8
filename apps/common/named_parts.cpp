#include "sightline/apps/common/named_parts.h"

#include <algorithm>
#include <cstdio>

#include "sightline/analysis/query/conditions.h"
#include "sightline/apps/common/numbers.h"
#include "sightline/apps/common/tree_walk.h"

namespace sightline::apps {
namespace {

constexpr std::size_t kMostPaths = 3, kMostSimilar = 5;

std::string text_of(const core::NodeCondition& condition) {
  return condition.key.empty() ? condition.text : condition.key + "=" + condition.text;
}

/// Names the first condition that no node fulfils alone; where each has nodes, none of which fulfil all, the last.
core::Error nothing_found(const core::Scene& scene, const std::vector<core::NodeCondition>& wanted) {
  const core::NodeCondition* missing = nullptr;
  for (const core::NodeCondition& condition : wanted)
    if (const auto alone = core::find_nodes(scene, scene.root(), {&condition, 1}); alone && alone->nodes.empty())
      missing = missing ? missing : &condition;
  if (!missing) return {"no part fits \"" + text_of(wanted.back()) + "\" and the others"};
  std::string message = "no part fits \"" + text_of(*missing) + "\"";
  const std::vector<std::string> similar = core::similar_names(scene, scene.root(), *missing, kMostSimilar);
  for (std::size_t i = 0; i < similar.size(); ++i) message += (i == 0 ? "; similar names: " : ", ") + similar[i];
  return {message};
}

}  // namespace

core::Expected<std::string> parse_part(const std::string& text) {
  if (text.empty()) return core::fail("expected the name of a part, found \"\"");
  const core::Scene none;
  const core::NodeCondition condition{"", text};
  const auto found = core::find_nodes(none, none.root(), {&condition, 1});
  if (!found) return core::fail("\"" + text + "\": " + found.error().message);
  return text;
}

Option add_part_option(CommandLine& line, const std::string& name, std::vector<std::string>& texts,
                       const std::string& help) {
  return line.add(name, texts, help).metavar("PART").one_value_each().accepted_by(parse_part);
}

core::Expected<core::FoundNodes> find_parts(const core::Scene& scene, const std::vector<core::NodeCondition>& wanted) {
  auto found = core::find_nodes(scene, scene.root(), wanted);
  if (found && found->nodes.empty()) return tl::unexpected(nothing_found(scene, wanted));
  return found;
}

std::string words_of_parts(const core::Scene& scene, const std::string& text, const core::FoundNodes& found) {
  const std::size_t count = found.nodes.size(), shown = std::min(kMostPaths, count);
  std::string words = "\"" + text + "\": " + std::to_string(count) + (count == 1 ? " part " : " parts ");
  words += words_of(found.match);
  for (std::size_t i = 0; i < shown; ++i) words += (i == 0 ? ": " : ", ") + scene.path(found.nodes[i]);
  return words + (shown < count ? ", …" : "");
}

core::Expected<NamedItems> items_of_parts(const core::Scene& scene, const std::string& text,
                                          const core::FoundNodes& found) {
  NamedItems named{items_below(scene, found.nodes), words_of_parts(scene, text, found), found.nodes.size() == 1};
  if (named.items.empty()) return core::fail("there are no items below \"" + text + "\"");
  return named;
}

core::Expected<NamedItems> named_items(const core::Scene& scene, const std::string& text) {
  const auto found = find_parts(scene, {{"", text}});
  if (found) return items_of_parts(scene, text, *found);
  if (!query::is_query(text)) return tl::unexpected(found.error());
  auto items = query::find_items(scene, text);
  if (!items) return tl::unexpected(items.error());
  if (items->empty()) return core::fail("no item fits \"" + text + "\"");
  const std::string words =
      "\"" + text + "\": " + grouped(std::int64_t(items->size())) + (items->size() == 1 ? " item" : " items");
  return NamedItems{std::move(*items), words, true};
}

core::Expected<std::vector<bool>> items_named_by(const core::Scene& scene, const std::vector<std::string>& texts,
                                                 bool quiet) {
  std::vector<bool> marks(scene.item_slots());
  for (const std::string& text : texts) {
    const auto named = named_items(scene, text);
    if (!named) return tl::unexpected(named.error());
    if (!named->clear && !quiet) std::fprintf(stderr, "note: %s\n", named->words.c_str());
    for (const core::ItemId item : named->items) marks[to_index(item)] = true;
  }
  return marks;
}

}  // namespace sightline::apps
