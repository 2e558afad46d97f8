#include "sightline/gpuscene/internal/draw_lists.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sightline/gpuscene/internal/record_commands.h"

namespace sightline::gpuscene {
namespace {

using core::Slot;
using core::Snapshot;

/// Decides by their boxes which faces of meshes a view shows.
class ShownMeshes {
 public:
  ShownMeshes(const Snapshot& snapshot, const core::View* drawn) : snapshot_(snapshot) {
    if (!drawn) return;
    const core::View& view = *drawn;
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
    const double reach = glm::dot(glm::abs(form.normal), 0.5 * (high - low));
    return {middle - reach, middle + reach};
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

/// 0, 1, 2, … for points and lines, then the triangles of proxies if they are drawn so.
std::vector<std::uint16_t> list_indices(gl::Workarounds workarounds) {
  std::vector<std::uint16_t> indices(2 * kRecordsPerCommand);
  std::iota(indices.begin(), indices.end(), std::uint16_t(0));
  const RecordForm proxy = record_form(BatchKind::kBox, workarounds);
  if (proxy.mode != GL_TRIANGLES) return indices;
  for (std::uint32_t record = 0; record < kRecordsPerCommand; ++record)
    for (const std::uint16_t corner : kProxyTriangles)
      indices.push_back(std::uint16_t(record * proxy.vertices + corner));
  return indices;
}

}  // namespace

core::Expected<DrawLists> DrawLists::create(const gl::Context& context, const GpuScene& scene) {
  DrawLists lists;
  lists.gl_ = &context.functions();
  const gl::Functions& gl = context.functions();
  const Batch* meshes = scene.batch(BatchKind::kMesh);
  if (meshes) {
    std::vector<std::uint32_t> identity(meshes->capacity);
    std::iota(identity.begin(), identity.end(), 0u);
    auto buffer = gl::Buffer::create(gl, std::span(identity), 0, "mesh instances");
    if (!buffer) return tl::unexpected(buffer.error());
    lists.mesh_instances_ = std::move(*buffer);
  }
  if (scene.batches().size() > (meshes ? 1u : 0u)) {
    const std::vector<std::uint16_t> indices = list_indices(gl.workarounds);
    auto buffer = gl::Buffer::create(gl, std::span(indices), 0, "record indices");
    if (!buffer) return tl::unexpected(buffer.error());
    lists.record_indices_ = std::move(*buffer);
  }
  return lists;
}

void DrawLists::append(const ElementsCommand* commands, std::size_t count) {
  command_list_.insert(command_list_.end(), commands, commands + count);
}

void DrawLists::append_records(BatchKind kind, std::uint32_t first, std::uint32_t count) {
  const RecordForm form = record_form(kind, gl_->workarounds);
  for (std::uint32_t done = 0; done < count; done += kRecordsPerCommand) {
    const std::uint32_t n = std::min(kRecordsPerCommand, count - done);
    const ElementsCommand command{n * form.indices, 1, form.first_index, std::int32_t((first + done) * form.vertices),
                                  0};
    append(&command, 1);
  }
}

void DrawLists::list_records(const Batch& batch) {
  const VisibleRecords::OfBatch& found = visible_.batches[std::size_t(batch.kind)];
  const std::size_t begin = command_list_.size();
  for (const VisibleRecords::Run& run : found.runs) append_records(batch.kind, run.first, run.count);
  const std::size_t place = singles_.begin() + single_list_.size();
  append_records(batch.kind, batch.count + std::uint32_t(place), std::uint32_t(found.singles.size()));
  single_list_.insert(single_list_.end(), found.singles.begin(), found.singles.end());
  sections_[std::size_t(batch.kind)] = {begin, int(command_list_.size() - begin)};
}

/// Lists a cut of a mesh with levels. The first `solid` of its indices show only front faces. A mesh of solids alone
/// remains solid in every cut; of others that is known of their own triangles.
void DrawLists::list_mesh(const Snapshot& snapshot, MeshTriangles mesh, const lod::MeshLevels* levels,
                          std::uint32_t solid, const DrawnIn& in) {
  if (mesh.whole.instance_count == 0 || mesh.whole.count == 0) return;
  if (in.triangles) mesh.indices = levels ? levels->indices : snapshot.mesh(mesh.slot).indices;
  // Triangles of the mesh itself are in another order there.
  if (in.triangles && !levels && solid < mesh.whole.count) solid = 0;
  bool first = true;
  if (levels && in.error) {
    if (solid == mesh.whole.count) solid = std::uint32_t(levels->indices.size());
    first = list_cut(snapshot, mesh.slot, *levels, in);
  } else {
    ranges_.assign(1, {0, mesh.whole.count});
  }
  count_mesh(mesh.whole.count, levels && in.error ? cuts_.error() : 0.0, first);
  for (const lod::IndexRange& range : ranges_) {
    const std::uint32_t end = range.first + range.count;
    list_triangles(mesh, range.first, std::min(end, solid), true);
    list_triangles(mesh, std::max(range.first, solid), end, false);
  }
}

/// Sets ranges_. Returns whether nothing of the item is drawn yet.
bool DrawLists::list_cut(const Snapshot& snapshot, Slot slot, const lod::MeshLevels& levels, const DrawnIn& in) {
  const core::Affine world_from_mesh = snapshot.world_from_item(slot);
  std::vector<std::uint32_t>& clusters = cuts_.choose(levels, {*in.error, world_from_mesh});
  const bool first = !in.clusters || in.clusters->filter(slot, levels, world_from_mesh, clusters);
  lod::CutChooser::merge(levels, clusters, ranges_);
  return first;
}

/// Counts what ranges_ draws of a mesh, and the mesh itself if it is the first of it.
void DrawLists::count_mesh(std::uint32_t own_indices, double error, bool first) {
  if (ranges_.empty()) return;
  MeshCounts counts{0, 0, 0, 0, error};
  if (first) counts = {1, ranges_.back().first + ranges_.back().count > own_indices, 0, own_indices / 3, error};
  for (const lod::IndexRange& range : ranges_) counts.triangles += range.count / 3;
  mesh_counts_ += counts;
}

/// Indices first … end - 1 of a mesh, for the test if there is one.
void DrawLists::list_triangles(const MeshTriangles& mesh, std::uint32_t first, std::uint32_t end, bool fronts_alone) {
  if (first >= end) return;
  if (!mesh.indices.empty())
    return picked_.add(mesh.slot, mesh.indices.subspan(first, end - first), mesh.whole, fronts_alone);
  ElementsCommand command = mesh.whole;
  command.first_index += first;
  command.count = end - first;
  (fronts_alone ? command_list_ : both_faces_).push_back(command);
}

/// Commands that show only front faces come first.
core::Expected<void> DrawLists::list_meshes(const Snapshot& snapshot, const MeshPool& pool, const DrawnIn& in) {
  const std::size_t begin = command_list_.size();
  const ShownMeshes shown(snapshot, in.view);
  both_faces_.clear();
  picked_.clear();
  for (const Slot slot : visible_.meshes) {
    const std::uint32_t record = GpuScene::record_of(snapshot, slot), solid = pool.solid_indices(record);
    const bool fronts_alone = solid > 0 && shown.shows_fronts_alone(slot);
    list_mesh(snapshot, {slot, pool.command(record), {}}, pool.levels(record), fronts_alone ? solid : 0, in);
  }
  if (in.triangles) {
    picked_.test(snapshot, *in.triangles, in.threads);
    if (auto done = upload_picked(); !done) return done;
    const auto first = std::uint32_t(picked_indices_.begin());
    picked_.for_each_command(first, [&](const ElementsCommand& command, bool fronts) {
      (fronts ? command_list_ : both_faces_).push_back(command);
    });
  }
  const int front_only = int(command_list_.size() - begin);
  append(both_faces_.data(), both_faces_.size());
  sections_[std::size_t(BatchKind::kMesh)] = {begin, int(command_list_.size() - begin), false, front_only};
  return {};
}

core::Expected<void> DrawLists::upload_picked() {
  if (auto done = picked_indices_.reserve(*gl_, picked_.size()); !done) return tl::unexpected(done.error());
  picked_.for_each_run(
      [&](std::span<const std::uint32_t> indices, std::size_t first) { picked_indices_.write(first, indices); });
  return {};
}

core::Expected<void> DrawLists::update(const Snapshot& snapshot, const GpuScene& scene, const core::VisibleSet& visible,
                                       const DrawnIn& in) {
  sections_ = {};
  mesh_counts_ = {};
  from_gpu_ = false;
  picks_ = in.triangles != nullptr;
  commands_.advance();
  singles_.advance();
  picked_indices_.advance();
  visible_.assign(snapshot, visible);
  std::size_t singles = 0;
  for (const VisibleRecords::OfBatch& found : visible_.batches) singles += found.singles.size();
  // The lists hold the places of single records in the buffer, so it must be large enough before.
  if (auto done = reserve_singles(singles); !done) return done;
  command_list_.clear();
  single_list_.clear();
  core::Expected<void> done;
  for (const Batch& b : scene.batches()) {
    if (b.kind == BatchKind::kMesh) {
      done = list_meshes(snapshot, scene.meshes(), in);
    } else {
      list_records(b);
    }
  }
  if (done) done = upload();
  if (!done) sections_ = {};
  return done;
}

/// Shaders look into the buffer even where they find nothing there, so it is never missing.
core::Expected<void> DrawLists::reserve_singles(std::size_t count) {
  const auto anew = singles_.reserve(*gl_, std::max<std::size_t>(1, count));
  if (!anew) return tl::unexpected(anew.error());
  if (*anew) single_texels_ = {};
  if (single_texels_.id() != 0) return {};
  auto texels = gl::TextureBuffer::create(*gl_, singles_.buffer(), GL_R32UI, "visible records");
  if (!texels) return tl::unexpected(texels.error());
  single_texels_ = std::move(*texels);
  return {};
}

core::Expected<void> DrawLists::upload() {
  if (command_list_.empty()) return {};
  if (auto done = commands_.reserve(*gl_, command_list_.size()); !done) return tl::unexpected(done.error());
  for (Section& section : sections_) section.offset = (commands_.begin() + section.offset) * sizeof(ElementsCommand);
  commands_.write(0, command_list_);
  if (!single_list_.empty()) singles_.write(0, single_list_);
  return {};
}

void DrawLists::trim() {
  single_texels_ = {};
  singles_.trim();
  commands_.trim();
  picked_indices_.trim();
  sections_ = {};
}

std::size_t DrawLists::memory_bytes() const {
  return commands_.buffer().size() + singles_.buffer().size() + picked_indices_.buffer().size() +
         record_indices_.size() + mesh_instances_.size() + gpu_.commands.size() + gpu_.singles.size() +
         gpu_.counts.size();
}

}  // namespace sightline::gpuscene
