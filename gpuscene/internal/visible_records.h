// The records of each batch that a visible set names. Internal to gpuscene.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/thread_pool.h"
#include "sightline/core/visible_set.h"
#include "sightline/gpuscene/internal/gpu_scene.h"

namespace sightline::gpuscene {

/// Shorter runs are split into single records: a command costs more than that many ids.
inline constexpr std::uint32_t kShortestRun = 128;
/// Most vacant slots in a row between visible slots of a run.
inline constexpr std::uint32_t kLongestGap = 4;

struct VisibleRecords {
  struct Run {
    std::uint32_t first, count;
  };
  /// Records of a batch other than meshes, in slot order.
  struct OfBatch {
    std::vector<Run> runs;               ///< kShortestRun and longer
    std::vector<std::uint32_t> singles;  ///< records from ranges, then from the set's single slots
  };
  std::array<OfBatch, kBatchKindCount> batches;
  std::vector<core::Slot> meshes;  ///< slots from ranges, then the set's single slots

  /// Sorts the slots of `visible` into their batches, each once. Keeps its memory between calls. Leaves out vacant
  /// slots, except gaps of up to kLongestGap in ranges of kShortestRun slots or more. Takes time in proportion to the
  /// number of single slots, which `threads` share, ranges, vacant runs and meshes; if any slot is vacant, also to a
  /// 64th of the slots in ranges.
  void assign(const core::Snapshot& snapshot, const core::VisibleSet& visible, core::ThreadPool* threads = nullptr);

 private:
  using OfKinds = std::array<std::uint32_t, kBatchKindCount>;
  void add_range(const core::Snapshot& snapshot, core::Slot first, core::Slot end);
  void add_meshes(const core::Snapshot& snapshot, core::Slot first, core::Slot end);
  void add_meshes(const core::Snapshot& snapshot, core::Kind kind, core::Slot first, core::Slot end);
  void add_slot(const core::Snapshot& snapshot, core::Slot slot);
  void add_singles(const core::Snapshot& snapshot, std::span<const core::Slot> slots, core::ThreadPool* threads);

  std::vector<OfKinds> places_;     // by part of the single slots: where its records begin
  std::vector<core::Slot> merged_;  // of a range
};

}  // namespace sightline::gpuscene
