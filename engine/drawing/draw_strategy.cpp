#include "sightline/engine/drawing/internal/draw_strategy.h"

namespace sightline::engine {

core::Expected<DrawCounts> DrawAtOnce::draw(DrawContext& context, const Frame& frame,
                                            const core::VisibleSet& candidates) {
  const core::ItemBounds& bounds = frame.snapshot.bounds();
  const bool tests = context.config.culling.sample_test;
  if (tests) context.sample_test(frame).filter(bounds, candidates, sampled_, frame.lines, &context.threads);
  const core::VisibleSet& left = tests ? sampled_ : candidates;
  const auto drawn = std::int64_t(frame.snapshot.count(left));
  auto done = context.clear(context.target());
  if (done) done = context.draw(frame, {left, context.target()});
  return done.map([drawn] { return DrawCounts{drawn, drawn}; });
}

/// The occlusion test includes the sample test: it rejects an item that covers no pixel centre, too. Section caps need
/// the clusters that are hidden: they count the crossings of rays.
core::Expected<DrawCounts> DrawInPasses::draw(DrawContext& context, const Frame& frame,
                                              const core::VisibleSet& candidates) {
  const core::ItemBounds& bounds = frame.snapshot.bounds();
  ImageState& image = *context.image;
  const culling::OcclusionTest test = context.occlusion_test(frame);
  context.clear_pyramid();
  image.passes.begin(candidates, frame.lines, frame.hierarchy, context.threads);
  image.clusters.begin(test, bounds.origin, context.threads);
  if (auto done = context.clear(image.target); !done) return tl::unexpected(done.error());
  const auto draw_pass = [&](const core::VisibleSet& pass) {
    auto done = context.draw(frame, {pass, image.target, frame.view.sections.empty() ? &image.clusters : nullptr});
    return done ? context.read_back_depth(frame.view, image.target) : done;
  };
  for (int pass = 0; image.passes.next(test, bounds); ++pass) {
    if (auto done = draw_pass(image.passes.pass()); !done) return tl::unexpected(done.error());
    if (pass > 0) continue;
    again_.single_slots = image.clusters.begin_later_passes();
    again_.generation = candidates.generation;
    if (again_.single_slots.empty()) continue;
    if (auto done = draw_pass(again_); !done) return tl::unexpected(done.error());
  }
  image.passes.remember(test, bounds);
  image.clusters.remember();
  image.pyramid_valid = true;
  return DrawCounts{-1, std::int64_t(image.passes.drawn())};
}

}  // namespace sightline::engine
