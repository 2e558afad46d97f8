#include "sightline/culling/occlusion/internal/occlusion_passes.h"

#include <algorithm>
#include <bit>

#include "sightline/culling/frustum/internal/append_range.h"

namespace sightline::culling {
namespace {

constexpr std::uint32_t kShortestRange = 16;  // slots; fewer neighbours are single slots
constexpr int kMostPasses = 6;                // the last one has all that is open then
constexpr std::size_t kFew = 2048;            // slots that are not worth another pass

/// Appends slots first … end - 1, which lie behind all that `set` has in ranges.
void append(core::VisibleSet& set, std::vector<core::Slot>& singles, core::Slot first, core::Slot end) {
  if (end - first >= kShortestRange)
    set.ranges.push_back({first, end - first});
  else
    for (core::Slot s = first; s < end; ++s) singles.push_back(s);
}

}  // namespace

void OcclusionPasses::begin(const core::VisibleSet& candidates, SlotBits lines, const Hierarchy* hierarchy,
                            core::ThreadPool& threads, Next next) {
  lines_ = lines;
  hierarchy_ = hierarchy;
  threads_ = &threads;
  next_ = next;
  count_ = 0;
  drawn_count_ = 0;
  pass_.clear();
  pending_.clear();
  pass_.generation = pending_.generation = candidates.generation;
  const auto word_of = [](SlotBits bits, std::size_t word) { return word < bits.size() ? bits[word] : 0; };
  const auto firsts_of = [&](std::size_t word) { return word_of(unoccluded_, word) | word_of(lines, word); };
  const auto is_first = [&](core::Slot s) { return (firsts_of(s / 64) >> s % 64 & 1u) != 0; };
  for (const core::Slot s : candidates.single_slots) (is_first(s) ? pass_ : pending_).single_slots.push_back(s);
  for (const core::SlotRange& range : candidates.ranges) {
    const core::Slot end = range.first + range.count;
    for (core::Slot s = range.first, run = s; run < end; run = s) {
      const bool first = is_first(run);
      while (s < end) {  // to the end of the run, or of the word
        const std::uint64_t others_left = (first ? ~firsts_of(s / 64) : firsts_of(s / 64)) >> s % 64;
        s = std::min(end, others_left == 0 ? (s / 64 + 1) * 64 : s + core::Slot(std::countr_zero(others_left)));
        if (others_left != 0) break;
      }
      append(first ? pass_ : pending_, first ? first_singles_ : other_singles_, run, s);
    }
  }
  merge_singles(pass_, first_singles_);
  merge_singles(pending_, other_singles_);
}

/// Adds single slots, of which then none are left.
void OcclusionPasses::merge_singles(core::VisibleSet& set, std::vector<core::Slot>& more) {
  merged_.clear();
  merge_slots(set.single_slots, more, merged_);
  set.single_slots.swap(merged_);
  more.clear();
}

bool OcclusionPasses::next(const OcclusionTest& test, const core::ItemBounds& bounds) {
  if (count_ == 0)
    find_first(test, bounds);
  else
    next_ == Next::kNearest ? find_nearest(test, bounds) : find_next(test, bounds);
  if (count_ > 0 && pass_.count() == 0) return false;
  drawn_count_ += pass_.count();
  if (passes_.size() <= std::size_t(count_)) passes_.emplace_back();
  std::swap(passes_[std::size_t(count_++)], pass_);
  return true;
}

/// What was open in the frame before and covers a pixel centre in this one.
void OcclusionPasses::find_first(const OcclusionTest& test, const core::ItemBounds& bounds) {
  test.filter(bounds, pass_, found_, lines_, threads_);
  std::swap(pass_, found_);
}

/// The next part of which anything is open.
void OcclusionPasses::find_nearest(const OcclusionTest& test, const core::ItemBounds& bounds) {
  if (count_ == 1) {
    near_first_.split(pending_, *hierarchy_, test);
    near_parts_ = 0;
  }
  found_.clear();
  const auto parts = near_first_.parts();
  while (near_parts_ < parts.size() && found_.count() == 0)
    test.filter(bounds, parts[near_parts_++], found_, lines_, threads_, hierarchy_);
  std::swap(pass_, found_);
}

/// Where much is open, only what is in front of the rest.
void OcclusionPasses::find_next(const OcclusionTest& test, const core::ItemBounds& bounds) {
  test.split_front(bounds, hierarchy_, pending_, found_, others_, threads_);
  std::swap(pending_, others_);
  if (found_.count() + pending_.count() <= kFew || count_ == kMostPasses - 1) {
    merge_singles(found_, pending_.single_slots);
  }
  std::swap(pass_, found_);
}

void OcclusionPasses::list_drawn(const core::ItemBounds& bounds, core::VisibleSet& drawn) {
  drawn_bits_.assign(bit_words(bounds.size()), 0);
  for (int i = 0; i < count_; ++i) set_bits(passes_[std::size_t(i)], drawn_bits_);
  drawn.clear();
  drawn.generation = pass_.generation;
  slots_of(drawn_bits_, drawn.single_slots);
}

void OcclusionPasses::follow(const core::Snapshot& former, const core::Snapshot& snapshot) {
  core::VisibleSet unoccluded;
  for (const core::Slot before : slots_of(unoccluded_)) {
    if (before >= former.size() || former.item(before) == core::kNoItem) continue;
    const core::Slot slot = snapshot.slot(former.item(before));
    if (slot != core::kNone) unoccluded.single_slots.push_back(slot);
  }
  remember(unoccluded, snapshot.bounds());
}

void OcclusionPasses::remember(const core::VisibleSet& unoccluded, const core::ItemBounds& bounds) {
  unoccluded_.assign(bit_words(bounds.size()), 0);
  set_bits(unoccluded, unoccluded_);
}

void OcclusionPasses::remember(const OcclusionTest& test, const core::ItemBounds& bounds) {
  unoccluded_.assign(bit_words(bounds.size()), 0);
  for (int i = 0; i < count_; ++i) {
    test.filter(bounds, passes_[std::size_t(i)], found_, lines_, threads_);
    set_bits(found_, unoccluded_);
  }
}

}  // namespace sightline::culling
