// Ids that nothing has any more, and when they may be given out again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace sightline::core {

/// Commits have rising numbers. An id that a commit has removed rests until all subscribers have followed that commit:
/// until then what they know by that id is the former owner's. Id: ItemId, or the index of a mesh or material.
template <class Id>
class FreeIds {
 public:
  static constexpr std::uint64_t kAtOnce = 0;  // a commit that everybody has followed

  void remove(std::span<const Id> ids, std::uint64_t commit) {
    if (commit == kAtOnce)
      free_.insert(free_.end(), ids.begin(), ids.end());
    else if (!ids.empty())
      resting_.emplace_back(commit, std::vector<Id>(ids.begin(), ids.end()));
  }
  /// Frees what commits up to `followed` have removed. Returns whether that was anything.
  bool release(std::uint64_t followed) {
    const std::size_t before = free_.size();
    for (; !resting_.empty() && resting_.front().first <= followed; resting_.pop_front())
      free_.insert(free_.end(), resting_.front().second.begin(), resting_.front().second.end());
    return free_.size() > before;
  }
  std::optional<Id> take() {
    if (free_.empty()) return std::nullopt;
    const Id id = free_.back();
    free_.pop_back();
    return id;
  }
  /// Forgets ids from `end` on.
  void truncate(Id end) {
    std::erase_if(free_, [&](Id id) { return id >= end; });
    for (auto& [commit, ids] : resting_) std::erase_if(ids, [&](Id id) { return id >= end; });
  }
  std::size_t memory_bytes() const {
    std::size_t bytes = free_.capacity() * sizeof(Id);
    for (const auto& [commit, ids] : resting_) bytes += ids.capacity() * sizeof(Id);
    return bytes;
  }

 private:
  std::vector<Id> free_;
  std::deque<std::pair<std::uint64_t, std::vector<Id>>> resting_;  // by the commit that removed them
};

}  // namespace sightline::core
