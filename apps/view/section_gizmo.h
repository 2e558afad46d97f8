// The handles of a section in the image: where they show, which one lies under the cursor, and where dragging it
// takes the section. Pure geometry: no window. Points of the image are in pixels from its upper left corner.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "sightline/apps/view/sections.h"
#include "sightline/core/image_rays.h"
#include "sightline/core/view.h"

namespace sightline::apps {

/// A view with the pixels that show it.
class ImageFrame {
 public:
  /// Fails where core::ImageRays does.
  static core::Expected<ImageFrame> create(const core::View& view, int width, int height);

  const core::dvec2& size() const { return size_; }
  /// None behind the eye.
  std::optional<core::dvec2> project(const core::dvec3& point) const;
  /// Metres that a pixel is wide at a point before the eye.
  double pixel_at(const core::dvec3& point) const;
  core::Ray ray(const core::dvec2& at) const { return rays_.through(at.x, at.y); }
  /// How far from `point` along a unit vector an axis comes nearest to a pixel's ray. None where the two are parallel,
  /// and where that is behind the eye.
  std::optional<double> along_axis(const core::dvec2& at, const core::dvec3& point, const core::dvec3& axis) const;
  /// Where a pixel's ray meets the plane through a point; none behind the eye.
  std::optional<core::dvec3> on_plane(const core::dvec2& at, const core::dvec3& point, const core::dvec3& normal) const;

 private:
  ImageFrame(const core::View& view, const core::dvec2& size, core::ImageRays rays);
  bool ahead(double t) const { return orthographic_ || t > 0.0; }

  core::dmat4 clip_from_eye_, eye_from_world_;
  core::dvec2 size_;
  core::ImageRays rays_;
  bool orthographic_;
};

class SectionGizmo {
 public:
  /// An arrow out of what is kept and one into it move the section, as the middle does. Those at the square's sides
  /// turn it.
  enum class Part { kMiddle, kOut, kIn, kRight, kLeft, kUp, kDown };
  static const char* name_of(Part part);  ///< "middle", "out" and so on
  struct Handle {
    Part part;
    core::dvec2 at{0.0};
  };

  /// All handles of a section with `whole`, otherwise the middle and the arrow out. `scale`: pixels of what is one on a
  /// screen of 96 dots per inch. They are at the section's place; where that is outside the image or close to its
  /// border, at another point of the plane. None where the image does not show the plane.
  static std::optional<SectionGizmo> create(const ImageFrame& frame, const Sections::Section& section, bool whole,
                                            double scale);

  const std::vector<Handle>& handles() const { return handles_; }  ///< the middle first
  const core::dvec2& middle() const { return handles_.front().at; }
  double radius(Part part) const;  ///< pixels
  /// The corners of a small square in the plane.
  const std::array<core::dvec2, 4>& outline() const { return outline_; }
  bool whole() const { return whole_; }
  double scale() const { return scale_; }
  double pixel() const { return pixel_; }  ///< metres that one is wide at the middle
  std::optional<Part> part_at(const core::dvec2& point) const;

  static bool turns(Part part) { return part >= Part::kRight; }
  /// Metres along the section's normal, or radians, by which dragging a handle moves or turns the section: what was
  /// under the cursor stays under it. Where the handle moves along the line of sight, pixels count. None where nothing
  /// is under the cursor, beyond the horizon.
  std::optional<double> dragged(Part part, const core::dvec2& from, const core::dvec2& to) const;
  /// The section moved or turned by that.
  Sections::Section moved(Part part, double by) const;

 private:
  SectionGizmo(const ImageFrame& frame, const Sections::Section& section, const core::dvec3& anchor, bool whole,
               double scale);
  bool add_handles();
  /// From the middle to a side handle; unit.
  core::dvec3 side_of(Part part) const;
  /// Where a point beside the anchor shows from the middle.
  std::optional<core::dvec2> seen(const core::dvec3& off) const;

  ImageFrame frame_;
  Sections::Section section_;
  core::dvec3 anchor_, right_, up_;  // right, up: in the plane, as seen from the removed side
  core::dvec3 sight_;                // direction of the ray to the anchor
  double scale_, pixel_;
  bool whole_;
  std::array<core::dvec2, 4> outline_{};
  std::vector<Handle> handles_;
};

}  // namespace sightline::apps
