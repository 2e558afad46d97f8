// Search for nodes by what users call them: one rule for all tools and languages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"

namespace sightline::core {

/// Names nodes. Without a key, `text` is looked for in steps, and the first step that finds a node decides:
///
/// 1. Paths: Scene::path(), or its end that begins with any node above.
/// 2. Names of nodes.
/// 3. Values of attributes; of one attribute where the text is "KEY=TEXT", whose key "Name" means the node's name, too.
/// 4. Whole words of names and values: the text with neither a letter nor a digit before or after it.
///
/// A pattern has step 5 instead of 4. With `*` for any characters, or `?` for one, it must fit a name or value as a
/// whole, or the end of a path if it has a `/` within; "re:" begins a regular expression (those of Perl without
/// look-around and references), which must match any part of a name or value. "KEY=TEXT" takes patterns, too.
///
/// Letters are compared exactly first, then ASCII letters regardless of case; words and patterns only so. Slashes that
/// a name or a text begins with may be missing from the other.
struct NodeCondition {
  std::string key;   ///< "KEY=TEXT" in two parts; empty: the steps above
  std::string text;  ///< empty: any node, or any that has the attribute
};

/// The step that found nodes.
enum class NodeMatch : std::uint8_t { kPath, kName, kValue, kWords, kPattern };
/// "by path", "by name", "by value", "by whole words", "by pattern".
SIGHTLINE_API std::string_view words_of(NodeMatch match);

struct FoundNodes {
  std::vector<NodeId> nodes;  ///< parents first
  NodeMatch match = NodeMatch::kPath;
};

/// The nodes of the subtree that fulfil all conditions, by the earliest step that all conditions allow any node; all
/// nodes where there is no condition. Looks at every node, name and attribute: some 100 ns each. Fails where a regular
/// expression is none.
SIGHTLINE_API Expected<FoundNodes> find_nodes(const Scene& scene, NodeId top,
                                              std::span<const NodeCondition> conditions);

/// Names of the subtree, or values of the attribute that the condition names, that are like a text that nothing fits:
/// those that hold it first, then those that differ by the fewest letters, the shortest first. At most `limit`; none
/// are like nothing.
SIGHTLINE_API std::vector<std::string> similar_names(const Scene& scene, NodeId top, const NodeCondition& condition,
                                                     std::size_t limit);

/// Whether a text without a key is a pattern.
SIGHTLINE_API bool is_pattern(std::string_view text);

}  // namespace sightline::core
