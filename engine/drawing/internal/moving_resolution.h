// How coarsely a moving image is drawn, so that all of it fits into its time. Pure logic: no GL, no clock.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace sightline::engine {

/// A drawn pixel stands for coarseness() pixels of the image along either axis. Frames that take too long make the next
/// one as coarse as their time asks for. Those that leave time make it finer by one step, after several in a row, so
/// that the image does not flicker between two.
class MovingResolution {
 public:
  static constexpr std::array kSteps = {1.0, 1.5, 2.0, 3.0, 4.0};

  /// Begins with the finest step, or with the coarsest where so many items are unlikely to fit.
  void begin(std::int64_t items) {
    if (!measured_) step_ = items < kFewItems ? 0 : kSteps.size() - 1;
  }
  /// A frame at rest has drawn for so long, of the image with all pixels that it begins, goes on with, or completes:
  /// once that is known to fit into the time of a moving one, moving ones have all pixels.
  void rested(double ms, bool begins, bool completes, double budget_ms) {
    rest_ms_ = begins ? ms : rest_ms_ + ms;
    if (completes && rest_ms_ <= kAimed * budget_ms) step_ = 0, measured_ = true;
  }
  std::size_t step() const { return step_; }
  double coarseness() const { return kSteps[step_]; }

  /// A moving image of this step has taken so many milliseconds, of so many that it may take.
  void took(double ms, double budget_ms) {
    measured_ = true;
    const std::size_t was = step_;
    const auto expected = [&](std::size_t step) { return ms * std::pow(kSteps[was] / kSteps[step], kPower); };
    if (ms > budget_ms) {
      calm_ = 0;
      while (step_ + 1 < kSteps.size() && expected(step_) > kAimed * budget_ms) ++step_;
    } else if (step_ == 0 || expected(step_ - 1) > kAimed * budget_ms) {
      calm_ = 0;
    } else if (++calm_ == kCalmFrames) {
      calm_ = 0;
      --step_;
    }
  }

 private:
  static constexpr std::int64_t kFewItems = 20'000;
  static constexpr double kAimed = 0.85;  // of the budget
  // The time grows with the pixels along an axis by this power: 1.3 for a plant of a million items on two cores.
  static constexpr double kPower = 1.3;
  static constexpr int kCalmFrames = 4;

  std::size_t step_ = 0;
  int calm_ = 0;  // frames in a row that would have been in time at the next finer step
  bool measured_ = false;
  double rest_ms_ = 0.0;  // that the image at rest has taken so far
};

}  // namespace sightline::engine
