// Search as you type: which nodes hold a text in their name or attributes.
//
// The index is a copy of all names and attributes. Equal texts of one attribute are kept once, in lower case, one after
// the other. A search reads these bytes from end to end on all processors, and sets a bit per node that has a text
// that was found. So its time is that of the bytes, plus a few nanoseconds per node found.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "sightline/apps/view/bit_set.h"
#include "sightline/core/error.h"
#include "sightline/core/find_nodes.h"
#include "sightline/core/scene.h"

namespace sightline::apps {

/// What a user types: a text that must occur in a node's name or the value of any attribute. "KEY:TEXT" looks at the
/// values of one attribute only, if KEY is not empty and some node has such an attribute; else it is a text like any
/// other. Of several keys that fit, the longest counts. An empty TEXT occurs everywhere. ASCII letters match regardless
/// of case, all other bytes exactly.
struct NameQuery {
  std::string text;
  bool regular_expression = false;  ///< TEXT is one (regular_expression.h)
};

struct NameMatches {
  std::vector<core::NodeId> nodes;  ///< the first ones in tree order
  std::size_t count = 0;            ///< of all
};

class NameIndex {
 public:
  NameIndex() = default;  ///< of no nodes
  /// Copies names and attributes. Later edits of the scene do not change the index.
  explicit NameIndex(const core::Scene& scene);

  /// The nodes that match, at most `limit`. Several threads may search at a time. Fails when the regular expression is
  /// none or takes too many steps, and, with importers::kCancelled as its message, some milliseconds after `stop` is
  /// requested.
  core::Expected<NameMatches> find(const NameQuery& query, std::size_t limit, std::stop_token stop = {}) const;

  /// A query "KEY:TEXT" as a condition on one attribute; none where it is a text like any other.
  std::optional<core::NodeCondition> condition_of(std::string_view query) const;

  std::size_t node_count() const { return nodes_.size(); }
  std::size_t memory_bytes() const;

 private:
  /// The distinct texts of names, or of one attribute: text i is the bytes from start[i] to below start[i + 1], and
  /// occurs at the nodes from first_node[i] to below first_node[i + 1] in `nodes`, by their numbers in tree order.
  struct Field {
    std::string bytes;
    std::vector<std::size_t> start{0};
    std::vector<std::uint32_t> first_node, nodes;
    std::size_t size() const { return start.size() - 1; }
    std::string_view text(std::size_t i) const {
      return std::string_view(bytes).substr(start[i], start[i + 1] - start[i]);
    }
  };
  class FieldBuilder;
  /// Some texts of a field: the share of work that a thread takes at a time.
  struct Chunk {
    std::uint32_t field, first, last;
  };
  struct Needle;
  struct Target {
    std::size_t first_chunk, last_chunk;
    std::string_view text;
  };

  Target target_of(std::string_view query) const;
  static void mark(const Field& field, std::size_t text, BitSet& found);
  Needle needle(std::string text) const;
  static void scan(const Field& field, const Chunk& chunk, const Needle& needle, BitSet& found);
  template <class MakeScan>
  core::Expected<BitSet> scan_all(const Target& target, const std::stop_token& stop, const MakeScan& make_scan) const;

  std::vector<core::NodeId> nodes_;                              // in tree order
  std::vector<Field> fields_;                                    // the first one is of names
  std::vector<Chunk> chunks_;                                    // in the order of the fields
  std::vector<std::size_t> first_chunk_;                         // of each field, and the end
  std::unordered_map<std::string, std::uint32_t> field_of_key_;  // by lower-case key
  std::array<std::size_t, 256> frequency_{};                     // of bytes in all texts
};

}  // namespace sightline::apps
