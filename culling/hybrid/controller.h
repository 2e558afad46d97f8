// Which path culls the next frame, the CPU's or the GPU's: pure logic, fed with measured times, without GL or a clock
// of its own. Estimates what either path would cost and takes the cheaper one. docs/results/hybrid.md has the formulas
// and how close it comes to the best choice of every frame.
//
//   controller.scene_changed(items); controller.gpu_ready();
//   loop: path = controller.next(); …cull and draw…; controller.feed(what is known by now of this and earlier frames);
#pragma once

#include <array>
#include <cstdint>

#include "sightline/core/api.h"
#include "sightline/culling/hybrid/cost_table.h"
#include "sightline/culling/hybrid/frame_sample.h"

namespace sightline::culling {

struct ControllerConfig {
  /// The cost that counts: the measured frame time with rendering on, the cull time with rendering off.
  bool rendering = true;
  /// With rendering off: no GPU culls in less time than this, in milliseconds. A CPU that does needs no probe of the
  /// GPU.
  double least_gpu_cull_ms = 0.01;
  /// Switches when the other path is cheaper by this share. If negative: unless it is more expensive by this share.
  double margin = 0.01;
  double dwell_margin = 0.20;          ///< soon after a switch: by this share, or less if it is clearly no noise
  std::uint32_t dwell_frames = 8;      ///< what counts as soon; grows up to 32-fold while switches prove vain
  double probe_share = 0.005;          ///< largest share of frames that are probes of the other path
  std::uint32_t first_probes = 2;      ///< but this many probes are always allowed
  double probe_cost = 0.004;           ///< unprovoked probes may lengthen the sum of all frames by this share
  std::uint32_t probe_interval = 200;  ///< frames between unprovoked probes
  std::uint32_t silent_frames = 16;    ///< frames on the GPU without a sample, after which it is given up
  /// Share by which frames of the GPU path are presumed to be more expensive, until some ten measured ones show
  /// otherwise. 0: nothing is presumed, and a path is tried wherever it is not known to be more expensive. Meant for
  /// software rasterisers, where the CPU's cores do the GPU's work: there such trials are only ever lost. With
  /// rendering off, GPU frames on these have no clock that could show otherwise, so the GPU path is then never taken.
  double presumed_gpu_excess = 0.0;
  friend bool operator==(const ControllerConfig&, const ControllerConfig&) = default;
};

/// Deterministic: the same calls give the same paths. Allocates nothing; copies are independent. Starts on the CPU, and
/// stays there until gpu_ready(). Each path has a table of log(cost) against visible items (position()). A median of
/// three filters the samples. A cumulative sum (Page 1954) of the residuals tells a change of regime from noise within
/// a few frames; the table then restarts from the new level.
class SIGHTLINE_API Controller {
 public:
  explicit Controller(const ControllerConfig& config = {});

  /// The path of the next frame. Frames are numbered 0, 1, … by the calls.
  CullPath next();

  /// Takes what was measured in a frame, as soon as it is known. Samples of GPU frames come late, and some never come.
  /// Samples of frames not yet begun, older than the newest one of their path, or older than kOldestSample frames are
  /// ignored; so is each figure that is not finite and positive.
  void feed(const FrameSample& sample);

  /// The scene has changed (a commit, a new generation) and has so many items now. What was learnt is only a first
  /// guess from here on. Call it before the first frame, too. 0: the number is not known.
  void scene_changed(double items);
  /// The application stood still (a pause, a dialog, a breakpoint): frames up to the next one are not measured.
  void paused();
  /// The GPU path is unavailable: the CPU culls every frame.
  void gpu_lost();
  /// The GPU path is available (again) and warmed up: shaders compiled, buffers filled.
  void gpu_ready();

  /// Frames so far.
  std::uint64_t frames() const { return frames_; }
  /// Changes of the path, without probes.
  std::uint64_t switches() const { return switches_; }
  /// Probes: frames taken on the other path only to measure it.
  std::uint64_t probes() const { return probes_; }
  ControllerState state() const;

 private:
  struct Side {
    CostTable table;
    std::array<double, 3> residuals{};  // of the last samples
    double noise = 0.2;                 // standard deviation of log(cost)
    double sums[2] = {0.0, 0.0};        // of residuals beyond the slack: upward, downward
    int runs[2] = {0, 0};               // samples in these sums
    std::uint64_t measured = 0;         // frame after the last sample
    std::uint64_t shifted = 0;          // frame of the last change of regime
    std::uint64_t risen_at = 0;         // frames_ at the last upward change
    double rise = 0.0;                  // size of the last upward change
    bool recovers = false;              // a sample has since shown that the rise is over
    bool on_trial = false;              // path taken for that reason; no sample yet
  };

  /// Nothing can be learnt: the CPU path is always taken.
  bool settled() const { return config_.presumed_gpu_excess > 0.0 && !config_.rendering; }
  Side& side(CullPath path) { return sides_[std::size_t(path)]; }
  double position(double visible) const;
  double predict(CullPath path) { return side(path).table.predict(x_); }
  double predict_other();
  double dwell_margin() const;
  double doubt(CullPath path);
  void learn(CullPath path, double log_cost, double x, std::uint64_t frame);
  double filter(Side& s, double residual, bool fresh) const;
  void detect_change(CullPath path, double filtered, double x, std::uint64_t frame, bool away);
  void change_regime(CullPath path, double shift, double x, std::uint64_t frame, bool away);
  void decide();
  void switch_to(CullPath path, double gap);
  bool try_recovered(double own, double theirs);
  bool wants_probe(double own, double excess) const;

  ControllerConfig config_;
  std::array<Side, 2> sides_;
  CullPath path_ = CullPath::kCpu;
  bool gpu_ = false, probing_ = false;
  bool risen_ = false;  // the path taken has become more expensive: the other one is worth a probe
  double items_ = 0.0;  // of the scene; 0: unknown
  double x_ = 0.0;      // position() of the newest frame whose visible items are known
  std::uint64_t visible_frame_ = 0;
  std::uint64_t frames_ = 0, since_switch_ = 0, last_probe_ = 0, check_at_ = 0;
  std::uint64_t measured_from_ = 0;   // earlier frames are not measured
  std::uint64_t newest_[2] = {0, 0};  // frame after the newest sample, per path
  std::uint32_t dwell_;
  int persistence_ = 0;  // > 0: jumps have lasted, so one sample suffices; otherwise two in a row are needed
  double excess_ = 0.0;  // extra cost of all probes, in frames of the path taken
  std::uint64_t switches_ = 0, probes_ = 0;
};

}  // namespace sightline::culling
