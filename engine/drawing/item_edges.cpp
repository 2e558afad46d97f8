#include "sightline/engine/drawing/internal/item_edges.h"

#include <span>
#include <utility>

namespace sightline::engine {

core::Expected<void> ItemEdges::draw(DrawContext& context, const Frame& frame, const core::VisibleSet& items) {
  const Edges& edges = context.config.drawing.looks.edges;
  slots_.clear();
  items.for_each_slot([&](core::Slot slot) {
    if (!frame.snapshot.vacant(slot)) slots_.push_back(slot);
  });
  lists_.update(frame.snapshot, slots_, frame.view, context.target().height(), edges, context.threads);
  if (!pass_) pass_.emplace(context.gl());
  if (std::exchange(generation_, lists_.generation()) != lists_.generation()) pass_->clear();
  if (auto done = pass_->add(std::span(lists_.segments()).subspan(pass_->size())); !done) return done;
  return pass_->draw(
      context.target(), frame.view, lists_.meshes(), lists_.curves(),
      {.width = edges.width, .colour = edges.colour, .surface_error = float(context.config.losses.lod_error)});
}

}  // namespace sightline::engine
