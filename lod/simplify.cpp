#include "sightline/lod/internal/simplify.h"

#include <algorithm>
#include <limits>

#if SIGHTLINE_HAS_MESHOPT
#include <meshoptimizer.h>
#endif

namespace sightline::lod {

#if SIGHTLINE_HAS_MESHOPT
namespace {

using core::vec3;

/// meshoptimizer 0.18 can lock all open borders or none. But it locks vertices where several borders meet. So each
/// locked vertex gets a triangle that touches it alone, so small that it collapses before all others. A vertex without
/// a border gets its only one by that, and may collapse into its triangle, from where it is taken back.
class Locks {
 public:
  Locks(std::span<const vec3> positions, std::span<const std::uint32_t> corners, std::span<const std::uint8_t> locked)
      : positions_(positions.begin(), positions.end()), corners_(corners.begin(), corners.end()) {
    vec3 low(std::numeric_limits<float>::max()), high(-low);
    for (const vec3& p : positions) low = glm::min(low, p), high = glm::max(high, p);
    const vec3 size = high - low;
    const float step = 1e-5f * std::max({size.x, size.y, size.z});
    for (std::uint32_t i = 0; i < locked.size(); ++i) {
      if (!locked[i]) continue;
      const auto next = std::uint32_t(positions_.size());
      positions_.push_back(positions[i] + vec3(step, 0.31f * step, 0.0f));
      positions_.push_back(positions[i] + vec3(0.0f, step, 0.29f * step));
      for (const std::uint32_t corner : {i, next, next + 1}) corners_.push_back(corner);
      vertices_.insert(vertices_.end(), 2, i);
    }
  }
  const std::vector<vec3>& positions() const { return positions_; }
  const std::vector<std::uint32_t>& corners() const { return corners_; }
  /// The vertex itself, or the locked one whose triangle has it.
  std::uint32_t locked(std::uint32_t vertex) const {
    const std::size_t before = positions_.size() - vertices_.size();
    return vertex < before ? vertex : vertices_[vertex - before];
  }

 private:
  std::vector<vec3> positions_;
  std::vector<std::uint32_t> corners_, vertices_;  // the latter: of each position that was added
};

}  // namespace

std::vector<std::uint32_t> simplify(std::span<const vec3> positions, std::span<const std::uint32_t> corners,
                                    std::span<const std::uint8_t> locked, std::size_t target) {
  const Locks locks(positions, corners, locked);
  std::vector<std::uint32_t> result(locks.corners().size());
  constexpr float kAnyError = std::numeric_limits<float>::max();
  result.resize(meshopt_simplify(result.data(), locks.corners().data(), locks.corners().size(), &locks.positions()[0].x,
                                 locks.positions().size(), sizeof(vec3), 3 * target, kAnyError, 0, nullptr));
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < result.size(); i += 3) {
    const std::uint32_t a = locks.locked(result[i]), b = locks.locked(result[i + 1]), c = locks.locked(result[i + 2]);
    if (a != b && b != c && c != a) kept.insert(kept.end(), {a, b, c});
  }
  return kept;
}

#else
std::vector<std::uint32_t> simplify(std::span<const core::vec3>, std::span<const std::uint32_t> corners,
                                    std::span<const std::uint8_t>, std::size_t) {
  return {corners.begin(), corners.end()};
}
#endif

}  // namespace sightline::lod
