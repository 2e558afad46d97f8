#include "sightline/importers/plant/internal/plant_pipes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sightline::importers::plant {
namespace {

/// Outer radii of pipe sizes in metres: tubing, then DN 6 to DN 1200. Steps are about equal ratios.
constexpr std::array<double, 23> kPipeRadii{0.002,   0.003,   0.004,   0.005,   0.00635, 0.0086, 0.01065, 0.01345,
                                            0.01685, 0.02415, 0.03015, 0.04445, 0.05715, 0.07,   0.08415, 0.10955,
                                            0.1365,  0.16195, 0.2032,  0.254,   0.305,   0.4,    0.61};

constexpr double kTierPitch = 3.0;
constexpr int kPasses = 9;

int index_of(double radius) {
  const auto it = std::lower_bound(kPipeRadii.begin(), kPipeRadii.end(), radius * 0.999);
  return int(std::min<std::ptrdiff_t>(it - kPipeRadii.begin(), std::ptrdiff_t(kPipeRadii.size()) - 1));
}

double smaller(double radius) {
  return kPipeRadii[std::size_t(std::max(0, index_of(radius) - 1))];
}

/// Fractions of a tier's pitch at which the passes place their tiers: the van der Corput sequence.
double van_der_corput(int n) {
  double value = 0.0, weight = 0.5;
  for (; n > 0; n >>= 1, weight *= 0.5) value += (n & 1) * weight;
  return value;
}

}  // namespace

// --- lanes -----------------------------------------------------------------------------------------------------------

Lanes::Lanes(const core::AabbD& block, bool x_only, const std::vector<core::AabbD>& obstacles)
    : block_(block), x_only_(x_only), obstacles_(obstacles) {
  for (double z = block_.min.z; z <= block_.max.z - 1.2; z += kTierPitch) levels_.push_back(z);
  if (levels_.empty()) levels_.push_back(block_.min.z);
  open_pass();
}

void Lanes::open_pass() {
  constexpr std::array<double, kPasses> kLargest{0.35, 0.16, 0.085, 0.085, 0.045, 0.03, 0.03, 0.03, 0.02};
  ++pass_;
  const std::size_t row = std::size_t(std::min(pass_, kPasses - 1));
  // A narrow block has no room for the bends of a wide pipe.
  largest_ = std::min(kLargest[row], std::max(0.02, 0.04 * std::min(block_.size().x, block_.size().y)));
  clearance_ = std::min(1.0, 5.0 * largest_);
  tiers_.clear();
  for (std::size_t i = 0; i < levels_.size() && pass_ < kPasses; ++i) {
    const double z = levels_[i] + van_der_corput(pass_) * kTierPitch;
    if (z + clearance_ < block_.max.z) tiers_.push_back({z, 0.0, x_only_ || (i + std::size_t(pass_)) % 2 == 0});
  }
  tier_ = 0;
  left_in_bank_ = 0;
}

double Lanes::width(const Tier& tier) const {
  return tier.along_x ? block_.size().y : block_.size().x;
}

Lane Lanes::next(Random& random) {
  const auto full = [this](const Tier& tier) { return tier.cursor > width(tier) - 0.02; };
  while (pass_ < kPasses && std::all_of(tiers_.begin(), tiers_.end(), full)) open_pass();
  if (pass_ >= kPasses) return tubing(random);

  const bool opens = left_in_bank_ == 0 || full(tiers_[tier_]);
  if (opens) {
    do tier_ = (tier_ + 1) % tiers_.size();
    while (full(tiers_[tier_]));
    left_in_bank_ = 4 + random.below(8);
    if (tiers_[tier_].cursor > 0.0) tiers_[tier_].cursor += 4.0 * largest_ * random.unit();
  }
  --left_in_bank_;
  Tier& tier = tiers_[tier_];
  // The mean of two draws favours the middle sizes, as in real plants. Tubing comes where there is no room for more.
  const int most = index_of(largest_), least = pass_ == 0 ? most / 3 : 0, choices = most + 1 - least;
  const double radius = kPipeRadii[least + (random.below(choices) + random.below(choices) + 1) / 2];
  const double need = 1.8 * radius + 0.012;
  tier.cursor += need;
  Lane lane = place(tier, radius, random);
  tier.cursor += need;
  lane.opens_bank = opens;
  return lane;
}

Lane Lanes::place(const Tier& tier, double radius, Random& random) const {
  Lane lane;
  const double full_length = tier.along_x ? block_.size().x : block_.size().y;
  // Short blocks are crossed, long racks are used in parts.
  const double share = full_length > 30.0 ? random.between(0.3, 1.0) : random.between(0.75, 1.0);
  const double begin = (1.0 - share) * full_length * random.unit();
  if (tier.cursor + 1.8 * radius > width(tier)) return lane;
  const bool backwards = random.chance(0.5);
  const double first = backwards ? begin + share * full_length : begin;
  lane.start = tier.along_x ? dvec3(block_.min.x + first, block_.min.y + tier.cursor, tier.z)
                            : dvec3(block_.min.x + tier.cursor, block_.min.y + first, tier.z);
  lane.along = (tier.along_x ? dvec3(1, 0, 0) : dvec3(0, 1, 0)) * (backwards ? -1.0 : 1.0);
  lane.length = share * full_length;
  lane.radius = radius;
  lane.clearance = std::max(0.1, clearance_);
  lane.drop = tier.z - block_.min.z;
  return longest_free(lane);
}

