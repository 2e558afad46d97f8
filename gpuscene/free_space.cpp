#include "sightline/gpuscene/internal/free_space.h"

#include <iterator>

namespace sightline::gpuscene {

std::uint32_t FreeSpace::take(std::uint32_t count) {
  if (count == 0) return end_;
  used_ += count;
  const auto fits = by_count_.lower_bound({count, 0});
  if (fits == by_count_.end()) return std::exchange(end_, end_ + count);
  const auto [size, first] = *fits;
  remove(gaps_.find(first));
  if (size > count) {
    gaps_.emplace(first + count, size - count);
    by_count_.emplace(size - count, first + count);
  }
  return first;
}

void FreeSpace::give_back(std::uint32_t first, std::uint32_t count) {
  if (count == 0) return;
  used_ -= count;
  auto next = gaps_.lower_bound(first);
  if (next != gaps_.end() && next->first == first + count) {
    count += next->second;
    const auto after = std::next(next);
    remove(next);
    next = after;
  }
  if (next != gaps_.begin()) {
    const auto before = std::prev(next);
    if (before->first + before->second == first) {
      first = before->first;
      count += before->second;
      remove(before);
    }
  }
  if (first + count == end_) {
    end_ = first;
    return;
  }
  gaps_.emplace(first, count);
  by_count_.emplace(count, first);
}

void FreeSpace::remove(std::map<std::uint32_t, std::uint32_t>::iterator gap) {
  by_count_.erase({gap->second, gap->first});
  gaps_.erase(gap);
}

}  // namespace sightline::gpuscene
