// Camera flights: key frames and what lies between them.
#pragma once

#include <array>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/view.h"

namespace sightline::core {

struct CameraKey {
  double time = 0.0;  ///< seconds, rising from key to key
  Pose pose;
  double fovy = 1.0471975511965976;  ///< radians
};

/// A camera at one moment of a path.
struct CameraSample {
  Pose pose;
  double fovy = 0.0;
};

/// Interpolates key frames so that neither position nor speed nor acceleration jumps at a key: eye, target and log
/// tan(fovy/2) each follow the natural cubic spline through their keys over time (C2). Up vectors turn along the great
/// circle between neighbouring keys with a smooth (C2, quintic) ease; antipodal ones turn about the line of sight.
/// Where eye and target coincide, the path keeps the last line of sight before that moment.
class SIGHTLINE_API CameraPath {
 public:
  CameraPath() = default;
  /// Needs at least one key, finite numbers, eye != target, 0 < fovy < pi and rising times. Keys of equal time and
  /// equal pose collapse into one; equal time and different pose is an error. Errors name the key by its index.
  static Expected<CameraPath> create(std::vector<CameraKey> keys);

  /// `time` outside the keys clamps to the first or last.
  CameraSample sample(double time) const;
  /// The perspective view at that time. Fails as View::perspective does.
  Expected<View> view(double time, double aspect) const;
  /// Time of frame `frame` of `frames` evenly spaced frames. The first is at begin(), the last at end().
  double time_of(int frame, int frames) const;
  double begin() const { return keys_.front().time; }
  double end() const { return keys_.back().time; }
  const std::vector<CameraKey>& keys() const { return keys_; }

  double near = 0.1;  ///< metres, for every sample
  double far = kInfiniteFar;

 private:
  static constexpr int kChannels = 7;  // eye xyz, target xyz, log tan(fovy/2)
  std::vector<CameraKey> keys_;
  std::vector<std::array<double, kChannels>> second_derivatives_;
};

}  // namespace sightline::core
