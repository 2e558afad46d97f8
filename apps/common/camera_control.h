// The camera of a walkthrough: flies, looks about, orbits, zooms and fits the whole model. Also a recorder of its path.
// Pure logic: no window, no clock.
#pragma once

#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/camera_path.h"
#include "sightline/core/error.h"
#include "sightline/core/view.h"

namespace sightline::apps {

/// What the user has done since the last apply().
struct CameraInput {
  double seconds = 0.0;    ///< how long the keys were held
  core::dvec3 move{0.0};   ///< right, forward, up: -1 … 1 each
  core::dvec2 look{0.0};   ///< radians to the right, and up
  core::dvec2 orbit{0.0};  ///< the same about the centre, so that the model follows
  double wheel = 0.0;      ///< notches away from the user

  bool idle() const;
};

/// Z is up, and the camera never rolls or turns over. Its target is the centre that it orbits about and zooms to. The
/// centre moves along when the camera flies.
class CameraControl {
 public:
  /// For a model with these bounds, which set the scale of all motion. Starts where fit() leaves the camera.
  CameraControl(const core::AabbD& bounds, double fovy, double aspect);

  /// Moves to where the whole model fills a view of `fovy` radians and width / height `aspect`.
  void fit(double fovy, double aspect);
  void apply(const CameraInput& input);

  /// While orbiting, `look` orbits as well, and the wheel zooms instead of changing the speed.
  bool orbiting() const { return orbiting_; }
  void set_orbiting(bool orbiting) { orbiting_ = orbiting; }
  /// Puts the centre `metres` ahead, > 0.
  void set_centre(double metres);

  const core::Pose& pose() const { return pose_; }
  /// Continues from `pose`: eye != target, all finite. An up direction other than Z lasts until the camera turns.
  void set_pose(const core::Pose& pose) { pose_ = pose; }
  double speed() const { return speed_; }  ///< metres per second

 private:
  void move(const core::dvec3& held, double seconds);
  void turn(const core::dvec2& by, bool about_centre);
  void zoom(double notches);

  core::AabbD bounds_;
  double size_;  // diagonal of the model, metres
  core::Pose pose_;
  double speed_;
  bool orbiting_ = false;
};

/// Makes a path from the places of a camera.
class PathRecorder {
 public:
  /// Adds the camera at `time`, in seconds, which must rise. Keeps the first sample, one every quarter of a second, and
  /// the last.
  void add(double time, const core::CameraSample& camera);
  /// The path with these planes; it starts at time 0. Fails when nothing was added.
  core::Expected<core::CameraPath> path(double near, double far) const;

 private:
  std::vector<core::CameraKey> keys_;  // the next sample replaces the last one unless a key was due
};

}  // namespace sightline::apps
