// The camera of the viewer: flies, looks about, orbits, pans, zooms and fits. Also a recorder of its path. Pure logic:
// no window, no clock.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/camera_path.h"
#include "sightline/core/error.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"

namespace sightline::apps {

/// Z is up, and the camera never rolls or turns over. All motion scales with the model.
class Camera {
 public:
  /// For a model with these bounds. Shows all of it from kOverviewDirection. `fovy`: radians.
  Camera(const core::AabbD& bounds, double fovy, double aspect);

  /// The camera's view, for an image whose width is `aspect` times its height; `shift`: by which the model is moved
  /// right and up in it, in parts of its width and height.
  core::Expected<core::View> view(double aspect, const core::dvec2& shift = core::dvec2(0.0)) const;

  /// Moves back or forth until a box fills the image, with room around it for what it is part of.
  void fit(const core::AabbD& bounds, double aspect);
  /// Looks along a direction, not 0, at what sections keep of the items, which fills the image but for outliers and a
  /// little room.
  void show_all(const core::ItemBounds& items, const core::dvec3& direction, double aspect,
                std::span<const core::Plane> sections = {});
  void show_all(const core::ItemBounds& items, double aspect, std::span<const core::Plane> sections = {}) {
    show_all(items, forward(), aspect, sections);
  }
  /// Flies right, forward and up (-1 … 1 each) for some seconds.
  void fly(const core::dvec3& held, double seconds);
  /// Turns the head by radians to the right, and up.
  void look(const core::dvec2& by);
  /// Moves about a point, at which the image stays as it is; by radians, so that the model follows.
  void orbit(const core::dvec2& by, const core::dvec3& about);
  /// Moves the model right and up in the image, by parts of the image's height at the distance of a point.
  void pan(const core::dvec2& by, const core::dvec3& at);
  /// Moves towards a point, or away from it; the point stays where it is in the image.
  void zoom(double notches, const core::dvec3& at);
  /// Puts the camera back to where it was before its last motions, each of which begins with remember().
  void back();
  void remember();

  bool orthographic() const { return orthographic_; }
  /// The image keeps its size where the target is.
  void set_orthographic(bool orthographic) { orthographic_ = orthographic; }

  const core::Pose& pose() const { return pose_; }
  /// Continues from `pose`: eye != target, all finite. An up direction other than Z lasts until the camera turns.
  void set_pose(const core::Pose& pose) { pose_ = pose; }
  double fovy() const { return fovy_; }
  void set_fovy(double fovy) { fovy_ = fovy; }
  double near() const { return near_; }
  double far() const { return far_; }
  /// Sets the planes of perspective views, 0 < near < far.
  void set_planes(double near, double far);
  double speed() const { return kSizesPerSecond * size_; }  ///< metres per second

 private:
  static constexpr double kSizesPerSecond = 0.125;  // of the model

  core::dvec3 forward() const;
  void turn(const core::dvec2& by, const core::dvec3& about);

  double size_;  // diagonal of the model, metres
  double fovy_, near_, far_ = core::kInfiniteFar;
  core::Pose pose_;
  bool orthographic_ = false;
  std::vector<std::pair<core::Pose, bool>> places_;  // pose, orthographic
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