Lane Lanes::longest_free(const Lane& lane) const {
  const double margin = 2.0 * lane.radius + 0.1;
  const dvec3 end = lane.start + lane.length * lane.along;
  core::AabbD way;
  way.grow(lane.start);
  way.grow(end);
  way.min -= dvec3(margin), way.max += dvec3(margin, margin, lane.clearance);
  double from = 0.0, to = lane.length;
  for (const core::AabbD& o : obstacles_) {
    bool meets = true;
    for (int i = 0; i < 3; ++i) meets = meets && o.min[i] <= way.max[i] && way.min[i] <= o.max[i];
    if (!meets) continue;
    const double a = glm::dot(o.min - lane.start, lane.along), b = glm::dot(o.max - lane.start, lane.along);
    const double before = std::min(a, b) - margin, behind = std::max(a, b) + margin;
    if (before - from >= to - behind) {
      to = std::min(to, before);
    } else {
      from = std::max(from, behind);
    }
  }
  Lane free = lane;
  free.start = lane.start + from * lane.along;
  free.length = to - from > 1.0 ? to - from : 0.0;
  return free;
}

Lane Lanes::tubing(Random& random) const {
  Lane lane;
  const dvec3 size = block_.size();
  const bool along_x = x_only_ || size.x >= size.y;
  const double across = random.between(0.05, 0.95), height = random.between(0.0, 0.9);
  lane.length = std::min(along_x ? size.x : size.y, 20.0);
  const double slack = (along_x ? size.x : size.y) - lane.length, begin = slack * random.unit();
  lane.start = block_.min + (along_x ? dvec3(begin, across * size.y, height * size.z)
                                     : dvec3(across * size.x, begin, height * size.z));
  lane.along = along_x ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  lane.radius = kPipeRadii[std::size_t(random.below(6))];
  lane.clearance = 0.15;
  lane.opens_bank = true;
  return lane;
}

// --- what is built into a pipe ---------------------------------------------------------------------------------------

namespace {

class PipeBuilder {
 public:
  PipeBuilder(Stage& stage, Random& random, const Lane& lane)
      : stage_(stage), random_(random), lane_(lane), run_(stage, lane.start, lane.along, lane.radius) {}

  void build() {
    stage_.branch();
    if (has(kCylinders, 2)) flange();
    std::int64_t in_branch = stage_.staged();
    while (left() > 12.0 * radius() && stage_.room() > 0) {
      const std::int64_t before = stage_.staged();
      spool();
      if (!ended_) feature();
      if (ended_ || stage_.staged() == before) break;
      if (stage_.staged() - in_branch > 14) {
        stage_.branch();
        in_branch = stage_.staged();
      }
    }
    if (!ended_) end();
  }

 private:
  double radius() const { return run_.radius(); }
  double left() const { return lane_.length - glm::dot(run_.at() - lane_.start, lane_.along); }
  bool has(Share share, std::int64_t count = 1) const { return stage_.room(share) >= count; }

  /// The share that lags most behind the statistics, with some chance mixed in.
  Share wanted() {
    Share best = kCylinders;
    double most = 0.0;
    for (int s = 0; s < kShareCount; ++s) {
      const double need = double(std::max<std::int64_t>(0, stage_.room(Share(s)))) / kFractions[std::size_t(s)];
      const double weight = need * random_.between(0.7, 1.3);
      if (weight > most) best = Share(s), most = weight;
    }
    return best;
  }

  void feature() {
    switch (wanted()) {
      case kCylinders:
        random_.chance(0.6) ? flange_pair() : stub();
        break;
      case kTori:
        has(kTori, 4) ? loop() : end_upwards();
        break;
      case kSnouts:
        random_.chance(0.55) && valve_fits() ? valve() : reducer();
        break;
      default:
        shoe();
        break;
    }
  }

  void straight(double length) {
    if (has(kCylinders) && length > 0.0) run_.straight(length);
  }
  void spool() { straight(std::min(0.8 * left(), random_.between(0.4, 1.0) * std::clamp(60.0 * radius(), 0.25, 6.0))); }
  double flange_thickness() const { return 0.3 * radius() + 0.003; }
  void flange() { run_.flange(flange_thickness(), 1.7 * radius()); }
  void flange_pair() {
    if (has(kCylinders, 3)) flange(), flange();
  }

