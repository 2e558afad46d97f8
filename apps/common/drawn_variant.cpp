#include "sightline/apps/common/drawn_variant.h"

#include <cmath>

#include "sightline/apps/common/statistics.h"
#include "sightline/core/internal/clock.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"

namespace sightline::apps {

core::Expected<DrawnImage> read_image(engine::Engine& engine, const core::View& view) {
  auto colour = engine.read_colour();
  if (!colour) return tl::unexpected(colour.error());
  auto ids = engine.read_ids();
  if (!ids) return tl::unexpected(ids.error());
  auto depth = engine.read_depth(view);
  if (!depth) return tl::unexpected(depth.error());
  return DrawnImage{{std::move(*ids), std::move(*depth)}, std::move(*colour)};
}

core::Expected<WrongItems> wrong_items(const image::ItemDepths& reference, const image::ItemDepths& image) {
  constexpr double kSameDepth = 1e-5;  // relative; float depths of touching faces differ by some 1e-7
  const auto wrong = image::wrong_ids(reference.ids, image.ids);
  if (!wrong) return tl::unexpected(wrong.error());
  WrongItems found{*wrong};
  for (std::size_t i = 0; i < reference.ids.ids.size(); ++i) {
    const double depth = reference.depth.metres[i], other = image.depth.metres[i];
    found.ties += reference.ids.ids[i] != image.ids.ids[i] && std::abs(depth - other) <= kSameDepth * depth;
  }
  return found;
}

core::Expected<ImageErrors> image_errors(const DrawnImage& reference, const DrawnImage& image) {
  const auto metrics = image::image_metrics(reference.colour, image.colour);
  if (!metrics) return tl::unexpected(metrics.error());
  const auto wrong = wrong_items(reference, image);
  if (!wrong) return tl::unexpected(wrong.error());
  return ImageErrors{*metrics, *wrong, double(wrong->wrong_ids) / double(reference.ids.ids.size())};
}

core::Expected<std::vector<double>> medians(core::Expected<std::vector<std::vector<double>>> samples) {
  if (!samples) return tl::unexpected(samples.error());
  std::vector<double> medians;
  for (auto& of_one : *samples) medians.push_back(median(std::move(of_one)));
  return medians;
}

core::Expected<DrawnVariant> DrawnVariant::create(std::shared_ptr<core::Scene> scene, engine::EngineConfig config) {
  config.draw = true;
  config.drawing.ids = true;
  DrawnVariant variant;
  variant.scene_ = std::move(scene);
  auto engine = engine::Engine::create(*variant.scene_, config);
  if (!engine) return tl::unexpected(engine.error());
  variant.engine_ = std::make_unique<engine::Engine>(std::move(*engine));
  if (auto built = variant.engine_->finish_levels(); !built) return tl::unexpected(built.error());
  return variant;
}

core::Expected<double> DrawnVariant::draw(const core::View& view) {
  engine_->finish();
  const double begin = core::now_seconds();
  const auto frame = engine_->frame(view);
  if (!frame) return tl::unexpected(frame.error());
  if (!frame->drawn) return core::fail("the GL context was lost");
  engine_->finish();
  const double end = core::now_seconds();
  items_drawn_ = frame->items_drawn;
  while (const auto late = engine_->take_late_report())
    if (late->frame == frame->frame) items_drawn_ = late->items_drawn;
  return 1e3 * (end - begin);
}

std::size_t DrawnVariant::gpu_bytes() {
  return engine_->memory().gpu - engine::EngineParts::drawing(*engine_)->target().memory_bytes();
}

core::Expected<std::vector<double>> time_in_turns(std::vector<DrawnVariant>& variants, const core::View& view,
                                                  int passes) {
  return medians(in_turns(variants.size(), passes, 1, [&](std::size_t i) { return variants[i].draw(view); }));
}

}  // namespace sightline::apps
