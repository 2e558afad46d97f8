// Which variant of the GPU culler costs less here. Internal to culling/gpu.
#pragma once

#include <algorithm>
#include <array>
#include <limits>

namespace sightline::culling {

/// What culling one view costs in one variant, in milliseconds; the least of some repetitions.
struct FormTimes {
  double alone = std::numeric_limits<double>::max();  ///< from submission until the GPU is done, with no other work
  double submitted = alone;                           ///< the part of it until submission returned
  double blocked = alone;                             ///< until submission returned while drawing was under way

  /// Time alone, plus how much longer submission blocks while drawing is under way.
  double cost() const { return alone + std::max(0.0, blocked - submitted); }

  void take_least(const FormTimes& other) {
    alone = std::min(alone, other.alone);
    submitted = std::min(submitted, other.submitted);
    blocked = std::min(blocked, other.blocked);
  }
};

/// The index of the cheaper variant; of equal ones the first, which needs no compute shaders.
inline std::size_t cheaper_variant(const std::array<FormTimes, 2>& times) {
  return times[1].cost() < times[0].cost() ? 1 : 0;
}

}  // namespace sightline::culling
