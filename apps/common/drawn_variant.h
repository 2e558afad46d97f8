// Error against time: ways to draw a model, timed in turns and compared image by image.
#pragma once

#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "sightline/core/scene.h"
#include "sightline/engine/engine.h"
#include "sightline/render/image/image_metrics.h"

namespace sightline::apps {

struct DrawnImage : image::ItemDepths {
  image::Image colour;
};
/// Reads the last image of an engine with ids. `view` is the one that was drawn.
core::Expected<DrawnImage> read_image(engine::Engine& engine, const core::View& view);

/// Pixels that show another item than the reference.
struct WrongItems {
  std::uint64_t wrong_ids = 0;
  /// Pixels of wrong_ids where both show the same depth: several items have one surface there, and any of them may be
  /// drawn.
  std::uint64_t ties = 0;
};
/// Fails when the sizes differ.
core::Expected<WrongItems> wrong_items(const image::ItemDepths& reference, const image::ItemDepths& image);

/// How far an image is from a reference.
struct ImageErrors : image::ImageMetrics, WrongItems {
  double wrong_share = 0.0;  ///< wrong_ids over all pixels
};
/// Fails when the sizes differ.
core::Expected<ImageErrors> image_errors(const DrawnImage& reference, const DrawnImage& image);

/// What measure(i) returns for each of `count` subjects in each of `passes`: samples[i][pass]. All subjects are
/// measured in turns, so that other load of the machine affects all equally. `warm_ups` passes come before and do not
/// count.
template <class Measure, class Sample = typename std::invoke_result_t<const Measure&, std::size_t>::value_type>
core::Expected<std::vector<std::vector<Sample>>> in_turns(std::size_t count, int passes, int warm_ups,
                                                          const Measure& measure) {
  std::vector<std::vector<Sample>> samples(count);
  for (int pass = -warm_ups; pass < passes; ++pass)
    for (std::size_t i = 0; i < count; ++i) {
      auto sample = measure(i);
      if (!sample) return tl::unexpected(std::move(sample.error()));
      if (pass >= 0) samples[i].push_back(std::move(*sample));
    }
  return samples;
}
/// Medians of numbers that are measured in turns.
core::Expected<std::vector<double>> medians(core::Expected<std::vector<std::vector<double>>> samples);

/// A scene and an engine that draws it.
class DrawnVariant {
 public:
  /// `config` names the context, which must be current and outlive this. Images have ids whatever it says.
  static core::Expected<DrawnVariant> create(std::shared_ptr<core::Scene> scene, engine::EngineConfig config);

  /// Draws a frame and returns the milliseconds until the image is complete.
  core::Expected<double> draw(const core::View& view);
  /// The last frame's image. `view` is the one that was drawn.
  core::Expected<DrawnImage> image(const core::View& view) { return read_image(*engine_, view); }
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

/// Median milliseconds of each variant's frames of one view over `passes`, in turns. A pass that does not count comes
/// first: it compiles.
core::Expected<std::vector<double>> time_in_turns(std::vector<DrawnVariant>& variants, const core::View& view,
                                                  int passes);

}  // namespace sightline::apps
