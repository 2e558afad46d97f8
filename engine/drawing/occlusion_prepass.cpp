#include <algorithm>
#include <iterator>

#include "sightline/culling/frustum/internal/set_parts.h"
#include "sightline/culling/queries/spatial_queries.h"
#include "sightline/engine/drawing/internal/draw_strategy.h"

namespace sightline::engine {
namespace {

using core::Kind;

constexpr std::uint32_t kLeastOfHalf = 1024;  // slots that are worth a separate draw
constexpr std::uint32_t kSlotsOfPart = 512;   // slots that a thread takes at a time

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

/// Box around the rectangle of the near plane that a view shows, with a margin for rounding.
core::AabbD near_rectangle(const core::View& view) {
  const core::dmat4 world_from_clip = glm::inverse(view.clip_from_world());
  const double z = core::near_depth(view.clip_depth());
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
/// from inside, and shows what lies behind the occluder polygons in it. Otherwise each ray enters a row of neighbours
/// through a face that is drawn.
bool OcclusionPrepass::suits(const Frame& frame) {
  const core::Snapshot& snapshot = frame.snapshot;
  if (!frame.hierarchy || !mostly_solid(snapshot)) return false;
  const core::AabbD near = near_rectangle(frame.view);
  if (!core::is_finite(near.min) || !core::is_finite(near.max)) return false;
  const culling::SpatialQueries queries(snapshot.bounds(), *frame.hierarchy);
  queries.intersecting(near, ~0u, at_near_plane_);
  return std::none_of(at_near_plane_.begin(), at_near_plane_.end(),
                      [&](core::Slot slot) { return has_ends(snapshot.kind(slot)); });
}

core::Expected<DrawCounts> OcclusionPrepass::draw(DrawContext& context, const Frame& frame,
                                                  const core::VisibleSet& candidates) {
  const culling::OcclusionTest test = context.occlusion_test(frame);
  if (auto done = rasterise(context, frame, candidates, test); !done) return tl::unexpected(done.error());
  context.image->pyramid_valid = true;
  return draw_visible(context, frame, test);
}

/// Fills the depth pyramid: with the meshes of the first pass, which are drawn, and with the occluder polygons of the
/// solids of all passes.
core::Expected<void> OcclusionPrepass::rasterise(DrawContext& context, const Frame& frame,
                                                 const core::VisibleSet& candidates,
                                                 const culling::OcclusionTest& test) {
  const core::Snapshot& snapshot = frame.snapshot;
  ImageState& image = *context.image;
  context.clear_pyramid();
  solids_.begin(snapshot, frame.view, image.target.width(), image.target.height(), context.snap());
  image.passes.begin(candidates, frame.lines, frame.hierarchy, context.threads,
                     culling::OcclusionPasses::Next::kNearest);
  if (auto done = context.clear(image.target); !done) return tl::unexpected(done.error());
  image.distances.clear();
  for (bool first = true; image.passes.next(test, snapshot.bounds()); first = false) {
    if (first)
      if (auto done = draw_meshes(context, frame, candidates.generation); !done) return done;
    solids_.add(image.passes.pass(), &context.threads);
    if (first && !meshes_.single_slots.empty())
      if (auto read = image.target.read_distances(frame.view, image.distances); !read) return read;
    solids_.build(image.pyramid, image.distances, &context.threads);
  }
  return {};
}

/// Begins to draw those items of the first pass that have no occluder polygons but may occlude others.
core::Expected<void> OcclusionPrepass::draw_meshes(DrawContext& context, const Frame& frame, std::uint64_t generation) {
  meshes_.clear();
  meshes_.generation = generation;
  context.image->passes.pass().for_each_slot([&](core::Slot slot) {
    const Kind kind = frame.snapshot.kind(slot);
    if (!is_solid(kind) && kind != Kind::kLine) meshes_.single_slots.push_back(slot);
  });
  std::sort(meshes_.single_slots.begin(), meshes_.single_slots.end());
  if (meshes_.single_slots.empty()) return {};
  auto done = context.draw(frame, {meshes_, context.target()});
  context.gl().Flush();
  return done;
}

/// Draws what all occluder polygons leave visible, in two halves. Only one thread may submit: while it submits the
/// first half, others test the second.
core::Expected<DrawCounts> OcclusionPrepass::draw_visible(DrawContext& context, const Frame& frame,
                                                          const culling::OcclusionTest& test) {
  culling::OcclusionPasses& passes = context.image->passes;
  const core::ItemBounds& bounds = frame.snapshot.bounds();
  passes.list_drawn(bounds, visible_);
  halves_.split(visible_, std::max(kLeastOfHalf, std::uint32_t(visible_.single_slots.size() + 1) / 2));
  core::Expected<std::int64_t> drawn = std::int64_t(meshes_.single_slots.size());
  const core::VisibleSet* tested = nullptr;
  const auto draw_tested = [&] {
    if (!tested || !drawn) return;
    const auto more = draw_solids(context, frame, *tested);
    drawn = more ? core::Expected<std::int64_t>(*drawn + *more) : more;
  };
  for (std::uint32_t i = 0; i < halves_.count(); ++i) {
    leave_out_occluded(context, frame, test, halves_[i], draw_tested);
    tested = &halves_[i];
  }
  draw_tested();
  halves_.join(visible_);
  passes.remember(visible_, bounds);
  return drawn.map([](std::int64_t count) { return DrawCounts{-1, count}; });
}

/// Leaves out of a set the items that the depth pyramid occludes. `beside`: see core::ThreadPool::run().
template <class Beside>
void OcclusionPrepass::leave_out_occluded(DrawContext& context, const Frame& frame, const culling::OcclusionTest& test,
                                          core::VisibleSet& set, const Beside& beside) {
  const core::ItemBounds& bounds = frame.snapshot.bounds();
  const double error = render::RenderTarget::orthographic_error(frame.view);
  parts_.split(set, kSlotsOfPart);
  const auto leave_out = [&](core::VisibleSet& part, std::uint32_t) {
    test.filter(bounds, part, part, frame.lines);
    solids_.leave_out_occluded(part, context.image->pyramid, error);
  };
  parts_.for_each(context.threads, leave_out, beside);
  parts_.join(set);
}

/// Draws the items of a set that are not drawn yet, and returns their number.
core::Expected<std::int64_t> OcclusionPrepass::draw_solids(DrawContext& context, const Frame& frame,
                                                           const core::VisibleSet& set) {
  drawn_.clear();
  drawn_.generation = set.generation;
  std::set_difference(set.single_slots.begin(), set.single_slots.end(), meshes_.single_slots.begin(),
                      meshes_.single_slots.end(), std::back_inserter(drawn_.single_slots));
  const auto count = std::int64_t(drawn_.single_slots.size());
  return context.draw(frame, {drawn_, context.target()}).map([count] { return count; });
}

}  // namespace sightline::engine
