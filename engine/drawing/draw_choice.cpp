#include "sightline/engine/drawing/internal/draw_choice.h"

#include "sightline/core/internal/scratch.h"

namespace sightline::engine {
namespace {

using core::Slot;
using core::Snapshot;
using gpuscene::DrawnMesh;
using gpuscene::ElementsCommand;

constexpr std::size_t kMeshesOfJob = 64;
constexpr std::size_t kLargeCut = 1024;  // clusters of a mesh whose cut all threads choose

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

struct CutBuffers {
  lod::CutChooser cuts;
  std::vector<lod::IndexRange> ranges;
  std::size_t memory_bytes() const { return core::bytes_of(cuts, ranges); }
};

}  // namespace

void DrawChoice::Some::clear() {
  fronts.clear();
  both_faces.clear();
  picked.clear();
  large.clear();
  counts = {};
}

/// Chooses for one mesh at a time. Several threads may use it.
class DrawChoice::OfMesh {
 public:
  OfMesh(const Snapshot& snapshot, const MeshRules& rules)
      : snapshot_(snapshot), rules_(rules), shown_(snapshot, rules.view) {}

  /// `helped`: all threads share in it; without, large meshes are left for that.
  void add(const Item& item, bool helped, Some& some) const {
    const DrawnMesh& mesh = item.mesh;
    if (mesh.whole.instance_count == 0 || mesh.whole.count == 0) return;
    const bool cuts = mesh.levels && rules_.error;
    if (cuts && !helped && mesh.levels->clusters.size() >= kLargeCut) return some.large.push_back(item.place);
    const core::Scratch<CutBuffers> buffers;
    bool first = true;
    if (cuts)
      first = choose_cut(item, helped ? rules_.threads : nullptr, *buffers);
    else
      buffers->ranges.assign(1, {0, mesh.whole.count});
    count(buffers->ranges, mesh.whole.count, cuts ? buffers->cuts.error() : 0.0, first, some.counts);
    const std::uint32_t solid = solid_indices(item);
    for (const lod::IndexRange& range : buffers->ranges) {
      const std::uint32_t end = range.first + range.count;
      add_triangles(item, {range.first, std::min(end, solid)}, true, some);
      add_triangles(item, {std::max(range.first, solid), end}, false, some);
    }
  }

 private:
  struct Indices {
    std::uint32_t first, end;
  };

  /// Returns whether nothing of the item is drawn yet.
  bool choose_cut(const Item& item, core::ThreadPool* threads, CutBuffers& buffers) const {
    const core::Affine world_from_mesh = snapshot_.world_from_item(item.slot);
    const lod::MeshLevels& levels = *item.mesh.levels;
    auto& clusters = buffers.cuts.choose(levels, {*rules_.error, world_from_mesh}, threads);
    const bool first = !rules_.clusters || rules_.clusters->filter(item.slot, levels, world_from_mesh, clusters);
    lod::CutChooser::merge(levels, clusters, buffers.ranges);
    return first;
  }

  /// Number of first indices, of the mesh or its levels, of which only front faces show. A mesh of solids alone remains
  /// solid in every cut; of others that is known of their own triangles, which the mesh itself has in another order.
  std::uint32_t solid_indices(const Item& item) const {
    const DrawnMesh& mesh = item.mesh;
    if (mesh.solid_indices == 0 || !shown_.shows_fronts_alone(item.slot)) return 0;
    if (mesh.solid_indices < mesh.whole.count) return rules_.triangles && !mesh.levels ? 0 : mesh.solid_indices;
    return mesh.levels ? std::uint32_t(mesh.levels->indices.size()) : mesh.whole.count;
  }

  /// Counts what `ranges` draw of a mesh, and the mesh itself if it is the first of it.
  static void count(std::span<const lod::IndexRange> ranges, std::uint32_t own_indices, double error, bool first,
                    MeshCounts& counts) {
    if (ranges.empty()) return;
    MeshCounts more{0, 0, 0, 0, error};
    if (first) more = {1, ranges.back().first + ranges.back().count > own_indices, 0, own_indices / 3, error};
    for (const lod::IndexRange& range : ranges) more.triangles += range.count / 3;
    counts += more;
  }

