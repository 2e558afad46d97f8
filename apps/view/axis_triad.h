// The axes of the world in a corner of the image: where their ends are, and which view each of them stands for.
#pragma once

#include <array>
#include <optional>

#include "sightline/core/conventions.h"
#include "sightline/core/view.h"

namespace sightline::apps {

class AxisTriad {
 public:
  struct End {
    int axis = 0;  ///< x, y, z
    bool positive = true;
    core::dvec2 at{0.0};  ///< pixels, down from the upper left corner as `centre`
    double depth = 0.0;   ///< towards the eye, -1 … 1
  };

  /// As `pose` sees them, about `centre`; `scale`: pixels of what is one on a screen of 96 dots per inch.
  AxisTriad(const core::Pose& pose, const core::dvec2& centre, double scale);
  /// What it takes to all sides of its centre.
  static double reach(double scale);

  const core::dvec2& centre() const { return centre_; }
  double scale() const { return scale_; }
  double end_radius() const;
  /// The farthest one first.
  const std::array<End, 6>& ends() const { return ends_; }
  /// The end that shows at a point.
  std::optional<End> end_at(const core::dvec2& point) const;
  /// The command that looks from an end; from the other one where that is what the image shows already.
  static const char* view_from(const End& end);

 private:
  core::dvec2 centre_;
  double scale_;
  std::array<End, 6> ends_;
};

}  // namespace sightline::apps
