// Which items a frame draws within a given time, and which when the camera rests. Internal to culling and engine.
#pragma once

#include <array>
#include <vector>

#include "sightline/core/item_bounds.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/internal/set_parts.h"
#include "sightline/culling/occlusion/contribution.h"
#include "sightline/culling/occlusion/occlusion_test.h"

namespace sightline::culling {

/// What drawing an item costs, by the size of its area: learnt from passes.
class DrawCosts {
 public:
  DrawCosts();
  /// Items by the exponent of their area in pixels, each class with twice the area of the one before.
  static constexpr int kClasses = 28;
  static int class_of(float area);

  double ms(int size_class) const { return ms_[std::size_t(size_class)]; }
  double pass_ms() const { return pass_ms_; }
  /// A pass of counts[c] items of each class has taken that long: so many times as long as was expected.
  double took(const std::array<std::uint32_t, kClasses>& counts, double ms);

 private:
  std::array<double, kClasses> ms_;
  std::array<bool, kClasses> measured_{};  // the other classes are only presumed
  double pass_ms_ = 1.0;                   // beside the items
};

/// A frame's items in passes, the largest first. Items that the last frame found open come before others of up to
/// sixteen times their area. Each pass is as large as the time that it is given; hidden items take none. So the
/// threshold of contribution follows the time. What the time does not suffice for stays pending, and next() goes on
/// with it for as long as the view stays.
///
/// Where an image of the view is known, the items that it shows come first instead, and all others are left to
/// test_others(): nothing is measured or ordered that grows with the scene. Then a pass is at most eight times as large
/// as one whose time was foreseen.
class BudgetPasses {
 public:
  /// Begins a frame with its candidates. Slots of `lines` are neither measured nor tested: they come first.
  void begin(const ContributionTest& measure, const core::ItemBounds& bounds, const core::VisibleSet& candidates,
             SlotBits lines);
  /// Begins a frame with what a known image shows, which is drawn untested, and the other candidates.
  void begin_shown(const ContributionTest& measure, const core::ItemBounds& bounds, const core::VisibleSet& shown,
                   const core::VisibleSet& others, SlotBits lines);
  /// Whether all passes before those of other candidates have been drawn, and some of these are still to be tested.
  bool tests_others() const { return at_ == order_.size() && others_at_ < others_.count(); }
  /// Whether what comes next is tested against the depth of what was drawn before.
  bool tests_next() const { return !shown_first_ || tests_others(); }
  /// Tests sets of other candidates until the deadline (core::now_seconds()), one at least. The open ones are pending.
  /// `test`: against the depth of all passes so far; null: all are open. `hierarchy`: of the bounds, or null.
  void test_others(const ContributionTest& measure, const OcclusionTest* test, const core::ItemBounds& bounds,
                   const Hierarchy* hierarchy, core::ThreadPool& threads, double deadline);
  /// Finds the next pass, worth `ms` of drawing or less. `test`: against the depth of all passes so far; null: nothing
  /// is tested. False when nothing is pending.
  bool next(const OcclusionTest* test, const core::ItemBounds& bounds, double ms);
  /// The pass has taken that long, beside finding it and waiting for a GPU.
  void took(double ms);
  /// Remembers what of the drawn items is open, unless the frame began with what an image shows. The threads share the
  /// test; null: this one alone.
  void remember(const OcclusionTest& test, const core::ItemBounds& bounds, core::ThreadPool* threads = nullptr);

  const core::VisibleSet& pass() const { return pass_; }  ///< slots in rising order
  std::size_t drawn() const { return drawn_.single_slots.size(); }
  bool complete() const { return at_ == order_.size() && others_at_ == others_.count(); }
  /// Candidates that were not looked at, and the area of the largest of them that were measured.
  std::size_t pending() const;
  float largest_pending() const { return at_ == order_.size() ? 0.0f : order_[at_].area; }
  /// Replaces `bits` by one per slot: of `lines`, and of candidates that were drawn or are hidden.
  void looked_at(std::size_t slots, std::vector<std::uint64_t>& bits) const;
  /// What drawing the pending candidates may cost, if as many of them are hidden as of those before.
  double pending_ms() const;
  /// Milliseconds that all pending items would take if none of them were occluded.
  double most_pending_ms() const;
  /// What a pass costs at least.
  double least_ms() const { return costs_.pass_ms(); }

  /// Forgets the frame before. For a new scene version.
  void reset();

 private:
  using SlotArea = ContributionTest::SlotArea;
  static constexpr std::size_t kFewest = 64;  // of a pass, hidden ones included
  void begin_frame(std::uint64_t generation, SlotBits lines);
  void order_areas();
  std::size_t affordable(double ms, std::size_t count) const;
  double take(std::size_t end, const OcclusionTest* test, const core::ItemBounds& bounds);

  DrawCosts costs_;
  std::size_t foreseen_ = kFewest;         // items of the largest pass that costs_ may be trusted with
  std::vector<SlotArea> areas_, order_;    // order_: the largest first, in classes
  std::size_t at_ = 0;                     // in order_: what is before has been drawn, or is hidden
  std::vector<std::uint64_t> unoccluded_;  // a bit per slot, of the last frame
  std::array<std::uint32_t, DrawCosts::kClasses> counts_{};  // of the pass
  std::array<std::uint32_t, DrawCosts::kClasses> left_{};    // pending, of each class
  bool shown_first_ = false;                                 // since begin_shown()
  SetParts others_;                                          // of begin_shown()
  std::uint32_t others_at_ = 0;                              // of these: parts before are tested
  double drawn_ms_ = 0.0, looked_at_ms_ = 0.0;               // what was drawn cost, and would with what is hidden
  core::VisibleSet pass_, piece_, unoccluded_piece_, drawn_;
  SlotBits lines_;
};

}  // namespace sightline::culling
