#include "sightline/culling/hybrid/controller.h"

#include <algorithm>
#include <cmath>

namespace sightline::culling {
namespace {

// Limits between which the measured spread of log(cost) is used.
constexpr double kLeastNoise = 0.02, kMostNoise = 0.4;
// The cumulative sum's slack and threshold, in standard deviations; half a deviation is the usual slack, and five make
// false alarms rarer than one in 400 samples of independent noise.
constexpr double kSlack = 0.5, kThreshold = 5.0;
// A sample this many deviations off is a jump: a spike, or the first of another regime.
constexpr double kJump = 3.0;
// When a path was not measured for so many frames, its last residuals say nothing about the next one.
constexpr std::uint64_t kAway = 8;
// How far the cost of the path not taken may lie below its estimate: for the standard error, and for what was learnt
// octaves away. Then it is taken, and known better.
constexpr double kMostOptimism = 0.25, kMostFarOptimism = 1.0, kOptimismPerOctave = 0.2;
// Limit of the count of jumps that lasted minus spikes.
constexpr int kMostPersistence = 2;
// A difference of so many standard errors is no noise.
constexpr double kClear = 3.0;
// Number of samples that the presumption about a path counts for.
constexpr double kPresumed = 8.0;
// Frames within which a probe's sample comes.
constexpr std::uint64_t kAnswer = 6;
// A path that was left because it had become more expensive is probed again after so many frames: it may have been a
// hiccup.
constexpr std::uint64_t kCheck = 16;
// When the path taken has become more expensive, a probe of the other path may cost at most so many extra frames of the
// path taken.
constexpr double kClose = 1.5;
// A probe that was not saved for may cost at most so many frames.
constexpr double kWorthwhile = 32.0;

double median(const std::array<double, 3>& v) {
  return std::max(std::min(v[0], v[1]), std::min(std::max(v[0], v[1]), v[2]));
}

double least(const std::array<double, 3>& v) {
  return *std::min_element(v.begin(), v.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
}

}  // namespace

Controller::Controller(const ControllerConfig& config) : config_(config), dwell_(config.dwell_frames) {}

CullPath Controller::next() {
  ++frames_;
  ++since_switch_;
  probing_ = false;
  if (gpu_ && !settled()) decide();
  return probing_ ? other(path_) : path_;
}

void Controller::decide() {
  Side& mine = side(path_);
  Side& theirs = side(other(path_));
  if (path_ == CullPath::kGpu && since_switch_ > config_.silent_frames &&
      frames_ - mine.measured > config_.silent_frames) {  // its samples are missing
    mine = Side();
    switch_to(CullPath::kCpu, 0.0);
    last_probe_ = frames_;
    return;
  }
  if (mine.table.empty()) return;
  const double own = predict(path_);
  double excess = 0.0;
  if (!theirs.table.empty()) {
    const double cost = predict_other();
    const double gap = own - cost + std::max(0.0, doubt(other(path_)) - doubt(path_));
    if (gap > (since_switch_ <= dwell_ ? dwell_margin() : config_.margin)) {
      switch_to(other(path_), gap);
      return;
    }
    if (try_recovered(own, cost)) return;
    excess = std::max(0.0, std::exp(cost - own) - 1.0);
  }
  if (!wants_probe(own, excess)) return;
  probing_ = true;
  risen_ = false;
  check_at_ = 0;
  last_probe_ = frames_;
  excess_ += excess;
  ++probes_;
}

/// The margin soon after a switch: the difference that noise alone may cause, as far as it is known. So a path that was
/// tried and is clearly worse is left at once.
double Controller::dwell_margin() const {
  const auto samples = [&](const Side& s) { return std::max(1.0, s.table.samples(x_)); };
  const double noise = std::min(sides_[0].noise, sides_[1].noise);  // of the path known for longer
  const double error = noise * std::sqrt(1.0 / samples(sides_[0]) + 1.0 / samples(sides_[1]));
  return std::clamp(kClear * error, config_.margin, config_.dwell_margin);
}

/// What the path not taken would cost, from what was measured and what is presumed.
double Controller::predict_other() {
  const double measured = predict(other(path_));
  if (config_.presumed_gpu_excess == 0.0) return measured;
  const double excess = std::log1p(config_.presumed_gpu_excess);
  const double presumed = predict(path_) + (path_ == CullPath::kCpu ? excess : -excess);
  const double samples = side(other(path_)).table.samples(x_);
  return (samples * measured + kPresumed * presumed) / (samples + kPresumed);
}

/// How far log(cost) may lie below the estimate: the standard error, and where the estimate was learnt at other numbers
/// of visible items, what these may change.
double Controller::doubt(CullPath path) {
  const Side& s = side(path);
  const double presumed = config_.presumed_gpu_excess == 0.0 ? 0.0 : kPresumed;
  const double error = std::min(kMostOptimism, s.noise / std::sqrt(std::max(s.table.samples(x_) + presumed, 0.1)));
  if (presumed > 0.0) return error;
  return error + std::min(kMostFarOptimism, kOptimismPerOctave * s.table.distance(x_));
}

/// Switches at once when the path taken has become more expensive, and the other one, left for the same reason, was
/// then found cheap again.
bool Controller::try_recovered(double own, double theirs) {
  Side& s = side(other(path_));
  if (!risen_ || !s.recovers || theirs - s.rise > own - config_.dwell_margin) return false;
  s.table.shift(x_, -s.rise);
  s.on_trial = true;
  switch_to(other(path_), s.rise);
  return true;
}

/// `excess`: the probe's expected cost beyond that of the path taken, in frames of that path.
bool Controller::wants_probe(double own, double excess) const {
  const Side& mine = sides_[std::size_t(path_)];
  const Side& theirs = sides_[std::size_t(other(path_))];
  if (path_ == CullPath::kCpu && !config_.rendering && std::exp(own) < config_.least_gpu_cull_ms) return false;
  if (frames_ - last_probe_ < kAnswer && last_probe_ > 0) return false;
  const double allowed = config_.probe_share * double(frames_), taken = double(probes_ + 1);
  const double free = double(config_.first_probes);
  const bool check = check_at_ > 0 && frames_ >= check_at_;
  if ((risen_ && excess < kClose) || (check && excess < kWorthwhile)) return taken <= std::max(free, allowed);
  if (theirs.table.empty() && probes_ == 0) return !mine.table.empty();
  if (persistence_ < 0 && probes_ == 1 && excess < kWorthwhile) return true;  // was that one a spike?
  if (frames_ - std::max(theirs.measured, last_probe_) < config_.probe_interval) return false;
  return taken <= allowed - (free - 1.0) && excess_ + excess <= config_.probe_cost * double(frames_);
}

/// Switches for small gaps in quick succession are vain: noise.
void Controller::switch_to(CullPath path, double gap) {
  const bool vain = gap < config_.dwell_margin && since_switch_ < 4u * dwell_;
  if (vain)
    dwell_ = std::min(2 * dwell_, 32 * config_.dwell_frames);
  else if (since_switch_ > 8u * dwell_)
    dwell_ = config_.dwell_frames;
  const Side& left = side(path_);
  check_at_ = left.risen_at > 0 && frames_ - left.risen_at <= 2 * kCheck ? frames_ + kCheck : 0;
  path_ = path;
  since_switch_ = 0;
  risen_ = false;
  ++switches_;
}

/// Octaves of visible items; from half of the scene on, continued by octaves of hidden ones. The CPU's cost rises with
/// the number of visible items, and falls again as whole subtrees are inside.
double Controller::position(double visible) const {
  if (visible <= 0.5 * items_ || items_ <= 0.0) return std::log2(1.0 + visible);
  return 2.0 * std::log2(1.0 + 0.5 * items_) - std::log2(1.0 + std::max(0.0, items_ - visible));
}

void Controller::feed(const FrameSample& sample) {
  std::uint64_t& newest = newest_[sample.path == CullPath::kGpu];
  if (sample.frame >= frames_ || sample.frame < newest || sample.frame < measured_from_) return;
  if (frames_ - sample.frame > kOldestSample) return;
  newest = sample.frame + 1;
  if (settled()) return;
  double x = x_;
  if (std::isfinite(sample.visible) && sample.visible >= 0.0) {
    x = position(sample.visible);
    if (sample.frame >= visible_frame_) {
      x_ = x;
      visible_frame_ = sample.frame;
    }
  }
  const double cost = config_.rendering ? sample.frame_ms : sample.cull_ms;
  if (is_measured(cost)) learn(sample.path, std::log(cost), x, sample.frame);
}

void Controller::learn(CullPath path, double log_cost, double x, std::uint64_t frame) {
  Side& s = side(path);
  const bool away = frame - s.measured >= kAway;
  s.measured = frame + 1;
  if (s.table.empty()) {
    s.table.learn(x, log_cost);
    return;
  }
  const double residual = log_cost - s.table.predict(x);
  if (s.table.samples(x) < 0.75) {  // nothing learnt here yet
    s.table.learn(x, residual);
    s.residuals = {};
    return;
  }
  const double filtered = filter(s, residual, away);
  const double noise = std::min(1.25 * std::abs(residual), kJump * s.noise);
  s.noise = std::clamp(s.noise + (noise - s.noise) / 16.0, kLeastNoise, kMostNoise);
  detect_change(path, filtered, x, frame, away);
}

/// Normally the median of the last three residuals. Where jumps have been spikes: the least. Where jumps have lasted,
/// or there are no other residuals: the newest.
double Controller::filter(Side& s, double residual, bool fresh) const {
  const bool jump = std::abs(residual) > std::max(kJump * s.noise, config_.dwell_margin);
  if (fresh || (jump && persistence_ > 0)) {
    s.residuals = {};
    return residual;
  }
  s.residuals = {s.residuals[1], s.residuals[2], residual};
  return persistence_ < 0 ? least(s.residuals) : median(s.residuals);
}

/// Page's test on the filtered residuals; without a change, they are learnt.
void Controller::detect_change(CullPath path, double filtered, double x, std::uint64_t frame, bool away) {
  Side& s = side(path);
  const double slack = kSlack * s.noise, threshold = kThreshold * s.noise;
  for (int down = 0; down < 2; ++down) {
    const double sign = down ? -1.0 : 1.0;
    s.sums[down] = std::max(0.0, s.sums[down] + sign * filtered - slack);
    s.runs[down] = s.sums[down] > 0.0 ? s.runs[down] + 1 : 0;
    if (s.sums[down] > threshold) {
      change_regime(path, sign * (slack + s.sums[down] / s.runs[down]), x, frame, away);
      return;
    }
  }
  const double jump = s.residuals[1];  // a lone jump between its neighbours?
  if (std::abs(jump) > std::max(kJump * s.noise, config_.dwell_margin) &&
      std::abs(s.residuals[2]) < 0.5 * std::abs(jump))
    persistence_ = std::max(-kMostPersistence, persistence_ - 1);
  s.on_trial = false;
  s.table.learn(x, filtered);
}

void Controller::change_regime(CullPath path, double shift, double x, std::uint64_t frame, bool away) {
  Side& s = side(path);
  if (frame - s.shifted <= 2 && shift < 0.0)  // it was a spike after all
    persistence_ = -kMostPersistence;
  else if (!away && std::abs(shift) > config_.dwell_margin)
    persistence_ = std::min(kMostPersistence, persistence_ + 1);
  if (shift > 0.0) {
    s.rise = shift;
    s.risen_at = frames_;
    if (s.on_trial) s.recovers = false;
    risen_ = risen_ || (path == path_ && shift > config_.dwell_margin);
  } else {
    s.recovers = s.recovers || (s.rise > 0.0 && -shift > 0.5 * s.rise);
  }
  s.on_trial = false;
  s.shifted = frame;
  s.table.shift(x, shift);
  s.residuals = {};
  s.sums[0] = s.sums[1] = 0.0;
  s.runs[0] = s.runs[1] = 0;
  side(other(path)).table.doubt(2.0);
}

void Controller::scene_changed(double items) {
  items_ = is_measured(items) ? items : 0.0;
  for (Side& s : sides_) {
    s.table.doubt(0.5);
    s.recovers = false;
  }
  risen_ = true;
}

void Controller::paused() {
  measured_from_ = frames_ + 1;
}

void Controller::gpu_lost() {
  gpu_ = false;
  if (path_ == CullPath::kGpu) switch_to(CullPath::kCpu, 0.0);
  side(CullPath::kGpu).table.doubt(1.0);
}

void Controller::gpu_ready() {
  gpu_ = true;
  side(CullPath::kGpu).table.doubt(1.0);
}

ControllerState Controller::state() const {
  if (probing_) return ControllerState::kProbe;
  return path_ == CullPath::kCpu ? ControllerState::kCpu : ControllerState::kGpu;
}

}  // namespace sightline::culling
