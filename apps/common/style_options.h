// Options that show parts of a model otherwise than the model says.
#pragma once

#include <string>
#include <vector>

#include "sightline/analysis/query/colouring.h"
#include "sightline/engine/engine.h"

namespace sightline::apps {

class CommandLine;
class Option;

struct StyleOptions {
  /// Each names parts (named_parts.h): those that one of its texts names.
  std::vector<std::string> hide, isolate, ghost, ghost_others, fade, highlight;
  std::string colour_by;  ///< a key of query::colour_by(); empty: the scene's own colours
  engine::Transparency transparency = engine::Transparency::kDither;
  bool quiet = false;  ///< apply_styles() prints nothing
};

/// --colour-by KEY
Option add_colour_option(CommandLine& line, std::string& key);
/// This and --hide, --isolate, --ghost, --ghost-others, --fade and --highlight PART, --transparency
/// dither|blended
void add_style_options(CommandLine& line, StyleOptions& options);

/// Gives items the colours of query::colour_by(), which say what they mean: no groups where the key is empty.
core::Expected<query::Colouring> apply_colours(const std::string& key, const core::Scene& scene,
                                               engine::Engine& engine);

/// Overrides items of the scene, which must be committed. Fails where a text names no part; says on stderr where one
/// names several. Returns what the colours mean: no groups where --colour-by was not given.
core::Expected<query::Colouring> apply_styles(const StyleOptions& options, const core::Scene& scene,
                                              engine::Engine& engine);

}  // namespace sightline::apps
