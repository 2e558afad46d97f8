// The hybrid culler's default policy: takes the cheaper path, by estimates learnt from measured times.
#pragma once

#include <array>
#include <cstdint>

#include "sightline/core/api.h"
#include "sightline/culling/hybrid/frame_sample.h"
#include "sightline/culling/hybrid/internal/cost_table.h"

namespace sightline::culling {

struct FrameCostConfig {
  /// The cost that counts: the measured frame time with rendering on, the cull time with rendering off.
  bool rendering = true;
  /// With rendering off: no GPU culls in less time than this, in milliseconds. A CPU that does needs no probe of the
  /// GPU.
  double least_gpu_cull_ms = 0.01;
  double margin = 0.01;                ///< switches when the other path is cheaper by this share
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
  friend bool operator==(const FrameCostConfig&, const FrameCostConfig&) = default;
};

/// See Controller for what the functions promise. Each path has a table of log(cost) against visible items
/// (position()). A median of three filters the samples. A cumulative sum (Page 1954) of the residuals tells a change of
/// regime from noise within a few frames; the table then restarts from the new level.
class SIGHTLINE_API FrameCost {
 public:
  explicit FrameCost(const FrameCostConfig& config) : config_(config), dwell_(config.dwell_frames) {}

  CullPath next();
  void feed(const FrameSample& sample);
  void scene_changed(double items);
  void set_gpu(bool ready);

  std::uint64_t switches() const { return switches_; }
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

  FrameCostConfig config_;
  std::array<Side, 2> sides_;
  CullPath path_ = CullPath::kCpu;
  bool gpu_ = false, probing_ = false;
  bool risen_ = false;  // the path taken has become more expensive: the other one is worth a probe
  double items_ = 0.0;  // of the scene; 0: unknown
  double x_ = 0.0;      // position() of the newest frame whose visible items are known
  std::uint64_t visible_frame_ = 0;
  std::uint64_t frames_ = 0, since_switch_ = 0, last_probe_ = 0, check_at_ = 0;
  std::uint32_t dwell_;
  int persistence_ = 0;  // > 0: jumps have lasted, so one sample suffices; otherwise two in a row are needed
  double excess_ = 0.0;  // extra cost of all probes, in frames of the path taken
  std::uint64_t switches_ = 0, probes_ = 0;
};

}  // namespace sightline::culling
