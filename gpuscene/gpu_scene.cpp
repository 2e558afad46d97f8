#include "sightline/gpuscene/gpu_scene.h"

#include <array>
#include <cassert>

#include "sightline/gpuscene/mesh_pool.h"

namespace sightline::gpuscene {
namespace {

using core::Kind;
using core::Slot;
using core::Snapshot;
using gpuprims::Texel;

constexpr std::array<std::string_view, kBatchKindCount> kBatchNames = {"cylinder", "snout", "circular_torus",
                                                                       "box",      "line",  "mesh"};
constexpr std::array<Kind, 5> kDirectKinds = {Kind::kCylinder, Kind::kSnout, Kind::kCircularTorus, Kind::kBox,
                                              Kind::kLine};

/// Row of the material table: materials come in scene order, after the row for items that name none.
std::uint32_t material_row(const Snapshot& snapshot, Slot slot) {
  const std::uint32_t material = snapshot.material(slot);
  return material == core::kNone ? 0u : (material + 1) & gpuprims::kMaterialMask;
}

void pack_slot(const Snapshot& snapshot, Slot slot, std::span<Texel> out) {
  const Kind kind = snapshot.kind(slot);
  const core::KindItems& items = snapshot.of_kind(kind);
  const std::uint32_t i = snapshot.index_in_kind(slot);
  std::span<const float> parameters;
  if (int(kind) < core::kPrimitiveKindCount) {
    const std::size_t n = std::size_t(core::parameter_count(kind));
    parameters = std::span(items.parameters).subspan(i * n, n);
  }
  const bool flat = kind == Kind::kBox || flat_shaded(snapshot, slot);
  const std::uint32_t flags = flat ? std::uint32_t(gpuprims::kFlatShaded) : 0u;
  gpuprims::pack(kind, parameters, {items.placements[i], snapshot.item(slot), material_row(snapshot, slot) | flags},
                 out);
}

core::Expected<Batch> make_batch(const gl::Functions& gl, BatchKind kind, const Snapshot& snapshot,
                                 std::span<const Slot> slots) {
  Batch batch;
  batch.kind = kind;
  batch.count = std::uint32_t(slots.size());
  batch.texels_per_item = gpuprims::texels_per_item(snapshot.kind(slots[0]));
  const std::size_t stride = std::size_t(batch.texels_per_item);
  std::vector<Texel> texels(slots.size() * stride);
  for (std::size_t i = 0; i < slots.size(); ++i)
    pack_slot(snapshot, slots[i], std::span(texels).subspan(i * stride, stride));
  const std::string what = "records of the " + std::string(batch_name(kind)) + " batch";
  auto buffer = gl::Buffer::create(gl, std::span(texels), GL_DYNAMIC_STORAGE_BIT, what);
  if (!buffer) return tl::unexpected(buffer.error());
  batch.records = std::move(*buffer);
  auto view = gl::TextureBuffer::create(gl, batch.records, GL_RGBA32UI, what);
  if (!view) return tl::unexpected(view.error());
  batch.texels = std::move(*view);
  return batch;
}

}  // namespace

std::string_view batch_name(BatchKind kind) {
  return kBatchNames[std::size_t(kind)];
}

BatchKind batch_of(Kind kind) {
  for (std::size_t i = 0; i < kDirectKinds.size(); ++i)
    if (kDirectKinds[i] == kind) return BatchKind(i);
  return BatchKind::kMesh;
}

std::uint32_t GpuScene::rank(const Snapshot& snapshot, BatchKind kind, Slot slot) {
  if (kind != BatchKind::kMesh) return snapshot.rank(kDirectKinds[std::size_t(kind)], slot);
  std::uint32_t rank = slot;
  for (const Kind direct : kDirectKinds) rank -= snapshot.rank(direct, slot);
  return rank;
}

core::Expected<GpuScene> GpuScene::create(const gl::Context& context, const Snapshot& snapshot,
                                          const GpuSceneConfig& config) {
  const gl::Functions& gl = context.functions();
  GpuScene scene;
  for (std::size_t i = 0; i < kDirectKinds.size(); ++i) {
    const auto& slots = snapshot.of_kind(kDirectKinds[i]).slots;
    if (slots.empty()) continue;
    auto batch = make_batch(gl, BatchKind(i), snapshot, slots);
    if (!batch) return tl::unexpected(batch.error());
    scene.batches_.push_back(std::move(*batch));
  }

  std::vector<Slot> mesh_slots;
  for (Slot slot = 0; slot < snapshot.size(); ++slot)
    if (batch_of(snapshot.kind(slot)) == BatchKind::kMesh) mesh_slots.push_back(slot);
  if (!mesh_slots.empty()) {
    auto batch = make_batch(gl, BatchKind::kMesh, snapshot, mesh_slots);
    if (!batch) return tl::unexpected(batch.error());
    scene.batches_.push_back(std::move(*batch));
    auto pool = build_mesh_pool(gl, snapshot, mesh_slots, config);
    if (!pool) return tl::unexpected(pool.error());
    scene.meshes_ = std::move(*pool);
  }

  const core::Material unnamed;
  std::vector<glm::vec4> rows{{unnamed.colour, unnamed.alpha}};
  for (std::size_t i = 0; i < snapshot.scene().material_slots(); ++i) {
    const core::Material& m = snapshot.scene().material(snapshot.scene().material_at(i));
    rows.emplace_back(m.colour, m.alpha);
  }
  auto buffer = gl::Buffer::create(gl, std::span(rows), 0, "material table");
  if (!buffer) return tl::unexpected(buffer.error());
  scene.material_rows_ = std::move(*buffer);
  auto texels = gl::TextureBuffer::create(gl, scene.material_rows_, GL_RGBA32F, "material table");
  if (!texels) return tl::unexpected(texels.error());
  scene.material_texels_ = std::move(*texels);
  return scene;
}

void GpuScene::update(const Snapshot& snapshot, std::span<const core::ItemId> changed) {
  std::array<Texel, 8> record;
  for (const core::ItemId item : changed) {
    const Slot slot = snapshot.slot(item);
    if (slot == core::kNone) continue;
    const BatchKind kind = batch_of(snapshot.kind(slot));
    const Batch* target = batch(kind);
    assert(target && "items were inserted: create a new GpuScene");
    const auto texels = std::span(record).first(std::size_t(target->texels_per_item));
    pack_slot(snapshot, slot, texels);
    target->records.write(rank(snapshot, kind, slot) * texels.size_bytes(), texels.size_bytes(), texels.data());
  }
}

const Batch* GpuScene::batch(BatchKind kind) const {
  for (const Batch& b : batches_)
    if (b.kind == kind) return &b;
  return nullptr;
}

std::size_t GpuScene::memory_bytes() const {
  std::size_t bytes = meshes_.vertices.size() + meshes_.indices.size() + material_rows_.size();
  for (const Batch& b : batches_) bytes += b.records.size();
  return bytes;
}

}  // namespace sightline::gpuscene
