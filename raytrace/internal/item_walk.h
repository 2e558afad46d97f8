// The way of a ray through a hierarchy over items. Internal to raytrace.
#pragma once

#include <algorithm>

#include "sightline/core/item_bounds.h"
#include "sightline/core/ray.h"
#include "sightline/raytrace/internal/item_trees.h"
#include "sightline/raytrace/internal/kernels.h"
#include "sightline/raytrace/internal/ray_frame.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::raytrace {

/// The part from … to of a ray, and the items that it may meet. `bounds`: those of the hierarchy.
struct ItemWalk {
  const ItemTrees& items;
  const core::ItemBounds& bounds;
  const core::Ray& ray;
  double from, to;
  const RayFilter& filter;
};

/// walk_items() of one tree. Returns the last limit.
template <class Meet>
double walk_tree(const ItemWalk& walk, const ItemTrees::Tree& tree, const Meet& meet) {
  const auto& [items, bounds, ray, from, to, filter] = walk;
  RayFrame frame;
  if (!enter(tree.space, ray.origin - bounds.origin, ray.direction, from, to, frame)) return to;
  struct Visitor : LeafVisitor {
    const core::ItemBounds* bounds;
    const RayFilter* filter;
    const RayFrame* frame;
    const Meet* meet;
    double limit;
  } visitor;
  visitor.visit = [](LeafVisitor& base, std::uint32_t slot, float t_max) {
    auto& self = static_cast<Visitor&>(base);
    if ((self.bounds->layers(slot) & self.filter->layers) == 0 || self.filter->passes(slot)) return t_max;
    const double limit = (*self.meet)(core::Slot(slot));
    if (!(limit < self.limit)) return t_max;
    self.limit = limit;
    return limit == -kInfinity ? -1.0f : std::min(t_max, std::max(0.0f, self.frame->limit(limit)));
  };
  visitor.bounds = &bounds;
  visitor.filter = &filter;
  visitor.frame = &frame;
  visitor.meet = &meet;
  visitor.limit = to;
  kernels().walk(items.nodes(), tree.root, frame.boxes, visitor);
  return visitor.limit;
}

/// Calls meet(slot) for items that the ray's part may meet. meet() returns the t beyond which nothing is of interest
/// from now on; -infinity ends the walk. An empty part meets nothing.
template <class Meet>
void walk_items(const ItemWalk& walk, const Meet& meet) {
  const auto& [items, bounds, ray, from, end, filter] = walk;
  if (!(from <= end)) return;
  double to = end;
  for (const ItemTrees::Tree& tree : items.trees()) {
    if (tree.only == core::kNone) {
      to = walk_tree({items, bounds, ray, from, to, filter}, tree, meet);
    } else {
      if ((bounds.layers(tree.only) & filter.layers) == 0 || filter.passes(tree.only)) continue;
      if (tree.space.radius < 0.0) continue;
      if (passes_by(tree.space, ray.origin - bounds.origin, ray.direction)) continue;
      to = std::min(to, meet(tree.only));
    }
    if (to == -kInfinity) return;
  }
}

}  // namespace sightline::raytrace
