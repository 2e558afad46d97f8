// Plays a camera path. Pure logic: no window, no clock.
#pragma once

#include <optional>

#include "sightline/core/camera_path.h"

namespace sightline::apps {

class PathPlayer {
 public:
  static constexpr double kSlowest = 0.01, kFastest = 100.0;

  bool loop = false;
  double speed = 1.0;  ///< times the path's own

  const std::optional<core::CameraPath>& path() const { return path_; }
  /// Stops.
  void set_path(core::CameraPath path);
  /// From its beginning; there must be a path.
  void play();
  void stop() { playing_ = false; }
  bool playing() const { return playing_; }

  /// Where the camera should be at `now`, in seconds that rise from call to call; the first after play() is the path's
  /// beginning. None while nothing plays. Stops at the path's end, and where `camera` is not where the last call put
  /// it: somebody else has taken over.
  std::optional<core::CameraSample> next(double now, const core::Pose& camera);
  /// The sample of one of `frames` evenly spaced frames.
  std::optional<core::CameraSample> next_frame(int frame, int frames);

 private:
  std::optional<core::CameraPath> path_;
  bool playing_ = false;
  double time_ = 0.0;                 // on the path
  std::optional<double> last_;        // `now` of the last call
  std::optional<core::Pose> placed_;  // where it put the camera
};

}  // namespace sightline::apps
