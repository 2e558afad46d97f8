// Internal: a visible set in parts, for several threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "sightline/core/internal/scratch.h"
#include "sightline/core/thread_pool.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/hierarchy.h"
#include "sightline/culling/frustum/internal/append_range.h"

namespace sightline::culling {

/// Keeps its memory from set to set.
class SetParts {
 public:
  /// Cuts a set into parts of about `size` slots: first its ranges, then its single slots, both in rising order.
  /// Within a range it cuts between groups of kLanes, so that groups are the same for any size.
  void split(const core::VisibleSet& set, std::uint32_t size = 8192) {
    count_ = 0;
    std::uint32_t left = 0;  // in the last part
    for (core::SlotRange rest : set.ranges) {
      while (rest.count > 0) {
        if (left == 0) begin_part(set), left = size;
        const std::uint32_t taken = std::min(rest.count, (left + kLanes - 1) / kLanes * kLanes);
        parts_[count_ - 1].ranges.push_back({rest.first, taken});
        rest = {rest.first + taken, rest.count - taken};
        left -= std::min(left, taken);
      }
    }
    of_ranges_ = count_;
    size = (size + kLanes - 1) / kLanes * kLanes;
    for (std::size_t first = 0; first < set.single_slots.size(); first += size) {
      begin_part(set);
      const auto begin = set.single_slots.begin() + std::ptrdiff_t(first);
      const std::size_t taken = std::min<std::size_t>(size, set.single_slots.size() - first);
      parts_[count_ - 1].single_slots.assign(begin, begin + std::ptrdiff_t(taken));
    }
    generation_ = set.generation;
  }

  std::uint32_t count() const { return std::uint32_t(count_); }
  /// Calls job(part, number of the part) for each part, on any of the threads; null: on this one.
  template <class Job>
  void for_each(core::ThreadPool* threads, const Job& job) {
    core::ThreadPool::run_on(threads, count(), [&](std::uint32_t i) { job(parts_[i], i); });
  }
  /// `beside`: see ThreadPool::run_at_once().
  template <class Job, class Beside>
  void for_each(core::ThreadPool& threads, const Job& job, const Beside& beside) {
    const auto of_part = [&](std::uint32_t i) { job(parts_[i], i); };
    threads.run_at_once(count(), of_part, beside);
  }
  core::VisibleSet& operator[](std::uint32_t part) { return parts_[part]; }
  const core::VisibleSet& operator[](std::uint32_t part) const { return parts_[part]; }

  /// Replaces `set` by what is left of the parts.
  void join(core::VisibleSet& set) {
    set.clear();
    set.generation = generation_;
    of_ranges_items_.clear();
    singles_.clear();
    for (std::size_t i = 0; i < count_; ++i) {
      const core::VisibleSet& part = parts_[i];
      for (const core::SlotRange& range : part.ranges) append_range(range.first, range.first + range.count, set.ranges);
      std::vector<core::Slot>& items = i < of_ranges_ ? of_ranges_items_ : singles_;
      items.insert(items.end(), part.single_slots.begin(), part.single_slots.end());
    }
    merge_slots(of_ranges_items_, singles_, set.single_slots);
  }

  std::size_t memory_bytes() const {
    std::size_t bytes = core::bytes_of(parts_, of_ranges_items_, singles_);
    for (const core::VisibleSet& part : parts_) bytes += core::bytes_of(part);
    return bytes;
  }

 private:
  void begin_part(const core::VisibleSet& set) {
    if (count_ == parts_.size()) parts_.emplace_back();
    parts_[count_].clear();
    parts_[count_++].generation = set.generation;
  }

  std::vector<core::VisibleSet> parts_;  // the first count_ of them; the others keep memory
  std::size_t count_ = 0, of_ranges_ = 0;
  std::uint64_t generation_ = 0;
  std::vector<core::Slot> of_ranges_items_, singles_;
};

struct FilterBuffers {
  SetParts parts;
  std::size_t memory_bytes() const { return core::bytes_of(parts); }
};

/// Replaces `out` by what filter(set, kept) keeps of `in`, in parts where there are threads: so many that no thread
/// waits long for another.
template <class Filter>
void filter_in_parts(const core::VisibleSet& in, core::VisibleSet& out, core::ThreadPool* threads,
                     const Filter& filter) {
  if (!threads || threads->size() == 1) return filter(in, out);
  const core::Scratch<FilterBuffers> scratch;
  SetParts& parts = scratch->parts;
  parts.split(in, std::uint32_t(std::clamp<std::size_t>(in.count() / std::size_t(4 * threads->size()), 512, 8192)));
  parts.for_each(threads, [&](core::VisibleSet& part, std::uint32_t) { filter(part, part); });
  parts.join(out);
}

}  // namespace sightline::culling
