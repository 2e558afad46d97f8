// Parts of a model that users name, by the rule of core/find_nodes.h, and what is said where a name is not clear.
#pragma once

#include <string>
#include <vector>

#include "sightline/apps/common/command_line.h"
#include "sightline/core/find_nodes.h"

namespace sightline::apps {

/// A text that may name parts: not empty, and no regular expression that is none. For options, before a model is read.
core::Expected<std::string> parse_part(const std::string& text);

/// How a text names parts, for the help of options.
inline const std::string kPartForms =
    "a path, a name, a value or KEY=VALUE, whole words, a pattern with * or ?, re:EXPRESSION, or conditions";

/// An option that takes one text that names parts, each time it is given.
Option add_part_option(CommandLine& line, const std::string& name, std::vector<std::string>& texts,
                       const std::string& help);

/// The nodes that fulfil all conditions. Fails where there are none, with names that are like the text.
core::Expected<core::FoundNodes> find_parts(const core::Scene& scene, const std::vector<core::NodeCondition>& wanted);

/// One line that counts parts, says what about them the text fits, and has the first few paths.
std::string words_of_parts(const core::Scene& scene, const std::string& text, const core::FoundNodes& found);

/// Items that a text names: those of the parts that it names or, where there are none and it is a query
/// (analysis/query/conditions.h), those for which that holds. Fails where there is no item.
struct NamedItems {
  std::vector<core::ItemId> items;  ///< in rising order
  std::string words;                ///< one line that counts them
  bool clear = false;               ///< the text is of one part, or a query
};
core::Expected<NamedItems> named_items(const core::Scene& scene, const std::string& text);
/// So of parts that were found for a text.
core::Expected<NamedItems> items_of_parts(const core::Scene& scene, const std::string& text,
                                          const core::FoundNodes& found);

/// By ItemId, whether any of the texts names the item. Fails where one names none. Where one names several parts, that
/// is a line on stderr unless `quiet`.
core::Expected<std::vector<bool>> items_named_by(const core::Scene& scene, const std::vector<std::string>& texts,
                                                 bool quiet);

}  // namespace sightline::apps