  /// Adds triangles of a mesh, for the test if there is one.
  void add_triangles(const Item& item, Indices which, bool fronts_alone, Some& some) const {
    if (which.first >= which.end) return;
    const std::uint32_t count = which.end - which.first;
    if (rules_.triangles) {
      const auto& indices = item.mesh.levels ? item.mesh.levels->indices : snapshot_.mesh(item.slot).indices;
      return some.picked.push_back(
          {item.slot, item.place, std::span(indices).subspan(which.first, count), fronts_alone});
    }
    ElementsCommand command = item.mesh.whole;
    command.first_index += which.first;
    command.count = count;
    (fronts_alone ? some.fronts : some.both_faces).push_back(command);
  }

  const Snapshot& snapshot_;
  const MeshRules& rules_;
  const ShownMeshes shown_;
};

gpuscene::MeshDraws DrawChoice::choose(const Snapshot& snapshot, std::span<const Slot> meshes, const MeshOf& mesh_of,
                                       const MeshRules& rules) {
  const OfMesh of_mesh(snapshot, rules);
  const auto add = [&](std::size_t place, bool helped, Some& some) {
    of_mesh.add({meshes[place], std::uint32_t(place), mesh_of(meshes[place])}, helped, some);
  };
  const auto jobs = std::uint32_t((meshes.size() + kMeshesOfJob - 1) / kMeshesOfJob);
  some_.resize(std::max<std::size_t>(some_.size(), jobs + 1));
  for (Some& some : some_) some.clear();
  core::ThreadPool::run_on(rules.threads, jobs, [&](std::uint32_t job) {
    const std::size_t first = job * kMeshesOfJob, end = std::min(first + kMeshesOfJob, meshes.size());
    for (std::size_t place = first; place < end; ++place) add(place, false, some_[job]);
  });
  Some& rest = some_[jobs];
  for (const Some& some : std::span(some_).first(jobs))
    for (const std::uint32_t place : some.large) add(place, true, rest);
  if (rules.triangles) pick_triangles(snapshot, meshes, mesh_of, rules);
  return join(rules.triangles != nullptr);
}

/// Tests the triangles, and draws those that are left after everything else.
void DrawChoice::pick_triangles(const Snapshot& snapshot, std::span<const Slot> meshes, const MeshOf& mesh_of,
                                const MeshRules& rules) {
  picked_.clear();
  for (const Some& some : some_) picked_.add(some.picked);
  picked_.test(snapshot, *rules.triangles, rules.threads);
  picked_.for_each([&](std::uint32_t place, std::uint32_t first, std::uint32_t count, bool fronts) {
    ElementsCommand command = mesh_of(meshes[place]).whole;
    command.first_index = first;
    command.count = count;
    (fronts ? some_.back().fronts : some_.back().both_faces).push_back(command);
  });
}

gpuscene::MeshDraws DrawChoice::join(bool picked) {
  fronts_.clear();
  both_faces_.clear();
  picked_runs_.clear();
  counts_ = {};
  for (const Some& some : some_) {
    fronts_.push_back(some.fronts);
    both_faces_.push_back(some.both_faces);
    counts_ += some.counts;
  }
  if (picked) picked_.list_runs(picked_runs_);
  return {fronts_, both_faces_, picked_runs_};
}

core::Expected<void> DrawChoice::update(gpuscene::DrawLists& lists, const gpuscene::GpuScene& scene,
                                        const Snapshot& snapshot, const core::VisibleSet& visible,
                                        const MeshRules& rules) {
  records_.assign(snapshot, visible, rules.threads);
  if (auto done = draw_others(lists, scene, rules); !done) return done;
  const auto mesh_of = [&](Slot slot) { return scene.meshes().drawn(gpuscene::GpuScene::record_of(snapshot, slot)); };
  return lists.update(scene, records_, choose(snapshot, records_.meshes, mesh_of, rules));
}

core::Expected<void> DrawChoice::draw_others(gpuscene::DrawLists& lists, const gpuscene::GpuScene& scene,
                                             const MeshRules& rules) {
  const auto is_empty = [](const auto& batch) { return batch.runs.empty() && batch.singles.empty(); };
  if (!rules.draw_others || records_.meshes.size() <= kMeshesOfJob || std::ranges::all_of(records_.batches, is_empty))
    return {};
  auto done = lists.update(scene, records_, {});
  for (gpuscene::VisibleRecords::OfBatch& batch : records_.batches) batch.runs.clear(), batch.singles.clear();
  return done ? rules.draw_others() : done;
}

}  // namespace sightline::engine
