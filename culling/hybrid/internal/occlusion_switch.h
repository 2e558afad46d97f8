// Whether the next frame tests occlusion, learnt from what frames cost with it and without. Internal to culling and
// engine.
#pragma once

#include <array>
#include <cstddef>

namespace sightline::culling {

/// How a frame is drawn.
enum class OcclusionMode : unsigned char {
  kOff,
  kOn,
  kOnBesidePart,  ///< with the test, and after that kTriedPart of the candidates without it, which hide nothing new
};

/// Keeps the cheaper of two ways, and now and then measures both in a few frames: less and less often while it stays
/// so. Views differ too much for frames of one way to be compared with those of the other, and a frame without the test
/// may cost many times as much. So frames that measure are drawn with the test, and a part of the candidates once more
/// without it, from which follows what all would take. Pure logic, without a clock. Of small items, seen from afar, the
/// test often costs more than it saves, and of large ones in the same scene less. So each class of sizes, with four
/// times the area of the one before, has its own way; one that has measured nothing begins with what the first to do so
/// has found. Where the test halves the time, measuring takes 1 % of it in the long run.
class OcclusionSwitch {
 public:
  static constexpr double kTriedPart = 1.0 / 16.0;

  /// Whether to test occlusion in the next frame. `area`: mean projected item area in pixels, 0 if unknown.
  OcclusionMode use(double area) {
    class_ = class_of(area);
    return class_times_[class_].use();
  }
  /// Tells what that frame has taken if it was kOnBesidePart: with the test, from an idle start to the end of all work,
  /// and what the part takes in a frame without it, beside which the frames before and after are under way. Both must
  /// be positive, or the frame tells nothing.
  void measured(double on_ms, double part_ms) {
    if (!(on_ms > 0.0 && part_ms > 0.0)) return;
    ClassTimes& times = class_times_[class_];
    if (!times.measured(on_ms, part_ms / kTriedPart)) return;
    for (ClassTimes& other : class_times_) other.begin_with(times);
  }

 private:
  /// Times of one class.
  class ClassTimes {
   public:
    OcclusionMode use() {
      if (wait_ > 0) {
        --wait_;
        return used_ ? OcclusionMode::kOn : OcclusionMode::kOff;
      }
      if (frames_ == 0 && !used_ && !warm_) {  // the first frame with the test remembers nothing, and is no measure
        warm_ = true;
        return OcclusionMode::kOn;
      }
      return OcclusionMode::kOnBesidePart;
    }
    /// Returns whether the way is found anew.
    bool measured(double on_ms, double off_ms);
    /// A class that has measured nothing takes what another one has found. It measures later, and where the ways differ
    /// by much, much later.
    void begin_with(const ClassTimes& other) {
      if (known_) return;
      used_ = other.used_;
      wait_ = other.clear_ ? other.wait_ : kSoon;
    }

   private:
    bool used_ = true, known_ = false, warm_ = false;
    bool clear_ = false;  // whether the ways differ by much
    int wait_ = kFirst, interval_ = kShortest;
    int frames_ = 0;               // measured, of kMeasured
    double on_ = 0.0, off_ = 0.0;  // their sums, ms
  };
  static constexpr std::size_t kClasses = 6;
  static std::size_t class_of(double area) {
    std::size_t size = 0;
    for (double end = 4.0; area >= end && size + 1 < kClasses; end *= 4.0) ++size;
    return size;
  }

  static constexpr int kFirst = 2;      // frames of a class before it measures, where no other has
  static constexpr int kSoon = 16;      // where one has
  static constexpr int kMeasured = 4;   // frames
  static constexpr int kShortest = 32;  // frames until it measures again
  static constexpr int kLongest = 512;
  static constexpr double kBetter = 0.97;  // hysteresis: a way must be so much cheaper to be taken
  static constexpr double kClear = 1.5;    // times as expensive

  std::array<ClassTimes, kClasses> class_times_;
  std::size_t class_ = 0;  // of the next frame
};

inline bool OcclusionSwitch::ClassTimes::measured(double on_ms, double off_ms) {
  on_ += on_ms;
  off_ += off_ms;
  if (++frames_ < kMeasured) return false;
  const bool changes = used_ ? off_ < kBetter * on_ : on_ < kBetter * off_;
  if (changes) used_ = !used_;
  clear_ = off_ > kClear * on_ || on_ > kClear * off_;
  interval_ = changes ? kShortest : interval_ < kLongest ? 2 * interval_ : kLongest;
  wait_ = interval_;
  known_ = true;
  warm_ = false;
  frames_ = 0;
  on_ = off_ = 0.0;
  return true;
}

/// Whether a GPU may gain by the test at all. Read-backs between passes take it some milliseconds, or a fraction of
/// one, and the test's own work takes what it takes, whatever the number of items. So one frame without the test and
/// one with it are timed. The test is left to OcclusionSwitch where drawing all takes, by the number of items, at least
/// half of the time of that tested frame, which has nothing to begin with and is slower than the next ones. Elsewhere
/// both are timed again now and then. Pure logic, without a clock.
class OcclusionTrial {
 public:
  enum class Frame { kPlain, kTimedPlain, kTimedTest, kSwitch };

  /// Whether to test occlusion in the next frame of so many items.
  Frame next(double items) {
    if (untimed_ > 0) return --untimed_, Frame::kPlain;
    if (plain_ms_ == 0.0) return items_ = items, Frame::kTimedPlain;
    if (tested_ms_ == 0.0) return Frame::kTimedTest;
    if (plain_ms_ * items >= kLeast * tested_ms_ * items_) return Frame::kSwitch;
    if (++plain_frames_ < kInterval) return Frame::kPlain;
    *this = {};
    return Frame::kPlain;
  }
  void plain_took(double ms) { plain_ms_ = ms; }
  void test_took(double ms) { tested_ms_ = ms; }

 private:
  static constexpr double kLeast = 0.5;
  static constexpr int kFirst = 2, kInterval = 512;  // frames

  double plain_ms_ = 0.0, tested_ms_ = 0.0, items_ = 0.0;  // 0: not known. items_: those of plain_ms_
  int plain_frames_ = 0, untimed_ = kFirst;                // the first frames compile and upload
};

}  // namespace sightline::culling
