#include "sightline/apps/common/drawn_variant.h"

#include <chrono>
#include <cmath>

#include "sightline/apps/common/statistics.h"
#include "sightline/engine/drawing/internal/drawing.h"

namespace sightline::apps {
namespace {

double milliseconds() {
  using Clock = std::chrono::steady_clock;
  return std::chrono::duration<double, std::milli>(Clock::now().time_since_epoch()).count();
}

}  // namespace

std::uint64_t count_ties(const DrawnImage& a, const DrawnImage& b) {
  constexpr double kSameDepth = 1e-5;  // relative; float depths of touching faces differ by some 1e-7
  std::uint64_t ties = 0;
  for (std::size_t i = 0; i < a.ids.ids.size(); ++i) {
    const double za = a.depth.metres[i], zb = b.depth.metres[i];
    ties += a.ids.ids[i] != b.ids.ids[i] && std::abs(za - zb) <= kSameDepth * za;
  }
  return ties;
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
  const double begin = milliseconds();
  const auto frame = engine_->frame(view);
  if (!frame) return tl::unexpected(frame.error());
  engine_->finish();
  items_drawn_ = frame->items_drawn;
  return milliseconds() - begin;
}

core::Expected<DrawnImage> DrawnVariant::image(const core::View& view) {
  auto colour = engine_->read_colour();
  if (!colour) return tl::unexpected(colour.error());
  auto ids = engine_->read_ids();
  if (!ids) return tl::unexpected(ids.error());
  auto depth = engine_->read_depth(view);
  if (!depth) return tl::unexpected(depth.error());
  return DrawnImage{std::move(*colour), std::move(*ids), std::move(*depth)};
}

std::size_t DrawnVariant::gpu_bytes() {
  return engine_->memory().gpu - engine_->drawing()->target().memory_bytes();
}

core::Expected<std::vector<double>> time_in_turns(std::span<DrawnVariant> variants, const core::View& view,
                                                  int passes) {
  std::vector<std::vector<double>> times(variants.size());
  for (int pass = -1; pass < passes; ++pass)
    for (std::size_t i = 0; i < variants.size(); ++i) {
      auto ms = variants[i].draw(view);
      if (!ms) return tl::unexpected(ms.error());
      if (pass >= 0) times[i].push_back(*ms);
    }
  std::vector<double> medians;
  medians.reserve(times.size());
  for (auto& of_variant : times) medians.push_back(median(std::move(of_variant)));
  return medians;
}

}  // namespace sightline::apps
