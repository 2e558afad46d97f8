// Several ways to draw a model, timed in turns and compared image by image.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sightline/core/scene.h"
#include "sightline/engine/engine.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {

struct DrawnImage {
  image::Image colour;
  image::IdImage ids;
  image::DepthImage depth;
};

/// Pixels where the images show different items at the same depth: several items have one surface there, and any of
/// them may be drawn. Sizes must be equal.
std::uint64_t count_ties(const DrawnImage& a, const DrawnImage& b);

/// A scene and an engine that draws it.
class DrawnVariant {
 public:
  /// `config` names the context, which must be current and outlive this. Images have ids whatever it says.
  static core::Expected<DrawnVariant> create(std::shared_ptr<core::Scene> scene, engine::EngineConfig config);

  /// Draws a frame and returns the milliseconds until the image is complete.
  core::Expected<double> draw(const core::View& view);
  /// The last frame's image. `view` is the one that was drawn.
  core::Expected<DrawnImage> image(const core::View& view);
  /// On the GPU, without the image.
  std::size_t gpu_bytes();
  const core::Scene& scene() const { return *scene_; }
  /// Items drawn in the last frame, -1 where only the GPU knows.
  std::int64_t items_drawn() const { return items_drawn_; }

 private:
  std::shared_ptr<core::Scene> scene_;  // must outlive the engine
  std::unique_ptr<engine::Engine> engine_;
  std::int64_t items_drawn_ = -1;
};

/// Median milliseconds of each variant's frames of one view over `passes`. Draws all variants in turns, so that other
/// load of the machine affects all equally. A pass that does not count comes first: it compiles.
core::Expected<std::vector<double>> time_in_turns(std::span<DrawnVariant> variants, const core::View& view, int passes);

}  // namespace sightline::apps
