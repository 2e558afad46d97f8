// Frames of which most is solid: which items are hidden is found out before they are drawn. Figures within the solids
// take the place of the solids in the passes of the occlusion test. They are rasterised in a small part of the time
// that drawing the solids takes. What the figures leave open is drawn in the end.
#include <algorithm>
#include <iterator>

#include "sightline/culling/internal/set_parts.h"
#include "sightline/culling/spatial_queries.h"
#include "sightline/engine/internal/drawing.h"

namespace sightline::engine {
namespace {

using core::Kind;

constexpr std::uint32_t kLeastOfHalf = 1024;  // slots that are worth a draw of their own
constexpr std::uint32_t kSlotsOfPart = 512;   // for a thread

bool is_solid(Kind kind) {
  return int(kind) < core::kPrimitiveKindCount && kind != Kind::kLine;
}

/// Whether a neighbour may cover an end, which then is not drawn (gpuprims/internal/joints.h).
bool has_ends(Kind kind) {
  return is_solid(kind) && kind != Kind::kBox && kind != Kind::kPyramid && kind != Kind::kRectangularTorus &&
         kind != Kind::kSphere;
}

bool mostly_solid(const core::Snapshot& snapshot) {
  std::size_t solids = 0;
  for (int kind = 0; kind < core::kKindCount; ++kind)
    if (is_solid(Kind(kind))) solids += snapshot.of_kind(Kind(kind)).size();
  return 2 * solids >= snapshot.size();
}

/// What a view shows of its near plane.
core::AabbD near_rectangle(const core::View& view) {
  const core::dmat4 world_from_clip = glm::inverse(view.clip_from_world());
  const double z = view.clip_depth() == core::ClipDepth::kReversedZeroToOne ? 1.0 : -1.0;
  core::AabbD box;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0}) {
      const core::dvec4 p = world_from_clip * core::dvec4(x, y, z, 1.0);
      box.grow(core::dvec3(p) / p.w);
    }
  const core::dvec3 margin = 1e-3 * box.size() + 1e-9 * (glm::abs(box.min) + glm::abs(box.max));
  return {box.min - margin, box.max + margin};
}

}  // namespace

/// Ends that neighbours cover are not drawn. Where a neighbour is missing, or the near plane opens it, a solid is seen
/// from inside, and shows what lies behind the figures in it. Otherwise each ray enters a row of neighbours through a
/// face that is drawn.
bool Drawing::may_rehearse(const Culled& culled) {
  const core::Snapshot& snapshot = culled.snapshot;
  if (!all_visible_ || !culled.hierarchy || !mostly_solid(snapshot)) return false;
  const core::AabbD near = near_rectangle(culled.view);
  if (!core::is_finite(near.min) || !core::is_finite(near.max)) return false;
  const culling::SpatialQueries queries(snapshot.bounds(), *culled.hierarchy);
  queries.intersecting(near, ~0u, at_near_plane_);
  return std::none_of(at_near_plane_.begin(), at_near_plane_.end(),
                      [&](core::Slot slot) { return has_ends(snapshot.kind(slot)); });
}

/// Of the first pass, what has no figures but may hide something. Begins to draw it.
core::Expected<void> Drawing::draw_unsolid(const Culled& culled) {
  unsolid_.clear();
  unsolid_.generation = culled.visible.generation;
  picture_->passes.pass().for_each_slot([&](core::Slot slot) {
    const Kind kind = culled.snapshot.kind(slot);
    if (!is_solid(kind) && kind != Kind::kLine) unsolid_.items.push_back(slot);
  });
  std::sort(unsolid_.items.begin(), unsolid_.items.end());
  if (unsolid_.items.empty()) return {};
  auto done = draw_pass(culled.view, culled.snapshot, unsolid_, picture_->target);
  context_.functions().Flush();
  return done;
}

core::Expected<void> Drawing::draw_rehearsed(const Culled& culled) {
  const auto& [view, snapshot, visible, lines, hierarchy] = culled;
  const core::ItemBounds& bounds = snapshot.bounds();
  const culling::OcclusionTest test = occlusion_test(view, bounds.origin);
  picture_->pyramid.clear(picture_->target.width(), picture_->target.height());
  solids_.begin(snapshot, view, picture_->target.width(), picture_->target.height(), snap());
  picture_->passes.begin(visible, lines, hierarchy, threads_, OcclusionPasses::Next::kNearest);
  renderer_->clear(picture_->target);
  picture_->distances.clear();
  for (bool first = true; picture_->passes.next(test, bounds); first = false) {
    if (first)
      if (auto done = draw_unsolid(culled); !done) return done;
    solids_.add(picture_->passes.pass(), &threads_);
    if (first && !unsolid_.items.empty()) picture_->target.read_distances(view, picture_->distances);
    solids_.build(picture_->pyramid, picture_->distances, &threads_);
  }
  depth_known_ = true;
  return draw_open(culled, test);
}

/// What all figures leave open, in two halves. Only one thread may submit: while it submits the first half, others find
/// out what is open of the second.
core::Expected<void> Drawing::draw_open(const Culled& culled, const culling::OcclusionTest& test) {
  const core::ItemBounds& bounds = culled.snapshot.bounds();
  picture_->passes.list_drawn(bounds, open_);
  counts_ = {-1, std::int64_t(unsolid_.items.size())};
  thread_local culling::SetParts halves;
  halves.split(open_, std::max(kLeastOfHalf, std::uint32_t(open_.items.size() + 1) / 2));
  core::Expected<void> done;
  const core::VisibleSet* found = nullptr;
  const auto draw_found = [&] {
    if (found && done) done = draw_solids(culled, *found);
  };
  for (std::uint32_t i = 0; i < halves.count(); ++i) {
    find_open(culled, test, halves[i], draw_found);
    found = &halves[i];
  }
  draw_found();
  halves.join(open_);
  picture_->passes.remember(open_, bounds);
  return done;
}

/// Leaves out of a set what figures hide. `beside`: see CullThreads::run().
void Drawing::find_open(const Culled& culled, const culling::OcclusionTest& test, core::VisibleSet& set,
                        const std::function<void()>& beside) {
  const core::ItemBounds& bounds = culled.snapshot.bounds();
  const double error = render::RenderTarget::orthographic_error(culled.view);
  thread_local culling::SetParts parts;
  parts.split(set, kSlotsOfPart);
  const auto find = [&](core::VisibleSet& part, std::uint32_t) {
    test.filter(bounds, part, part, culled.lines);
    solids_.leave_out_hidden(part, picture_->pyramid, error);
  };
  parts.for_each(&threads_, find, beside);
  parts.join(set);
}

/// What has figures, of what is open.
core::Expected<void> Drawing::draw_solids(const Culled& culled, const core::VisibleSet& open) {
  left_.clear();
  left_.generation = open.generation;
  std::set_difference(open.items.begin(), open.items.end(), unsolid_.items.begin(), unsolid_.items.end(),
                      std::back_inserter(left_.items));
  counts_.shown += std::int64_t(left_.items.size());
  return draw_pass(culled.view, culled.snapshot, left_, picture_->target);
}

}  // namespace sightline::engine
