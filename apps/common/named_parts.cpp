#include "sightline/apps/common/named_parts.h"

#include <algorithm>
#include <cstdio>

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

core::Expected<std::vector<core::NodeId>> named_nodes(const core::Scene& scene, const std::vector<std::string>& texts,
                                                      bool quiet) {
  std::vector<core::NodeId> nodes;
  for (const std::string& text : texts) {
    const auto found = find_parts(scene, {{"", text}});
    if (!found) return tl::unexpected(found.error());
    if (found->nodes.size() > 1 && !quiet)
      std::fprintf(stderr, "note: %s\n", words_of_parts(scene, text, *found).c_str());
    nodes.insert(nodes.end(), found->nodes.begin(), found->nodes.end());
  }
  return nodes;
}

std::vector<bool> items_below(const core::Scene& scene, const std::vector<core::NodeId>& nodes) {
  std::vector<bool> below(scene.item_slots());
  for (const core::NodeId top : nodes)
    for (const core::ItemId item : items_below(scene, top)) below[to_index(item)] = true;
  return below;
}

}  // namespace sightline::apps
