#include "sightline/gpuscene/internal/visible_records.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace sightline::gpuscene {
namespace {

using core::Kind;
using core::Slot;
using core::SlotRange;
using core::Snapshot;

constexpr std::size_t kSlotsOfPart = 2048;  // for a thread

/// Calls `part(first, end)` for each part of a range between its vacant runs of more than kLongestGap slots.
template <class Part>
void without_vacant_runs(const Snapshot& snapshot, const SlotRange& range, const Part& part) {
  const Slot end = range.first + range.count;
  Slot first = snapshot.first_occupied(range.first, end);
  while (first < end) {
    Slot stop = first, next = first;
    do {
      stop = snapshot.first_vacant(next, end);
      next = snapshot.first_occupied(stop, end);
    } while (next < end && next - stop <= kLongestGap);
    part(first, stop);
    first = next;
  }
}

}  // namespace

void VisibleRecords::assign(const Snapshot& snapshot, const core::VisibleSet& visible, core::ThreadPool* threads) {
  for (OfBatch& batch : batches) {
    batch.runs.clear();
    batch.singles.clear();
  }
  meshes.clear();
  for (const SlotRange& range : visible.ranges)
    without_vacant_runs(snapshot, range, [&](Slot first, Slot end) {
      if (end - first >= kShortestRun) return add_range(snapshot, first, end);
      for (Slot slot = first; slot < end; ++slot)
        if (!snapshot.vacant(slot)) add_slot(snapshot, slot);
    });
  add_singles(snapshot, visible.single_slots, threads);
}

/// Threads count the slots of each batch in their parts, and then write the records to their places.
void VisibleRecords::add_singles(const Snapshot& snapshot, std::span<const Slot> slots, core::ThreadPool* threads) {
  const auto parts = std::uint32_t((slots.size() + kSlotsOfPart - 1) / kSlotsOfPart);
  const auto for_each = [&](const auto& job) {
    core::ThreadPool::run_on(threads, parts, [&](std::uint32_t part) {
      const std::size_t first = std::size_t(part) * kSlotsOfPart;
      job(slots.subspan(first, std::min(kSlotsOfPart, slots.size() - first)), places_[part]);
    });
  };
  places_.assign(parts, {});
  for_each([&](std::span<const Slot> some, OfKinds& counts) {
    OfKinds found{};
    for (const Slot slot : some) ++found[std::size_t(batch_of(snapshot.kind(slot)))];
    counts = found;
  });
  std::array<std::uint32_t*, kBatchKindCount> records{};
  for (std::size_t kind = 0; kind < records.size(); ++kind) {
    std::vector<std::uint32_t>& list = BatchKind(kind) == BatchKind::kMesh ? meshes : batches[kind].singles;
    auto end = std::uint32_t(list.size());
    for (OfKinds& of_part : places_) end += std::exchange(of_part[kind], end);
    list.resize(end);
    records[kind] = list.data();
  }
  for_each([&](std::span<const Slot> some, const OfKinds& places) {
    OfKinds next = places;
    for (const Slot slot : some) {
      const BatchKind kind = batch_of(snapshot.kind(slot));
      records[std::size_t(kind)][next[std::size_t(kind)]++] =
          kind == BatchKind::kMesh ? slot : GpuScene::record_of(snapshot, slot);
    }
  });
}

void VisibleRecords::add_range(const Snapshot& snapshot, Slot first, Slot end) {
  for (int kind = 0; kind < int(BatchKind::kMesh); ++kind) {
    const std::uint32_t begin = GpuScene::rank(snapshot, BatchKind(kind), first);
    const std::uint32_t count = GpuScene::rank(snapshot, BatchKind(kind), end) - begin;
    OfBatch& batch = batches[std::size_t(kind)];
    if (count >= kShortestRun) {
      batch.runs.push_back({begin, count});
    } else {
      batch.singles.resize(batch.singles.size() + count);
      std::iota(batch.singles.end() - std::ptrdiff_t(count), batch.singles.end(), begin);
    }
  }
  add_meshes(snapshot, first, end);
}

void VisibleRecords::add_meshes(const Snapshot& snapshot, Slot first, Slot end) {
  const std::ptrdiff_t begin = std::ptrdiff_t(meshes.size());
  add_meshes(snapshot, Kind::kFacetGroup, first, end);
  const std::ptrdiff_t middle = std::ptrdiff_t(meshes.size());
  add_meshes(snapshot, Kind::kMesh, first, end);
  if (middle == begin || middle == std::ptrdiff_t(meshes.size())) return;
  merged_.resize(meshes.size() - std::size_t(begin));
  std::merge(meshes.begin() + begin, meshes.begin() + middle, meshes.begin() + middle, meshes.end(), merged_.begin());
  std::ranges::copy(merged_, meshes.begin() + begin);
}

void VisibleRecords::add_meshes(const Snapshot& snapshot, Kind kind, Slot first, Slot end) {
  const auto& slots = snapshot.of_kind(kind).members;
  for (std::uint32_t i = snapshot.rank(kind, first), stop = snapshot.rank(kind, end); i < stop; ++i)
    if (!snapshot.vacant(slots[i])) meshes.push_back(slots[i]);
}

void VisibleRecords::add_slot(const Snapshot& snapshot, Slot slot) {
  const BatchKind kind = batch_of(snapshot.kind(slot));
  if (kind == BatchKind::kMesh) {
    meshes.push_back(slot);
  } else {
    batches[std::size_t(kind)].singles.push_back(GpuScene::record_of(snapshot, slot));
  }
}

}  // namespace sightline::gpuscene
