// Finds which items were displaced alike. Internal.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "sightline/core/affine.h"

namespace sightline::compare {

/// How an item was displaced. Angles below this count as none.
inline constexpr double kLeastTurn = 1e-4;

struct Displacement {
  core::dvec3 offset{0.0};              ///< of the item's centre
  double turn = 0.0;                    ///< radians, 0 to pi
  core::Affine world_from_item_before;  ///< these two where it turned
  core::Affine world_from_item_after;

  bool turned() const { return turn > kLeastTurn; }
};

/// Displacements by classes, which are those within `slack` of the first one of the class.
class Displacements {
 public:
  explicit Displacements(double slack) : slack_(slack) {}

  /// The class of a displacement, a new one where none fits. A turned item that fits none of the last 64 classes of
  /// nearly the same angle gets a new one, so that the time stays linear.
  std::uint32_t class_of(const Displacement& displacement);

  /// The rigid map of a class, from where points were to where they are.
  const core::Affine& map(std::uint32_t which) const { return classes_[which].map; }
  bool turned(std::uint32_t which) const { return classes_[which].turned; }

 private:
  struct Class {
    core::Affine map;
    core::dvec3 at;  // a point that it was made for
    bool turned;
  };
  bool fits(const Class& known, const Displacement& displacement) const;

  double slack_;
  std::uint32_t last_ = 0;
  std::vector<Class> classes_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> by_cell_;
};

}  // namespace sightline::compare