  /// A branch upwards: a tee to the eye, with a flange on top.
  void stub() {
    const double height = 4.0 * radius();
    if (!has(kCylinders, 3) || height > lane_.clearance) return;
    const double r = smaller(radius());
    const dvec3 foot = run_.at() - 2.0 * r * lane_.along;
    PipeRun branch(stage_, foot, kUp, r);
    branch.straight(height);
    branch.flange(0.3 * r + 0.003, 1.7 * r);
    if (has(kOthers) && wanted() == kOthers) branch.cap();
  }

  /// Over something and down again, square where there is room, else at 45 degrees.
  void loop() {
    const double bend = run_.bend(), rise = random_.between(0.1, 0.5) * lane_.clearance, flat = 8.0 * radius();
    const bool square = 2.0 * bend + rise <= lane_.clearance && random_.chance(0.7);
    const double needs = 4.0 * bend + flat + (square ? 0.0 : 2.0 * rise);
    if (needs > left()) return shoe();
    const dvec3 up = square ? kUp : kHalfSqrt2 * (lane_.along + kUp);
    const dvec3 down = square ? -kUp : kHalfSqrt2 * (lane_.along - kUp);
    const bool piped = has(kCylinders, 3);  // all or none, so that the loop comes down again
    run_.turn(up);
    if (piped) run_.straight(rise);
    run_.turn(lane_.along);
    if (piped) run_.straight(flat);
    run_.turn(down);
    if (piped) run_.straight(rise);
    run_.turn(lane_.along);
  }

  bool valve_fits() const {
    return has(kSnouts, 2) && has(kCylinders, 3) && left() > 8.0 * radius() && lane_.clearance > 5.0 * radius();
  }
  void valve() {
    const double r = radius(), body = 1.6 * r, throat = std::max(0.002, 0.75 * r);
    flange();
    run_.cone(1.3 * r, throat, body);
    const dvec3 middle = run_.at();
    run_.cone(throat, 1.3 * r, body);
    flange();
    const dvec3 top = middle + 3.2 * r * kUp;
    add_cylinder(stage_, middle, top, std::max(0.002, 0.18 * r));
    if (has(kTori, 2) && 0.12 * r >= 0.002) {
      add_ring(stage_, top, kUp, 1.3 * r, 0.12 * r);
    } else if (has(kOthers)) {
      add_box(stage_, top, dvec3(2.0 * r, 0.5 * r, 0.3 * r));
    }
  }

  /// One size down, or back to the lane's own size.
  void reducer() {
    if (!has(kSnouts)) return;
    const double next = radius() < lane_.radius ? lane_.radius : smaller(radius());
    run_.reduce(next, 3.0 * std::max(next, radius()), random_.chance(0.4));
  }

  /// What the pipe rests on.
  void shoe() {
    if (!has(kOthers)) return;
    const double r = radius(), height = std::max(0.05, 0.5 * r);
    const dvec3 centre = run_.at() - 1.5 * r * lane_.along - (r + 0.5 * height) * kUp;
    const dvec3 aside(lane_.along.y, lane_.along.x, 0.0);
    add_box(stage_, centre, glm::abs(lane_.along) * (3.0 * r + 0.06) + glm::abs(aside) * (1.4 * r) + height * kUp);
  }

  /// The last elbow, with a piece behind it to end on.
  void end_upwards() {
    if (ended_ || !has(kTori)) return;
    ended_ = true;
    run_.turn(kUp);
    straight(std::max(radius(), 0.5 * (lane_.clearance - run_.bend())));
  }

  void end_downwards() {
    ended_ = true;
    const double room = lane_.drop - 2.0 * run_.bend();
    run_.turn(-kUp);
    straight(room * (random_.chance(0.3) ? 1.0 : random_.between(0.1, 0.6)));
    if (has(kTori) && has(kCylinders)) {
      run_.turn(random_.chance(0.5) ? -lane_.along : dvec3(lane_.along.y, lane_.along.x, 0.0) * side());
      straight(2.0 * radius());
    }
    close();
  }

  /// The direction into the block, away from its nearer edge: pipes may not leave the site.
  double side() const { return glm::dot(run_.at(), dvec3(lane_.along.y, lane_.along.x, 0.0)) > 0.0 ? -1.0 : 1.0; }

  void close() {
    if (has(kOthers) && wanted() == kOthers) {
      run_.cap();
    } else if (has(kCylinders)) {
      flange();
    }
  }

  void end() {
    if (has(kTori, 2) && has(kCylinders, 3) && lane_.drop > 4.0 * run_.bend() && random_.chance(0.45))
      return end_downwards();
    if (has(kTori) && has(kCylinders, 2) && lane_.clearance > 1.5 * run_.bend() && random_.chance(0.5)) {
      end_upwards();
    } else {
      straight(std::min(left(), 3.0 * radius()));
    }
    close();
  }

  Stage& stage_;
  Random& random_;
  const Lane& lane_;
  PipeRun run_;
  bool ended_ = false;
};

}  // namespace

void lay_pipe(Stage& stage, Random& random, const Lane& lane) {
  PipeBuilder(stage, random, lane).build();
}

}  // namespace sightline::importers::plant
