#include "sightline/gpuscene/internal/draw_lists.h"

#include <algorithm>
#include <numeric>

#include "sightline/core/internal/store.h"
#include "sightline/gpuscene/internal/record_commands.h"

namespace sightline::gpuscene {
namespace {

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
    if (auto done =
            core::store(gl::Buffer::create(gl, std::span(identity), 0, "mesh instances"), lists.mesh_instances_);
        !done)
      return tl::unexpected(done.error());
  }
  if (scene.batches().size() > (meshes ? 1u : 0u)) {
    const std::vector<std::uint16_t> indices = list_indices(gl.workarounds);
    if (auto done = core::store(gl::Buffer::create(gl, std::span(indices), 0, "record indices"), lists.record_indices_);
        !done)
      return tl::unexpected(done.error());
  }
  return lists;
}

void DrawLists::append_records(BatchKind kind, std::uint32_t first, std::uint32_t count) {
  const RecordForm form = record_form(kind, gl_->workarounds);
  for (std::uint32_t done = 0; done < count; done += kRecordsPerCommand) {
    const std::uint32_t n = std::min(kRecordsPerCommand, count - done);
    command_list_.push_back({n * form.indices, 1, form.first_index, std::int32_t((first + done) * form.vertices), 0});
  }
}

/// Writes the single records of a batch from the place `single` on.
void DrawLists::list_records(const Batch& batch, const VisibleRecords::OfBatch& found, std::size_t single) {
  const std::size_t begin = command_list_.size();
  for (const VisibleRecords::Run& run : found.runs) append_records(batch.kind, run.first, run.count);
  append_records(batch.kind, batch.count + std::uint32_t(singles_.begin() + single),
                 std::uint32_t(found.singles.size()));
  if (!found.singles.empty()) singles_.write(single, found.singles);
  sections_[std::size_t(batch.kind)] = {begin, int(command_list_.size() - begin)};
}

/// Indices of the image's own come to the region of the ring that this image uses.
core::Expected<void> DrawLists::list_meshes(const MeshDraws& meshes) {
  std::size_t indices = 0;
  for (const auto& run : meshes.indices) indices += run.size();
  if (auto made = picked_indices_.reserve(*gl_, indices); !made) return tl::unexpected(made.error());
  indices = 0;
  for (const auto& run : meshes.indices) {
    picked_indices_.write(indices, run);
    indices += run.size();
  }
  const std::size_t begin = command_list_.size();
  const auto append = [&](std::span<const ElementsCommand> run) {
    command_list_.insert(command_list_.end(), run.begin(), run.end());
  };
  std::ranges::for_each(meshes.fronts, append);
  const std::size_t fronts = command_list_.size() - begin;
  std::ranges::for_each(meshes.both_faces, append);
  for (std::size_t i = begin; picks_ && i < command_list_.size(); ++i)
    command_list_[i].first_index += std::uint32_t(picked_indices_.begin());
  sections_[std::size_t(BatchKind::kMesh)] = {begin, int(command_list_.size() - begin), false, int(fronts)};
  return {};
}

core::Expected<void> DrawLists::update(const core::Snapshot& snapshot, const GpuScene& scene,
                                       const core::VisibleSet& visible) {
  VisibleRecords records;
  records.assign(snapshot, visible);
  std::vector<ElementsCommand> whole;
  for (const core::Slot slot : records.meshes) {
    const ElementsCommand command = scene.meshes().command(GpuScene::record_of(snapshot, slot));
    if (command.instance_count > 0 && command.count > 0) whole.push_back(command);
  }
  const std::span<const ElementsCommand> run(whole);
  return update(scene, records, {.both_faces = {&run, 1}});
}

core::Expected<void> DrawLists::update(const GpuScene& scene, const VisibleRecords& records, const MeshDraws& meshes) {
  sections_ = {};
  from_gpu_ = false;
  picks_ = !meshes.indices.empty();
  commands_.advance();
  singles_.advance();
  picked_indices_.advance();
  std::size_t singles = 0;
  for (const VisibleRecords::OfBatch& found : records.batches) singles += found.singles.size();
  // The lists hold the places of single records in the buffer, so it must be large enough before.
  if (auto done = reserve_singles(singles); !done) return done;
  command_list_.clear();
  core::Expected<void> done;
  std::size_t place = 0;  // of the next batch's single records
  for (const Batch& b : scene.batches()) {
    if (b.kind == BatchKind::kMesh) {
      done = list_meshes(meshes);
    } else {
      const VisibleRecords::OfBatch& found = records.batches[std::size_t(b.kind)];
      list_records(b, found, place);
      place += found.singles.size();
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
  return core::store(gl::TextureBuffer::create(*gl_, singles_.buffer(), GL_R32UI, "visible records"), single_texels_);
}

core::Expected<void> DrawLists::upload() {
  if (command_list_.empty()) return {};
  if (auto done = commands_.reserve(*gl_, command_list_.size()); !done) return tl::unexpected(done.error());
  for (Section& section : sections_) section.offset = (commands_.begin() + section.offset) * sizeof(ElementsCommand);
  commands_.write(0, command_list_);
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
