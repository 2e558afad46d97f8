// Flies one camera path with each culler of the engine, and records the cost of frames.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/scene.h"
#include "sightline/core/view.h"
#include "sightline/engine/engine.h"
#include "sightline/gl/context.h"

namespace sightline::bench {

struct HybridMode {
  const char* name;
  engine::CullerChoice culler;
};
/// The first two are the fixed paths.
inline constexpr HybridMode kHybridModes[] = {{"cpu", engine::CullerChoice::kCpu},
                                              {"gpu", engine::CullerChoice::kGpu},
                                              {"hybrid", engine::CullerChoice::kHybrid}};
inline constexpr std::size_t kModes = std::size(kHybridModes);

struct HybridFrame {
  double cull_ms = 0.0;       ///< CPU time of culling; on the GPU's path the time to submit
  double gpu_cull_ms = -1.0;  ///< on the GPU's clock; -1: not on its path, or no clock
  double frame_ms = 0.0;      ///< from its beginning to the beginning of the next one
  double thread_ms = 0.0;     ///< processor time of the calling thread in Engine::frame
  std::int64_t visible = -1;
  bool on_gpu = false;

  /// Cost of the frame with rendering on, otherwise of culling. Without a GPU clock the GPU's culling costs the whole
  /// frame, since the frame then contains nothing else.
  double cost(bool rendering) const {
    if (rendering || (on_gpu && gpu_cull_ms < 0.0)) return frame_ms;
    return on_gpu ? gpu_cull_ms : cull_ms;
  }
};

struct HybridFlight {
  std::vector<HybridFrame> frames;
  std::uint64_t switches = 0, probes = 0;
  std::string gpu_variant;  ///< of the GPU culler, where there is one
  std::string culler;       ///< the culler in the plan: a hybrid of a small scene is "cpu"
};

struct FlightConfig {
  bool rendering = true;
  int width = 1280, height = 720;
  int warm_up = 10;  ///< frames of the first view before the first counted one
  int block = 10;    ///< frames that one engine flies in a row
  std::optional<culling::GpuVariant> gpu = {};
  engine::OcclusionChoice occlusion = engine::OcclusionChoice::kAutomatic;
};

/// An engine that flies a path block by block, with pauses between blocks.
class Pilot {
 public:
  /// Several pilots may use one context, which must be current and outlive them.
  Pilot(core::Scene& scene, const HybridMode& mode, const FlightConfig& config, gl::Context& context);

  /// Flies the frames of `views`, which count. `lead_in` frames of the first view come before, so that as many frames
  /// are in flight as later, and one frame after ends the last. Neither counts. Waits until all is drawn.
  void fly(std::span<const core::View> views, int lead_in);
  HybridFlight land() &&;

 private:
  void frame(const core::View& view, bool counts);
  void take_late();

  engine::Engine engine_;
  std::vector<HybridFrame> frames_;
  std::vector<std::size_t> place_;  // place in frames_ of each frame of the engine; core::kNone: does not count
};

/// All flights of one model with rendering on, or off: flights[mode][pass].
struct HybridRun {
  std::string model;
  std::size_t items = 0;
  double seconds = 60.0;  ///< intended duration of the path
  bool rendering = true;
  std::vector<std::vector<HybridFlight>> flights;

  std::size_t frames() const { return flights[0][0].frames.size(); }
  /// For each frame the median over the passes.
  std::vector<double> costs(std::size_t mode) const;
  /// The fixed path with the lower sum of costs().
  std::size_t better_path() const;
  /// Median over the passes of this flight's cost divided by the cost of the other mode's flight in the same pass.
  double ratio(std::size_t mode, std::size_t other) const;
};

/// Flies all modes in turns, block by block and in another order each pass, so that other load of the machine affects
/// all equally. Each pass uses new engines: a hybrid has learnt nothing.
HybridRun fly_in_turns(core::Scene& scene, const FlightConfig& config, gl::Context& context,
                       std::span<const core::View> views, int passes, const std::function<void(int)>& progress);

}  // namespace sightline::bench
