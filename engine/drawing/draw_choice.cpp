#include "sightline/engine/drawing/internal/draw_choice.h"

namespace sightline::engine {
namespace {

using core::Slot;
using core::Snapshot;
using gpuscene::ElementsCommand;

/// Decides by their boxes which faces of meshes a view shows.
class ShownMeshes {
 public:
  ShownMeshes(const Snapshot& snapshot, const core::View& view) : snapshot_(snapshot) {
    near_ = relative(core::frustum_planes(view.clip_from_world(), view.clip_depth())[core::kNear]);
    const double norm = glm::length(near_.normal);
    near_.normal /= norm;
    near_.offset /= norm;
    can_face_ = norm > 0.0 && view.sections.empty() && !mirrors(view);
  }

  /// True when an item shows the eye only front faces of its solid shells (solid_shells.h): it is not mirrored, and it
  /// lies wholly beyond the near plane, so the eye is outside and the plane cuts no shell open. Never with sections.
  bool shows_fronts_alone(Slot slot) const { return can_face_ && beyond_near_plane(slot) && !mirrored(slot); }

 private:
  struct Span {
    double low, high;
  };
  core::Plane relative(core::Plane plane) const {
    plane.offset += glm::dot(plane.normal, snapshot_.bounds().origin);
    return plane;
  }
  /// Range of a linear form over an item's box.
  Span span(const core::Plane& form, Slot slot) const {
    const core::Aabb box = snapshot_.bounds().box(slot);
    const core::dvec3 low(box.min), high(box.max);
    const double middle = core::evaluate(form, 0.5 * (low + high));
    const double half_extent = glm::dot(glm::abs(form.normal), 0.5 * (high - low));
    return {middle - half_extent, middle + half_extent};
  }
  /// True when the view exchanges clockwise and counter-clockwise triangles.
  static bool mirrors(const core::View& view) {
    const core::dmat4& clip = view.clip_from_eye();
    return !(glm::determinant(core::dmat3(view.eye_from_world())) * clip[0][0] * clip[1][1] > 0.0);
  }
  bool mirrored(Slot slot) const {
    const core::KindItems& items = snapshot_.of_kind(snapshot_.kind(slot));
    return !(glm::determinant(items.placements[snapshot_.index_in_kind(slot)].linear) > 0.0f);
  }
  /// True when an item lies beyond the near plane by more than the GPU rounds vertices.
  bool beyond_near_plane(Slot slot) const {
    const core::Aabb box = snapshot_.bounds().box(slot);
    const Span depth = span(near_, slot);
    return depth.low > 1e-5 * (depth.high + glm::length(core::dvec3(box.max) - core::dvec3(box.min)));
  }

  const Snapshot& snapshot_;
  core::Plane near_;  // relative to the origin of the bounds
  bool can_face_ = false;
};

}  // namespace

/// Chooses from a mesh with levels a cut. The first `solid` of its indices show only front faces. A mesh of solids
/// alone remains solid in every cut; of others that is known of their own triangles.
void DrawChoice::choose_mesh(const Snapshot& snapshot, ItemMesh mesh, const lod::MeshLevels* levels,
                             std::uint32_t solid, const MeshRules& rules) {
  if (mesh.whole.instance_count == 0 || mesh.whole.count == 0) return;
  if (rules.triangles) mesh.indices = levels ? levels->indices : snapshot.mesh(mesh.slot).indices;
  // Triangles of the mesh itself are in another order there.
  if (rules.triangles && !levels && solid < mesh.whole.count) solid = 0;
  bool first = true;
  if (levels && rules.error) {
    if (solid == mesh.whole.count) solid = std::uint32_t(levels->indices.size());
    first = choose_cut(snapshot, mesh.slot, *levels, rules);
  } else {
    ranges_.assign(1, {0, mesh.whole.count});
  }
  count(mesh.whole.count, levels && rules.error ? cuts_.error() : 0.0, first);
  for (const lod::IndexRange& range : ranges_) {
    const std::uint32_t end = range.first + range.count;
    add_triangles(mesh, range.first, std::min(end, solid), true);
    add_triangles(mesh, std::max(range.first, solid), end, false);
  }
}

/// Sets ranges_. Returns whether nothing of the item is drawn yet.
bool DrawChoice::choose_cut(const Snapshot& snapshot, Slot slot, const lod::MeshLevels& levels,
                            const MeshRules& rules) {
  const core::Affine world_from_mesh = snapshot.world_from_item(slot);
  std::vector<std::uint32_t>& clusters = cuts_.choose(levels, {*rules.error, world_from_mesh});
  const bool first = !rules.clusters || rules.clusters->filter(slot, levels, world_from_mesh, clusters);
  lod::CutChooser::merge(levels, clusters, ranges_);
  return first;
}

/// Counts what ranges_ draws of a mesh, and the mesh itself if it is the first of it.
void DrawChoice::count(std::uint32_t own_indices, double error, bool first) {
  if (ranges_.empty()) return;
  MeshCounts counts{0, 0, 0, 0, error};
  if (first) counts = {1, ranges_.back().first + ranges_.back().count > own_indices, 0, own_indices / 3, error};
  for (const lod::IndexRange& range : ranges_) counts.triangles += range.count / 3;
  counts_ += counts;
}

/// Adds indices first … end - 1 of a mesh, for the test if there is one.
void DrawChoice::add_triangles(const ItemMesh& mesh, std::uint32_t first, std::uint32_t end, bool fronts_alone) {
  if (first >= end) return;
  if (!mesh.indices.empty()) {
    if (of_picked_.empty() || of_picked_.back() != mesh.whole) of_picked_.push_back(mesh.whole);
    return picked_.add(mesh.slot, std::uint32_t(of_picked_.size() - 1), mesh.indices.subspan(first, end - first),
                       fronts_alone);
  }
  ElementsCommand command = mesh.whole;
  command.first_index += first;
  command.count = end - first;
  (fronts_alone ? fronts_ : both_faces_).push_back(command);
}

void DrawChoice::choose(const Snapshot& snapshot, const gpuscene::MeshPool& pool, const MeshRules& rules) {
  const ShownMeshes shown(snapshot, rules.view);
  for (const Slot slot : records_.meshes) {
    const std::uint32_t record = gpuscene::GpuScene::record_of(snapshot, slot), solid = pool.solid_indices(record);
    const bool fronts_alone = solid > 0 && shown.shows_fronts_alone(slot);
    choose_mesh(snapshot, {slot, pool.command(record), {}}, pool.levels(record), fronts_alone ? solid : 0, rules);
  }
  if (!rules.triangles) return;
  picked_.test(snapshot, *rules.triangles, rules.threads);
  picked_.for_each([&](std::uint32_t tag, std::uint32_t first, std::uint32_t count, bool fronts) {
    ElementsCommand command = of_picked_[tag];
    command.first_index = first;
    command.count = count;
    (fronts ? fronts_ : both_faces_).push_back(command);
  });
  picked_.list_runs(picked_runs_);
}

core::Expected<void> DrawChoice::update(gpuscene::DrawLists& lists, const gpuscene::GpuScene& scene,
                                        const Snapshot& snapshot, const core::VisibleSet& visible,
                                        const MeshRules& rules) {
  records_.assign(snapshot, visible, rules.threads);
  fronts_.clear();
  both_faces_.clear();
  picked_.clear();
  of_picked_.clear();
  picked_runs_.clear();
  counts_ = {};
  choose(snapshot, scene.meshes(), rules);
  return lists.update(scene, records_, {fronts_, both_faces_, picked_runs_});
}

}  // namespace sightline::engine
