// Whether the next frame tests occlusion, learnt from what frames cost with it and without. Internal to engine.
#pragma once

#include <array>
#include <cstddef>

namespace sightline::engine {

/// How a frame is drawn.
enum class OcclusionWay : unsigned char {
  kOff,
  kOn,
  kOnBesidePart,  ///< with the test, and after that kTriedPart of the candidates without it, which hide nothing new
};

/// Keeps the cheaper of two ways, and now and then tries the other one for a few frames: less and less often while it
/// stays dearer. A frame without the test may cost many times as much, so a part of it is tried first, in frames with
/// the test; whole ones follow only where the part does not tell that they would cost much more. Pure logic, without a
/// clock. Costs are compared per candidate, since views differ in how much they show. Of small items, seen from afar,
/// the test often costs more than it saves, and of large ones in the same scene less. So each class of sizes, with four
/// times the area of the one before, has its own way. A trial of a way that costs twice as much takes 2 % of the time
/// in the long run.
class OcclusionSwitch {
 public:
  static constexpr double kTriedPart = 1.0 / 8.0;

  /// The way of the next frame, whose items are so many pixels large in the mean; 0: not known. Then there are no
  /// trials by parts.
  OcclusionWay use(double area) {
    class_ = class_of(area);
    return ways_[class_].use();
  }
  /// That frame, with `candidates` items, has taken `ms`. Both must be positive, or the frame tells nothing.
  void took(double ms, double candidates) {
    if (ms > 0.0 && candidates > 0.0) ways_[class_].took(ms / candidates, class_ != 0);
  }

 private:
  /// Of one class.
  class Way {
   public:
    OcclusionWay use() const {
      if (trial_ > 0 && by_part_) return OcclusionWay::kOnBesidePart;
      return (trial_ > 0) != used_ ? OcclusionWay::kOn : OcclusionWay::kOff;
    }
    void took(double cost, bool may_try_parts);

   private:
    void begin_trial(bool by_part) {
      trial_ = kTrial;
      tried_ = 0.0;
      by_part_ = by_part;
    }
    bool used_ = true, by_part_ = false;
    int trial_ = 0, wait_ = kUnsteady + kTrial, interval_ = kShortest, settling_ = kUnsteady;
    double usual_ = 0.0;  // cost of the way in use, ms per candidate; 0: not known
    double tried_ = 0.0;  // sum over the frames of the trial
  };
  static constexpr std::size_t kClasses = 7;  // the first: not known
  static std::size_t class_of(double area) {
    if (!(area > 0.0)) return 0;
    std::size_t size = 1;
    for (double end = 4.0; area >= end && size + 1 < kClasses; end *= 4.0) ++size;
    return size;
  }

  static constexpr int kTrial = 6;      // frames
  static constexpr int kUnsteady = 2;   // first frames of a trial, which remember nothing, or finish what was before
  static constexpr int kShortest = 32;  // frames between two trials
  static constexpr int kLongest = 512;
  static constexpr double kBetter = 0.97;  // hysteresis: a way must be so much cheaper to be taken
  // The whole is not tried where a part tells that it costs so much more. The time of a part is a difference of two,
  // and what it draws is hidden by what is there, so it tells no more than that.
  static constexpr double kHopeless = 1.5;
  static constexpr double kWeight = 0.2;  // of a frame in the mean of the way in use

  std::array<Way, kClasses> ways_;
  std::size_t class_ = 0;  // of the next frame
};

inline void OcclusionSwitch::Way::took(double cost, bool may_try_parts) {
  if (trial_ == 0) {
    if (settling_ > 0)
      --settling_;
    else
      usual_ = usual_ == 0.0 ? cost : usual_ + kWeight * (cost - usual_);
    if (--wait_ > 0) return;
    begin_trial(used_ && may_try_parts);
    return;
  }
  if (trial_ <= kTrial - kUnsteady) tried_ += cost;
  if (--trial_ > 0) return;
  const double tried = tried_ / (kTrial - kUnsteady);
  const bool by_part = by_part_;
  if (by_part && (tried - usual_) / kTriedPart < kHopeless * usual_) {
    begin_trial(false);
    return;
  }
  const bool better = !by_part && tried < kBetter * usual_;
  if (better) {
    used_ = !used_;
    usual_ = tried;
  }
  interval_ = better ? kShortest : interval_ < kLongest ? 2 * interval_ : kLongest;
  wait_ = interval_;
  settling_ = kUnsteady;
}

}  // namespace sightline::engine
