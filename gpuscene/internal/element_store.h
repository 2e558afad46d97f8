// Runs of elements in one buffer of GPU memory, which grows and shrinks a piece at a time. Internal to gpuscene.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "sightline/core/internal/store.h"
#include "sightline/gl/internal/buffer.h"
#include "sightline/gpuscene/internal/free_space.h"

namespace sightline::gpuscene {

/// Elements are staged first, and write() puts them into the buffer. To change its size, the contents move to another
/// buffer: in place where it grows, without gaps where it shrinks. While they move nothing can be taken or staged.
template <class Element>
class ElementStore {
 public:
  /// A run in use.
  struct Run {
    std::uint32_t first, count;
  };
  static constexpr std::size_t kMovedBytes = std::size_t(1) << 20;  ///< at a time
  static constexpr std::size_t kLeastWaste = 64 * 1024;             ///< bytes; smaller buffers never shrink

  /// `what` names the contents in errors.
  explicit ElementStore(const char* what) : what_(what) {}

  const gl::Buffer& buffer() const { return buffer_; }
  std::size_t memory_bytes() const { return buffer_.size() + next_.size(); }
  std::uint32_t take(std::uint32_t count) { return space_.take(count); }
  void give_back(std::uint32_t first, std::uint32_t count) {
    space_.give_back(first, count);
    if (packing()) given_back_.push_back({first, count});
  }
  bool has_room() const { return space_.end() * sizeof(Element) <= buffer_.size(); }
  /// Whether less than half of the buffer is in use.
  bool is_wasteful() const {
    return buffer_.size() > kLeastWaste && 2 * sizeof(Element) * space_.used() < buffer_.size();
  }

  // --- contents ---

  /// Room for `count` more staged elements, which belong to places from `first` on.
  std::span<Element> stage(std::uint32_t first, std::size_t count) {
    const bool joins =
        !staged_runs_.empty() && staged_runs_.back().first + (staged_.size() - staged_runs_.back().begin) == first;
    if (!joins && count > 0) staged_runs_.push_back({first, staged_.size()});
    staged_.resize(staged_.size() + count);
    return std::span(staged_).last(count);
  }
  std::size_t staged() const { return staged_.size(); }
  void write() {
    for (std::size_t i = 0; i < staged_runs_.size(); ++i) {
      const auto [first, begin] = staged_runs_[i];
      const std::size_t end = i + 1 < staged_runs_.size() ? staged_runs_[i + 1].begin : staged_.size();
      buffer_.write(first * sizeof(Element), (end - begin) * sizeof(Element), staged_.data() + begin);
    }
    staged_.clear();
    staged_runs_.clear();
  }
  void free_scratch() { staged_ = {}; }

  // --- size ---

  bool moving() const { return next_.size() > 0; }
  bool packing() const { return !packed_at_.empty(); }
  /// Begins to move to a buffer for all that is taken and `waiting` elements more. The first one has just that, later
  /// ones the `headroom`th part more. What is staged must be written.
  core::Expected<void> begin_growth(const gl::Functions& gl, std::size_t waiting, std::size_t headroom) {
    const std::size_t present = buffer_.size() / sizeof(Element), needed = std::max(space_.end() + waiting, present);
    copies_.assign(1, {0, std::uint32_t(std::min<std::size_t>(space_.end(), present))});
    return begin_move(gl, present > 0 ? needed + needed / headroom : needed);
  }
  /// Begins to move to a buffer for little more than the runs, which are all that is taken, in any order.
  core::Expected<void> begin_packing(const gl::Functions& gl, std::vector<Run> runs) {
    std::ranges::sort(runs, {}, &Run::first);
    std::uint32_t place = 0;
    for (const Run& run : runs) packed_at_.push_back(std::exchange(place, place + run.count));
    copies_ = std::move(runs);
    return begin_move(gl, place + place / 8);
  }
  /// Moves at most kMovedBytes. Returns true once all is there; packed_place() then tells where, until end_move().
  bool move(const gl::Functions& gl) {
    for (std::size_t room = kMovedBytes / sizeof(Element); room > 0 && next_copy_ < copies_.size();) {
      const Run& run = copies_[next_copy_];
      const std::size_t count = std::min<std::size_t>(room, run.count - copied_);
      const std::size_t to = (packing() ? packed_at_[next_copy_] : run.first) + copied_;
      if (count > 0)
        gl.CopyNamedBufferSubData(buffer_.id(), next_.id(), GLintptr((run.first + copied_) * sizeof(Element)),
                                  GLintptr(to * sizeof(Element)), GLsizeiptr(count * sizeof(Element)));
      copied_ += std::uint32_t(count);
      room -= count;
      if (copied_ == run.count) ++next_copy_, copied_ = 0;
    }
    return next_copy_ == copies_.size();
  }
  /// The new place of a run that was moved, by its former one.
  std::uint32_t packed_place(std::uint32_t first) const {
    const auto run = std::ranges::lower_bound(copies_, first, {}, &Run::first);
    return packed_at_[std::size_t(run - copies_.begin())];
  }
  /// Uses the other buffer from now on.
  void end_move() {
    if (packing()) {
      FreeSpace packed;
      packed.take(packed_at_.back() + copies_.back().count);
      for (const Run& run : given_back_) packed.give_back(packed_place(run.first), run.count);
      space_ = std::move(packed);
    }
    buffer_ = std::exchange(next_, {});
    packed_at_ = {};
    copies_ = {};
    given_back_ = {};
  }

 private:
  /// Elements of staged_ from `begin` to the next run's come to places from `first` on.
  struct StagedRun {
    std::uint32_t first;
    std::size_t begin;
  };
  core::Expected<void> begin_move(const gl::Functions& gl, std::size_t capacity) {
    const std::size_t bytes = std::max<std::size_t>(capacity, 1) * sizeof(Element);
    next_copy_ = copied_ = 0;
    return core::store(gl::Buffer::create(gl, bytes, nullptr, GL_DYNAMIC_STORAGE_BIT, what_), next_);
  }

  const char* what_;
  gl::Buffer buffer_;
  FreeSpace space_;
  std::vector<Element> staged_;
  std::vector<StagedRun> staged_runs_;
  // State of a move:
  gl::Buffer next_;
  std::vector<Run> copies_;
  std::vector<std::uint32_t> packed_at_;  // by copy; none where the buffer grows
  std::uint32_t next_copy_ = 0, copied_ = 0;
  std::vector<Run> given_back_;  // since it began, where it packs
};

}  // namespace sightline::gpuscene
