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

/// The occlusion test includes the sample test: it rejects an item that covers no pixel centre, too.
core::Expected<DrawCounts> DrawInPasses::draw(DrawContext& context, const DrawInput& input) {
  const auto& [view, snapshot, visible, lines, hierarchy] = input.candidates;
  const core::ItemBounds& bounds = snapshot.bounds();
  ImageState& image = *context.image;
  const culling::OcclusionTest test = context.occlusion_test(view, bounds);
  context.clear_pyramid();
  image.passes.begin(visible, lines, hierarchy, context.threads);
  context.clear(image.target);
  while (image.passes.next(test, bounds)) {
    if (auto done = context.draw_more(view, snapshot, image.passes.pass(), image.target); !done)
      return tl::unexpected(done.error());
    context.read_back_depth(view, image.target);
  }
  image.passes.remember(test, bounds);
  image.pyramid_valid = true;
  return DrawCounts{-1, std::int64_t(image.passes.drawn())};
}

}  // namespace sightline::engine
