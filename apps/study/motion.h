// Translation and rotation coherency (Assarsson, Möller 2000), for any motion: how far a point may have come towards a
// plane since a frame.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sightline/apps/study/camera.h"

namespace sightline::study {

/// A box remembers its last rejection. Zeros: nothing.
struct Memory {
  float by = 0.0f;     ///< metres below the plane, at least
  float reach = 0.0f;  ///< largest distance of the box from the eye
  std::uint32_t frame = 0;
  std::uint32_t plane = 0;
};

/// From one frame to the next, a plane n.p + d with height h above the eye e moves at p by
///   (n' - n).(p - e) + n'.(e - e') + h' - h.
/// Summed up over frames, with |p - e_j| <= reach + way since: at most (sum |n' - n|) (reach + way) + sum of the rest.
class Motion {
 public:
  /// Starts a frame. After kHistory frames memories are void once, and collected anew.
  void advance(const Camera& camera);
  /// True when the box that `memory` belongs to is still outside, exactly, of the plane that rejected it.
  bool still_outside(const Memory& memory) const;
  Memory remember(const Rejection& rejection, const Box& box) const;

 private:
  static constexpr std::uint32_t kHistory = 4096;
  struct Sums {
    std::array<double, kPlanes> turn{}, shift{};
    double way = 0.0;
  };
  std::vector<Sums> history_;
  std::uint32_t first_ = 1, frame_ = 0;  // frame numbers; history_[i] is of frame first_ + i
  core::dvec3 eye_{0.0};
  std::array<core::dvec3, kPlanes> normals_;
  std::array<double, kPlanes> heights_;
};

}  // namespace sightline::study
