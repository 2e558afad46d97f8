#include "sightline/apps/common/style_options.h"

#include <map>

#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/named_parts.h"

namespace sightline::apps {
namespace {

using core::ItemId;

constexpr core::vec3 kHighlight{1.0f, 0.45f, 0.05f};
constexpr float kFade = 0.3f;

/// Items below the parts, or all others.
core::Expected<std::vector<ItemId>> items_of(const core::Scene& scene, const std::vector<std::string>& texts,
                                             bool quiet, bool others = false) {
  const auto nodes = named_nodes(scene, texts, quiet);
  if (!nodes) return tl::unexpected(nodes.error());
  const std::vector<bool> below = items_below(scene, *nodes);
  std::vector<ItemId> items;
  for (ItemId item{0}; to_index(item) < below.size(); ++item)
    if (below[to_index(item)] != others && scene.contains_item(item)) items.push_back(item);
  return items;
}

}  // namespace

void add_style_options(CommandLine& line, StyleOptions& options) {
  const auto add = [&](const char* name, std::vector<std::string>& texts, const std::string& help) {
    return add_part_option(line, name, texts, help);
  };
  add("--isolate", options.isolate, "Show parts alone: " + kPartForms);
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
    const auto items = items_of(scene, texts, options.quiet, others);
    return items ? engine.set_override(*items, style) : core::Expected<void>(tl::unexpected(items.error()));
  };
  if (!options.isolate.empty()) {
    const auto nodes = named_nodes(scene, options.isolate, options.quiet);
    if (!nodes) return tl::unexpected(nodes.error());
    if (auto done = engine.isolate(*nodes); !done) return done;
  }
  if (!options.hide.empty()) {
    const auto items = items_of(scene, options.hide, options.quiet);
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
