#include "sightline/apps/study/motion.h"

#include <algorithm>
#include <cmath>

namespace sightline::study {

void Motion::advance(const Camera& camera) {
  ++frame_;
  if (history_.empty() || history_.size() == kHistory) {
    history_.assign(1, {});
    first_ = frame_;
  } else {
    Sums sums = history_.back();
    const core::dvec3 step = eye_ - camera.eye;
    sums.way += glm::length(step);
    for (std::size_t k = 0; k < sums.turn.size(); ++k) {
      sums.turn[k] += glm::length(camera.normals[k] - normals_[k]);
      sums.shift[k] += glm::dot(camera.normals[k], step) + camera.eye_heights[k] - heights_[k];
    }
    history_.push_back(sums);
  }
  eye_ = camera.eye;
  normals_ = camera.normals;
  heights_ = camera.eye_heights;
}

bool Motion::still_outside(const Memory& memory) const {
  if (!(memory.by > 0.0f) || memory.frame < first_) return false;
  const Sums &then = history_[memory.frame - first_], &now = history_.back();
  const std::size_t k = memory.plane;
  const double towards =
      (now.turn[k] - then.turn[k]) * (double(memory.reach) + now.way - then.way) + now.shift[k] - then.shift[k];
  // The tolerance covers the sums' own rounding; a comparison with NaN is false.
  return towards + 1e-9 * (double(memory.reach) + now.way) < double(memory.by);
}

Memory Motion::remember(const Rejection& rejection, const Box& box) const {
  double square = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double d = std::max(std::abs(double(box.lo[i]) - eye_[i]), std::abs(double(box.hi[i]) - eye_[i]));
    square += d * d;
  }
  return {rejection.by, core::round_up(std::sqrt(square)), frame_, rejection.plane};
}

}  // namespace sightline::study
