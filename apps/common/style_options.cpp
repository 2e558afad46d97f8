#include "sightline/apps/common/style_options.h"

#include <map>

#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/tree_walk.h"

namespace sightline::apps {
namespace {

using core::ItemId;

constexpr core::vec3 kHighlight{1.0f, 0.45f, 0.05f};
constexpr float kFade = 0.3f;

/// Nodes for which one of the conditions holds.
core::Expected<std::vector<core::NodeId>> find(const core::Scene& scene, const std::vector<std::string>& texts) {
  std::vector<core::NodeId> nodes;
  for (const std::string& text : texts) {
    const core::NodeCondition condition = parse_condition(text);
    const auto found = core::find_nodes(scene, scene.root(), {&condition, 1});
    if (found.empty()) return core::fail("no node fits \"" + text + "\"");
    nodes.insert(nodes.end(), found.begin(), found.end());
  }
  return nodes;
}

/// Items below the nodes, or all others.
core::Expected<std::vector<ItemId>> items_of(const core::Scene& scene, const std::vector<std::string>& texts,
                                             bool others = false) {
  const auto below = items_below(scene, texts);
  if (!below) return tl::unexpected(below.error());
  std::vector<ItemId> items;
  for (ItemId item{0}; to_index(item) < below->size(); ++item)
    if ((*below)[to_index(item)] != others && scene.contains_item(item)) items.push_back(item);
  return items;
}

}  // namespace

core::Expected<std::vector<bool>> items_below(const core::Scene& scene, const std::vector<std::string>& conditions) {
  const auto nodes = find(scene, conditions);
  if (!nodes) return tl::unexpected(nodes.error());
  std::vector<bool> below(scene.item_slots());
  for (const core::NodeId top : *nodes)
    for (const ItemId item : items_below(scene, top)) below[to_index(item)] = true;
  return below;
}

core::NodeCondition parse_condition(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return {"", text};
  return {text.substr(0, equals), text.substr(equals + 1)};
}

void add_style_options(CommandLine& line, StyleOptions& options) {
  const auto add = [&](const char* name, std::vector<std::string>& texts, const char* help) {
    return line.add(name, texts, help).metavar("PART").one_value_each();
  };
  add("--isolate", options.isolate, "Show parts alone: those with this text in a name or attribute, or KEY=TEXT");
  add("--hide", options.hide, "Hide parts");
  add("--highlight", options.highlight, "Show parts in orange, outlined");
  add("--ghost-others", options.ghost_others, "Show all but these parts as faint shells").advanced();
  add("--ghost", options.ghost, "Show parts as faint shells that hide nothing").advanced();
  add("--fade", options.fade, "Show parts transparent").advanced();
  line.add_choice(
          "--transparency", options.transparency,
          {{"dither", engine::Transparency::kDither}, {"blended", engine::Transparency::kBlended}},
          "dither: a pattern of opaque pixels; blended: without pattern and without sorting, with a small error")
      .shows_default()
      .advanced();
}

core::Expected<void> apply_styles(const StyleOptions& options, const core::Scene& scene, engine::Engine& engine) {
  const auto give = [&](const std::vector<std::string>& texts, const engine::ItemStyle& style,
                        bool others = false) -> core::Expected<void> {
    if (texts.empty()) return {};
    const auto items = items_of(scene, texts, others);
    return items ? engine.set_override(*items, style) : core::Expected<void>(tl::unexpected(items.error()));
  };
  if (!options.isolate.empty()) {
    const auto nodes = find(scene, options.isolate);
    if (!nodes) return tl::unexpected(nodes.error());
    if (auto done = engine.isolate(*nodes); !done) return done;
  }
  if (!options.hide.empty()) {
    const auto items = items_of(scene, options.hide);
    if (!items) return tl::unexpected(items.error());
    if (auto done = engine.hide(*items); !done) return done;
  }
  auto done = give(options.ghost_others, {.ghost = true}, true);
  if (done) done = give(options.ghost, {.ghost = true});
  if (done) done = give(options.fade, {.alpha = kFade});
  if (done) done = give(options.highlight, {.colour = kHighlight, .outline = true});
  return done;
}

}  // namespace sightline::apps
