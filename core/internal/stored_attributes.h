// Attributes of nodes as the scene cache stores them, read node by node when somebody asks.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/large_array.h"

namespace sightline::core {

/// Flat and read-only. The text of nodes[i] is text[ends[i - 1] … ends[i] - 1]: for each attribute the lengths of key
/// and value as 32-bit numbers, the key, the value. Any content is safe to read: what does not fit is left out.
struct SIGHTLINE_API StoredAttributes {
  using List = std::vector<std::pair<std::string, std::string>>;
  LargeArray<std::uint32_t> nodes;  ///< rising
  LargeArray<std::uint64_t> ends;
  LargeArray<char> text;

  /// Index in `nodes`, or nodes.size().
  std::size_t find(std::uint32_t node) const;
  List list(std::size_t index) const;
  /// `node` must lie above those added before.
  void add(std::uint32_t node, const List& list);
};

/// Keeps the part of stored attributes that has been read so far. Reads are safe from several threads.
class AttributeReader {
 public:
  explicit AttributeReader(std::shared_ptr<const StoredAttributes> stored) : stored_(std::move(stored)) {}

  const StoredAttributes& stored() const { return *stored_; }
  bool has(std::uint32_t node) const { return stored_->find(node) < stored_->nodes.size(); }
  /// Null when the node has none. The list stays where it is as long as the reader.
  const StoredAttributes::List* find(std::uint32_t node) const;

 private:
  std::shared_ptr<const StoredAttributes> stored_;
  mutable std::mutex mutex_;
  mutable std::unordered_map<std::uint32_t, StoredAttributes::List> read_;
};

}  // namespace sightline::core
