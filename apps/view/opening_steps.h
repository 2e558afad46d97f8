// Which step the opening of a model is in, and what each step took.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <string_view>

namespace sightline::apps {

/// Seconds that the window's thread may work on something before it looks at its events again.
constexpr double kPortion = 0.016;

enum class OpeningStep : unsigned char { kNone, kReading, kBuilding, kUploading, kDrawing };
inline constexpr std::array<std::string_view, 5> kOpeningStepNames{"", "reading", "building", "uploading", "drawing"};

class OpeningSteps {
 public:
  using Clock = std::chrono::steady_clock;

  /// `when`: not before the step that it ends. kNone: the model is open, or will not be.
  void enter(OpeningStep step, Clock::time_point when = Clock::now()) {
    if (step_ != OpeningStep::kNone)
      seconds_[std::size_t(step_)] += std::chrono::duration<double>(when - since_).count();
    step_ = step;
    since_ = when;
  }
  OpeningStep step() const { return step_; }
  std::string_view name() const { return kOpeningStepNames[std::size_t(step_)]; }
  /// The time that a finished step took.
  double seconds(OpeningStep step) const { return seconds_[std::size_t(step)]; }

 private:
  OpeningStep step_ = OpeningStep::kNone;
  Clock::time_point since_;
  std::array<double, kOpeningStepNames.size()> seconds_{};
};

}  // namespace sightline::apps
