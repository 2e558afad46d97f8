#include "sightline/engine/drawing/internal/draw_strategy.h"

namespace sightline::engine {

core::Expected<DrawCounts> DrawAtOnce::draw(DrawContext& context, const DrawInput& input) {
  const auto& [view, snapshot, visible, lines, hierarchy] = input.candidates;
  const bool tests = context.config.culling.sample_test;
  if (tests) context.sample_test(view, snapshot.bounds()).filter(snapshot.bounds(), visible, sampled_, lines);
  const core::VisibleSet& shown = tests ? sampled_ : visible;
  const auto drawn = std::int64_t(snapshot.count(shown));
  if (auto done = context.draw(view, snapshot, shown); !done) return tl::unexpected(done.error());
  return DrawCounts{drawn, drawn};
}

/// The occlusion test includes the sample test: it rejects an item that covers no pixel centre, too. Section caps need
/// the clusters that are hidden: they count the crossings of rays.
core::Expected<DrawCounts> DrawInPasses::draw(DrawContext& context, const DrawInput& input) {
  const auto& [view, snapshot, visible, lines, hierarchy] = input.candidates;
  const core::ItemBounds& bounds = snapshot.bounds();
  ImageState& image = *context.image;
  const culling::OcclusionTest test = context.occlusion_test(view, bounds);
  context.clear_pyramid();
  image.passes.begin(visible, lines, hierarchy, context.threads);
  image.clusters.begin(test, bounds.origin, context.threads);
  if (auto done = context.clear(image.target); !done) return tl::unexpected(done.error());
  const auto draw_pass = [&context, &image, &culled = input.candidates](const core::VisibleSet& pass) {
    context.clusters = culled.view.sections.empty() ? &image.clusters : nullptr;
    auto done = context.draw_more(culled.view, culled.snapshot, pass, image.target);
    context.clusters = nullptr;
    return done ? context.read_back_depth(culled.view, image.target) : done;
  };
  for (int pass = 0; image.passes.next(test, bounds); ++pass) {
    if (auto done = draw_pass(image.passes.pass()); !done) return tl::unexpected(done.error());
    if (pass > 0) continue;
    again_.single_slots = image.clusters.begin_later_passes();
    again_.generation = visible.generation;
    if (again_.single_slots.empty()) continue;
    if (auto done = draw_pass(again_); !done) return tl::unexpected(done.error());
  }
  image.passes.remember(test, bounds);
  image.clusters.remember();
  image.pyramid_valid = true;
  return DrawCounts{-1, std::int64_t(image.passes.drawn())};
}

}  // namespace sightline::engine
