// Options that show parts of a model otherwise than the model says.
#pragma once

#include <string>
#include <vector>

#include "sightline/core/find_nodes.h"
#include "sightline/engine/engine.h"

namespace sightline::apps {

class CommandLine;

/// "KEY=TEXT" or "TEXT".
core::NodeCondition parse_condition(const std::string& text);

/// By ItemId, whether an item lies below a node for which one of these conditions holds. Fails where one holds for
/// none.
core::Expected<std::vector<bool>> items_below(const core::Scene& scene, const std::vector<std::string>& conditions);

/// Each names nodes, by conditions that parse_condition() reads: those for which one of them holds.
struct StyleOptions {
  std::vector<std::string> hide, isolate, ghost, ghost_others, fade, highlight;
  engine::Transparency transparency = engine::Transparency::kDither;
};

/// --hide, --isolate, --ghost, --ghost-others, --fade and --highlight TEXT, --transparency dither|blended
void add_style_options(CommandLine& line, StyleOptions& options);

/// Overrides items of the scene, which must be committed. Fails where no node is found.
core::Expected<void> apply_styles(const StyleOptions& options, const core::Scene& scene, engine::Engine& engine);

}  // namespace sightline::apps
