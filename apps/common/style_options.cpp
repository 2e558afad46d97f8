#include "sightline/apps/common/style_options.h"

#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/named_parts.h"

namespace sightline::apps {
namespace {

using core::ItemId;

constexpr core::vec3 kHighlight{1.0f, 0.45f, 0.05f};
constexpr float kFade = 0.3f;

/// Items that the texts name, or all others.
core::Expected<std::vector<ItemId>> items_of(const core::Scene& scene, const std::vector<std::string>& texts,
                                             bool quiet, bool others = false) {
  const auto named = items_named_by(scene, texts, quiet);
  if (!named) return tl::unexpected(named.error());
  std::vector<ItemId> items;
  for (ItemId item{0}; to_index(item) < named->size(); ++item)
    if ((*named)[to_index(item)] != others && scene.contains_item(item)) items.push_back(item);
  return items;
}

/// Gives items a style in which each has the colour of its group.
core::Expected<void> give_coloured(const std::vector<ItemId>& items, engine::ItemStyle style,
                                   const query::Colouring& colouring, engine::Engine& engine) {
  std::vector<std::vector<ItemId>> of_group(colouring.groups.size());
  for (const ItemId item : items) of_group[colouring.of_item[to_index(item)]].push_back(item);
  for (std::size_t i = 0; i < of_group.size(); ++i) {
    style.colour = colouring.groups[i].colour;
    if (auto done = engine.set_override(of_group[i], style); !done) return done;
  }
  return {};
}

}  // namespace

Option add_colour_option(CommandLine& line, std::string& key) {
  return line.add("--colour-by", key, "Colour items by an attribute, or by @kind, @material, @file, …").metavar("KEY");
}

void add_style_options(CommandLine& line, StyleOptions& options) {
  const auto add = [&](const char* name, std::vector<std::string>& texts, const std::string& help) {
    return add_part_option(line, name, texts, help);
  };
  add("--isolate", options.isolate, "Show parts alone: " + kPartForms);
  add("--hide", options.hide, "Hide parts");
  add("--highlight", options.highlight, "Show parts in orange, outlined");
  add_colour_option(line, options.colour_by);
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

core::Expected<query::Colouring> apply_colours(const std::string& key, const core::Scene& scene,
                                               engine::Engine& engine) {
  if (key.empty()) return query::Colouring{};
  auto colouring = query::colour_by(scene, key);
  if (!colouring) return colouring;
  const auto done = give_coloured(*items_of(scene, {}, true, true), {}, *colouring, engine);
  return done ? std::move(colouring) : tl::unexpected(done.error());
}

core::Expected<query::Colouring> apply_styles(const StyleOptions& options, const core::Scene& scene,
                                              engine::Engine& engine) {
  auto colouring = apply_colours(options.colour_by, scene, engine);
  if (!colouring) return colouring;
  const auto with = [&](const std::vector<std::string>& texts, bool others, const auto& work) -> core::Expected<void> {
    if (texts.empty()) return {};
    const auto items = items_of(scene, texts, options.quiet, others);
    return items ? work(*items) : core::Expected<void>(tl::unexpected(items.error()));
  };
  const auto hide = [&](const std::vector<ItemId>& items) { return engine.hide(items); };
  const auto give = [&](const engine::ItemStyle& style) {
    return [&, style](const std::vector<ItemId>& items) {
      const bool coloured = !style.colour && !colouring->groups.empty();
      return coloured ? give_coloured(items, style, *colouring, engine) : engine.set_override(items, style);
    };
  };
  core::Expected<void> done = with(options.isolate, true, hide);
  if (done) done = with(options.hide, false, hide);
  if (done) done = with(options.ghost_others, true, give({.ghost = true}));
  if (done) done = with(options.ghost, false, give({.ghost = true}));
  if (done) done = with(options.fade, false, give({.alpha = kFade}));
  if (done) done = with(options.highlight, false, give({.colour = kHighlight, .outline = true}));
  return done ? colouring : tl::unexpected(done.error());
}

}  // namespace sightline::apps
