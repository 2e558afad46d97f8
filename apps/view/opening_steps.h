// Which step the opening of a model is in, and what each step took.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace sightline::apps {

enum class OpeningStep : unsigned char { kNone, kReading, kBuilding, kUploading, kDrawing };
inline constexpr std::array<std::string_view, 5> kOpeningStepNames{"", "reading", "building", "uploading", "drawing"};

class OpeningSteps {
 public:
  /// `now`: seconds, which do not go back. kNone: the model is open, or will not be.
  void enter(OpeningStep step, double now) {
    if (step_ != OpeningStep::kNone) seconds_[std::size_t(step_)] += now - since_;
    step_ = step;
    since_ = now;
  }
  OpeningStep step() const { return step_; }
  std::string_view name() const { return kOpeningStepNames[std::size_t(step_)]; }
  /// Of a step that is over.
  double seconds(OpeningStep step) const { return seconds_[std::size_t(step)]; }

 private:
  OpeningStep step_ = OpeningStep::kNone;
  double since_ = 0.0;
  std::array<double, kOpeningStepNames.size()> seconds_{};
};

}  // namespace sightline::apps
