// Section planes as the user moves them: each keeps one side of the model.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/apps/common/numbers.h"
#include "sightline/core/aabb.h"
#include "sightline/core/view.h"

namespace sightline::apps {

class Sections {
 public:
  struct Section {
    core::dvec3 point, normal;  ///< normal: unit, out of what is kept
    double offset = 0.0;        ///< metres along the normal by which it was moved
    bool on = true;

    core::dvec3 place() const { return point + offset * normal; }
    core::Plane plane() const { return {-normal, glm::dot(normal, point) + offset}; }
  };
  static constexpr std::size_t kMost = core::kMaxSectionPlanes;

  /// Cuts away what lies in front of a face. False where there are as many as there may be.
  bool add(const core::dvec3& point, const core::dvec3& outwards);
  /// The six sides of a box, in place of all others. Must not be empty.
  void box(const core::AabbD& bounds);
  /// These planes, at most kMost, in place of all others. Those with a zero normal cut nothing, and are left out. Their
  /// points are in the middle of what the others keep of each within the bounds.
  void set(std::span<const core::Plane> planes, const core::AabbD& bounds = {});
  /// Cuts the bounds in halves across an axis (0 to 2), and keeps the lower one. False where there are as many as there
  /// may be.
  bool add_middle(int axis, const core::AabbD& bounds);
  void clear();
  void remove(std::size_t index);
  static void flip(Section& section);
  /// The six sides of a box among the sections, however they came about: three pairs of opposite ones, of which those
  /// of different pairs are at right angles. In each pair the one first that faces along its axis.
  std::optional<std::array<std::size_t, 6>> box() const;
  static constexpr std::size_t kBoxSides = 6;

  std::vector<Section>& all() { return sections_; }
  const std::vector<Section>& all() const { return sections_; }
  /// The one whose handles the image shows; none unless select() says so. It stays the same when others go.
  std::optional<std::size_t> selected() const { return selected_; }
  void select(std::optional<std::size_t> index) { selected_ = index; }
  /// As View::sections has them.
  std::vector<core::Plane> planes() const;

 private:
  std::vector<Section> sections_;
  std::optional<std::size_t> selected_;
};

/// What a section keeps, for example "below elevation 12,300 mm", "east of X 500 mm", with Y to the north; `origin`: of
/// the coordinates.
std::string section_words(const Sections::Section& section, const core::dvec3& origin, const LengthFormat& lengths);
/// The axis that a section's normal is parallel to; none where it is oblique.
std::optional<int> section_axis(const Sections::Section& section);

/// Corners of the box that Sections::box() has found; bits 0, 1, 2 of the index: on the upper side of that pair.
std::array<core::dvec3, 8> box_corners(const Sections& sections, const std::array<std::size_t, 6>& sides);

/// The part of a convex polygon that lies inside a plane (I. Sutherland, G. Hodgman, "Reentrant polygon clipping",
/// 1974).
std::vector<core::dvec3> clipped(const std::vector<core::dvec3>& polygon, const core::Plane& plane);

}  // namespace sightline::apps
