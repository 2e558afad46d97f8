// Operations of the box tests, counted by running them on numbers that count.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/view.h"

namespace sightline::study {

/// Additions, multiplications, divisions, roots, negations and comparisons of floats, one each.
struct Operations {
  std::string name;
  std::uint64_t update = 0;           ///< per frame: camera or planes from pose and projection
  std::uint64_t best = 0, worst = 0;  ///< per box
  double mean = 0.0;                  ///< over all boxes and views looked at
};
using OperationTable = std::vector<Operations>;

/// Corners, radar (three and two answers), p/n-vertex, on up to some thousand boxes and ten views each. Views for which
/// the radar is not usable are left out.
OperationTable count_operations(std::span<const core::Aabb> boxes, std::span<const core::View> views);

}  // namespace sightline::study
