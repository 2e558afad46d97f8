// The yardstick: which boxes are really visible, and how an answer errs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/view.h"

namespace sightline::study {

/// Two sets per view, both computed in double without a hierarchy.
class ExactSets {
 public:
  ExactSets(std::span<const core::Aabb> boxes, const core::View& view);

  /// Sorted ids of boxes whose p-vertex no plane of the frustum rejects: what an ideal plane test keeps.
  const std::vector<std::uint32_t>& p_vertex() const { return p_vertex_; }
  /// The boxes that meet the frustum (separating axes: planes, box axes, and cross products of edges; S. Gottschalk
  /// and others, "OBBTree", 1996). The same as p_vertex() when the frustum is not bounded. Boxes within 1e-9 of the
  /// scene's size count as meeting it.
  const std::vector<std::uint32_t>& meeting() const { return meeting_; }

 private:
  std::vector<std::uint32_t> p_vertex_, meeting_;
};

/// Counts of ids; all sets sorted.
struct Errors {
  std::uint64_t visible = 0;          ///< of the answer
  std::uint64_t extra = 0;            ///< in the answer, not in p_vertex()
  std::uint64_t missing = 0;          ///< in p_vertex(), not in the answer
  std::uint64_t false_positives = 0;  ///< in the answer, not in meeting()
  std::uint64_t false_negatives = 0;  ///< in meeting(), not in the answer: these are lost on the screen
};
Errors compare(const std::vector<std::uint32_t>& answer, const ExactSets& exact);

}  // namespace sightline::study
