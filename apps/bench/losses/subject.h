// An engine that draws a model by rules, one image at a time. Internal to sightline-bench contribution and lod.
#pragma once

#include <memory>
#include <vector>

#include "sightline/apps/bench/error_time/comparison.h"
#include "sightline/apps/bench/losses/level_chain.h"
#include "sightline/apps/bench/losses/rules.h"
#include "sightline/apps/bench/losses/surface_error.h"
#include "sightline/apps/common/drawn_variant.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/engine/drawing/internal/frame.h"
#include "sightline/engine/engine.h"
#include "sightline/gl/context.h"

namespace sightline::bench {

class Subject {
 public:
  struct Config {
    int width, height;
    gl::ContextPlatform platform;
  };
  /// Commits the scene, which must outlive the subject. With a `chain`, the scene is that of the chain.
  Subject(core::Scene& scene, const Config& config, const LevelChain* chain = nullptr);
  Subject(const Subject&) = delete;
  Subject& operator=(const Subject&) = delete;

  /// Whether any mesh has levels.
  bool has_levels();
  engine::Engine& engine() { return engine_; }
  const core::VisibleSet& visible() const { return visible_; }  ///< of the last draw()
  const engine::DrawCounts& counts() const { return counts_; }  ///< of the last draw()

  /// Until the image is complete, culling included.
  core::Expected<Took> draw(const Rule& rule, const core::View& view);
  /// Draws again after a frame that does not count, which tells the occlusion passes what was visible.
  core::Expected<Took> draw_again(const Rule& rule, const core::View& view);
  /// Reads the last image. `original`: the model's item of each item, by id; empty: itself.
  apps::DrawnImage image(const core::View& view, const std::vector<core::ItemId>& original);

 private:
  engine::Engine engine_;
  const LevelChain* chain_;
  culling::CpuCuller culler_;                     // of the model
  std::unique_ptr<culling::Hierarchy> of_chain_;  // of all levels
  core::VisibleSet visible_, large_;
  engine::DrawCounts counts_;
  std::vector<std::uint64_t> lines_;  // a bit per slot
};

}  // namespace sightline::bench
