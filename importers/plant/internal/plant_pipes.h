// Internal to the plant generator: where pipes run, and what is built into them.
#pragma once

#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/importers/plant/internal/plant_stage.h"

namespace sightline::importers::plant {

/// Space for one pipe: a straight line with free space above it.
struct Lane {
  dvec3 start{0.0};
  dvec3 along{1.0, 0.0, 0.0};
  double length = 0.0;
  double radius = 0.0;      ///< of the pipe
  double clearance = 0.0;   ///< above the axis
  double drop = 0.0;        ///< below the axis
  bool opens_bank = false;  ///< first pipe of a bank, whose pipes carry one service
};

/// Hands out the lanes of a block of space in banks, tier by tier. The first tiers lie every three metres, with room
/// for large pipes. Then come ever finer ones in between for ever smaller pipes, and finally tubing anywhere. It never
/// runs out.
class Lanes {
 public:
  /// Tiers alternate between x and y unless `x_only`. Lanes avoid the `obstacles`, which may grow later.
  Lanes(const core::AabbD& block, bool x_only, const std::vector<core::AabbD>& obstacles);

  /// May return an empty lane (length 0) where obstacles leave too little space; then call it again.
  Lane next(Random& random);
  /// Instrument tubing at a random place.
  Lane tubing(Random& random) const;
  /// Heights of the tiers every three metres.
  const std::vector<double>& levels() const { return levels_; }

 private:
  struct Tier {
    double z = 0.0, cursor = 0.0;
    bool along_x = true;
  };
  void open_pass();
  double width(const Tier& tier) const;
  Lane place(const Tier& tier, double radius, Random& random) const;
  Lane longest_free(const Lane& lane) const;

  core::AabbD block_;
  bool x_only_;
  const std::vector<core::AabbD>& obstacles_;
  std::vector<double> levels_;
  std::vector<Tier> tiers_;
  std::size_t tier_ = 0;
  int pass_ = -1, left_in_bank_ = 0;
  double largest_ = 0.0, clearance_ = 0.0;
};

/// Stages a pipe along the lane. What is built in depends on what the statistics still need. Stays within the stage's
/// room.
void lay_pipe(Stage& stage, Random& random, const Lane& lane);

}  // namespace sightline::importers::plant
