#include "sightline/gpuscene/internal/gpu_scene.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <string>
#include <utility>

#include "sightline/core/internal/radix_sort.h"
#include "sightline/core/internal/snapshot_prefetch.h"
#include "sightline/core/internal/store.h"

namespace sightline::gpuscene {
namespace {

using core::Deadline;
using core::Kind;
using core::kNoDeadline;
using core::kNone;
using core::kPrefetchAhead;
using core::over;
using core::Slot;
using core::Snapshot;
using gpuprims::Texel;

constexpr std::uint32_t kHeadroom = 64;        // spare records, besides an eighth of the present ones
constexpr std::size_t kPiece = 4096;           // records packed at a time, which takes less than a millisecond
constexpr std::uint32_t kCopiedPiece = 16384;  // records copied at a time: some 512 that come need a 32nd of a million

/// What a record says of an item besides its placement and shape.
std::uint32_t record_word(const Snapshot& snapshot, const gpuprims::Joints& joints, Slot slot) {
  return gpuprims::material_word(snapshot, joints, slot) |
         (flat_shaded(snapshot, slot) ? std::uint32_t(gpuprims::kFlatShaded) : 0u);
}

/// Packs the records of `slots`, by several threads where they are many.
void pack_slots(const Snapshot& snapshot, const gpuprims::Joints& joints, BatchKind kind, std::span<const Slot> slots,
                Texel* records) {
  const std::size_t stride = std::size_t(texels_per_record(kind));
#pragma omp parallel for schedule(static) if (slots.size() >= kPiece)
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (i + kPrefetchAhead < slots.size()) prefetch_record(snapshot, slots[i + kPrefetchAhead]);
    gpuprims::pack(snapshot, slots[i], record_word(snapshot, joints, slots[i]), {records + i * stride, stride});
  }
}

std::vector<Texel> pack_slots(const Snapshot& snapshot, const gpuprims::Joints& joints, BatchKind kind,
                              std::span<const Slot> slots) {
  std::vector<Texel> texels(slots.size() * std::size_t(texels_per_record(kind)));
  pack_slots(snapshot, joints, kind, slots, texels.data());
  return texels;
}

std::string records_of(BatchKind kind) {
  return "records of the " + std::string(name_of(kind)) + " batch";
}

/// A batch with room for some more than `count` records.
core::Expected<Batch> make_batch(const gl::Functions& gl, BatchKind kind, std::size_t count) {
  const std::size_t capacity = count + count / 8 + kHeadroom;
  auto made = gl::TexelArray::create(gl, capacity * record_bytes(kind), nullptr, GL_RGBA32UI, records_of(kind));
  if (!made) return tl::unexpected(made.error());
  return Batch{
      kind, std::uint32_t(count), std::uint32_t(capacity), std::move(made->buffer), std::move(made->texels), {}, 0};
}

}  // namespace

std::uint32_t GpuScene::rank(const Snapshot& snapshot, BatchKind kind, Slot slot) {
  std::uint32_t rank = 0;
  for (int k = 0; k < core::kKindCount; ++k)
    if (batch_of(Kind(k)) == kind) rank += snapshot.rank(Kind(k), slot);
  return rank;
}

std::uint32_t GpuScene::record_of(const Snapshot& snapshot, Slot slot) {
  const Kind own = snapshot.kind(slot);
  std::uint32_t record = snapshot.index_in_kind(slot);
  const std::uint32_t others = info_of(batch_of(own)).item_kinds & ~item_kind_bits(own);
  for (std::uint32_t rest = others; rest != 0; rest &= rest - 1)
    record += snapshot.rank(Kind(std::countr_zero(rest)), slot);
  return record;
}

// --- uploading -------------------------------------------------------------------------------------------------------

struct GpuScene::Upload {
  std::size_t kind = 0;     // of the batch that is uploaded
  std::vector<Slot> slots;  // of its records
  std::size_t next = 0;     // of these
  bool batch_made = false;
};

GpuScene::GpuScene() = default;
GpuScene::GpuScene(GpuScene&&) noexcept = default;
GpuScene& GpuScene::operator=(GpuScene&&) noexcept = default;
GpuScene::~GpuScene() = default;

core::Expected<GpuScene> GpuScene::create(const gl::Context& context, const Snapshot& snapshot,
                                          const gpuprims::Joints& joints) {
  GpuScene scene = begin(context, snapshot);
  if (auto done = scene.advance(snapshot, joints, kNoDeadline); !done) return tl::unexpected(done.error());
  return scene;
}

GpuScene GpuScene::begin(const gl::Context& context, const Snapshot& snapshot) {
  GpuScene scene;
  scene.gl_ = &context.functions();
  scene.writer_ = ElementWriter(context);
  scene.slot_count_ = Slot(snapshot.size());
  scene.upload_ = std::make_unique<Upload>();
  return scene;
}

core::Expected<bool> GpuScene::advance(const Snapshot& snapshot, const gpuprims::Joints& joints, Deadline deadline) {
  for (; upload_->kind < std::size_t(kBatchKindCount); ++upload_->kind) {
    const auto kind = BatchKind(upload_->kind);
    if (!upload_->batch_made)
      if (auto done = begin_batch(snapshot, kind); !done) return tl::unexpected(done.error());
    const std::span<const Slot> slots = upload_->slots;
    while (upload_->next < slots.size()) {
      const std::size_t first = upload_->next, count = std::min(kPiece, slots.size() - first);
      const gl::Buffer& records = batches_.back().records;
      if (records.memory()) {
        pack_slots(snapshot, joints, kind, slots.subspan(first, count),
                   static_cast<Texel*>(records.memory()) + first * std::size_t(texels_per_record(kind)));
      } else {
        const std::vector<Texel> texels = pack_slots(snapshot, joints, kind, slots.subspan(first, count));
        records.write(first * record_bytes(kind), texels.size() * sizeof(Texel), texels.data());
      }
      upload_->next += count;
      if (over(deadline)) return false;
    }
    if (kind == BatchKind::kMesh && !slots.empty()) {
      while (meshes_.records() < slots.size()) {
        meshes_.add(snapshot, slots[meshes_.records()]);
        if (over(deadline)) return false;
      }
      if (const auto done = upload_meshes(deadline); !done || !*done) return done;
    }
    upload_->batch_made = false;
  }
  if (auto done = make_materials(snapshot); !done) return tl::unexpected(done.error());
  upload_.reset();
  return true;
}

/// Finds the items of the next batch, and makes it unless there are none.
core::Expected<void> GpuScene::begin_batch(const Snapshot& snapshot, BatchKind kind) {
  upload_->slots = slots_of(snapshot, kind, slot_count_);
  upload_->next = 0;
  if (upload_->slots.empty()) return {};
  auto batch = make_batch(*gl_, kind, upload_->slots.size());
  if (!batch) return tl::unexpected(batch.error());
  batches_.push_back(std::move(*batch));
  upload_->batch_made = true;
  return {};
}

std::vector<Slot> GpuScene::slots_of(const Snapshot& snapshot, BatchKind kind, Slot end) {
  std::vector<Slot> slots;
  for (int k = 0; k < core::kKindCount; ++k) {
    if (batch_of(Kind(k)) != kind) continue;
    const auto& members = snapshot.of_kind(Kind(k)).members;
    const auto middle = std::ptrdiff_t(slots.size());
    slots.insert(slots.end(), members.begin(), std::lower_bound(members.begin(), members.end(), end));
    std::inplace_merge(slots.begin(), slots.begin() + middle, slots.end());
  }
  return slots;
}

/// Row 0 is for items that name no material; the snapshot's table follows.
core::Expected<void> GpuScene::make_materials(const Snapshot& snapshot) {
  const core::Material unnamed;
  std::vector<glm::vec4> rows{{unnamed.colour, unnamed.alpha}};
  rows.insert(rows.end(), snapshot.materials().begin(), snapshot.materials().end());
  rows.resize(rows.size() + rows.size() / 8 + kHeadroom);
  const std::size_t bytes = rows.size() * sizeof(rows[0]);
  return core::store(gl::TexelArray::create(*gl_, bytes, rows.data(), GL_RGBA32F, "material table"), materials_);
}

core::Expected<void> GpuScene::update_materials(const Snapshot& snapshot, std::span<const std::uint32_t> edited) {
  if (edited.empty()) return {};
  const core::MaterialTable& rows = snapshot.materials();
  constexpr std::size_t kRow = sizeof(glm::vec4);
  if ((rows.size() + 1) * kRow > materials_.buffer.size()) return make_materials(snapshot);
  const std::size_t first = edited.front(), count = edited.back() - first + 1;
  materials_.buffer.write((first + 1) * kRow, count * kRow, rows.data() + first);
  return {};
}

core::Expected<bool> GpuScene::append(const Snapshot& snapshot, const gpuprims::Joints& joints, Slot most) {
  const Slot end = slot_count_ + std::min(most, Slot(snapshot.size()) - slot_count_);
  std::array<std::vector<Slot>, kBatchKindCount> slots;
  for (; slot_count_ < end; ++slot_count_)
    slots[std::size_t(batch_of(snapshot.kind(slot_count_)))].push_back(slot_count_);
  bool larger = false;
  for (std::size_t kind = 0; kind < slots.size(); ++kind) {
    const auto made = make_room(BatchKind(kind), slots[kind].size());
    if (!made) return made;
    larger |= *made;
  }
  for (Batch& b : batches_) {
    const auto& fresh = slots[std::size_t(b.kind)];
    if (fresh.empty()) continue;
    const std::vector<Texel> texels = pack_slots(snapshot, joints, b.kind, fresh);
    b.records.write(b.count * record_bytes(b.kind), texels.size() * sizeof(Texel), texels.data());
    b.count += std::uint32_t(fresh.size());
  }
  for (const Slot slot : slots[std::size_t(BatchKind::kMesh)]) meshes_.add(snapshot, slot);
  return larger;
}

core::Expected<bool> GpuScene::follow(const Snapshot& snapshot, const gpuprims::Joints& joints,
                                      std::span<const Slot> touched, Deadline deadline) {
  const auto prepared = deadline == kNoDeadline ? core::Expected<bool>(false) : prepare_room();
  if (!prepared) return prepared;
  const auto larger = append(snapshot, joints);
  if (!larger) return larger;
  update(snapshot, touched, joints);
  return upload_meshes(deadline).map([&](bool) { return *prepared || *larger; });
}

/// For so many more records. Whether there was too little.
core::Expected<bool> GpuScene::make_room(BatchKind kind, std::size_t records) {
  if (records == 0) return false;
  const auto place = std::find_if(batches_.begin(), batches_.end(), [&](const Batch& b) { return b.kind >= kind; });
  if (place == batches_.end() || place->kind != kind) {
    auto made = make_batch(*gl_, kind, records);
    if (!made) return tl::unexpected(made.error());
    made->count = 0;
    batches_.insert(place, std::move(*made));
    return true;
  }
  if (place->count + records <= place->capacity) return false;
  return enlarge(*place, place->count + records, kNone);
}

core::Expected<bool> GpuScene::prepare_room() {
  bool larger = false;
  for (Batch& batch : batches_) {
    if (batch.count <= batch.capacity - batch.capacity / 16) continue;
    const auto done = enlarge(batch, batch.capacity, kCopiedPiece);
    if (!done) return done;
    larger |= *done;
  }
  return larger;
}

/// Copies `most` records of a batch, or the rest, to a larger buffer: for half as many again as `records`. Uses that
/// once all are there, and returns true.
core::Expected<bool> GpuScene::enlarge(Batch& batch, std::size_t records, std::uint32_t most) {
  const std::size_t stride = record_bytes(batch.kind);
  if (batch.larger.size() < records * stride) {
    const std::size_t bytes = (records + records / 2) * stride;
    auto made = gl::Buffer::create(*gl_, bytes, nullptr, GL_DYNAMIC_STORAGE_BIT, records_of(batch.kind));
    if (auto done = core::store(std::move(made), batch.larger); !done) return tl::unexpected(done.error());
    batch.copied = 0;
  }
  const std::uint32_t count = std::min(most, batch.count - batch.copied);
  const auto begin = GLintptr(batch.copied * stride);
  if (count > 0)
    gl_->CopyNamedBufferSubData(batch.records.id(), batch.larger.id(), begin, begin, GLsizeiptr(count * stride));
  batch.copied += count;
  if (batch.copied < batch.count) return false;
  auto view = gl::TextureBuffer::create(*gl_, batch.larger, GL_RGBA32UI, records_of(batch.kind));
  if (auto done = core::store(std::move(view), batch.texels); !done) return tl::unexpected(done.error());
  batch.capacity = std::uint32_t(batch.larger.size() / stride);
  batch.records = std::exchange(batch.larger, {});
  batch.copied = 0;
  return true;
}

/// Writes elements of so many bytes into the records of a batch, and into those that were copied.
void GpuScene::write(const Batch& batch, std::size_t bytes, std::span<const std::uint32_t> places, const void* data) {
  writer_.write(batch.records, bytes, places, data);
  const std::uint64_t end = batch.copied * (record_bytes(batch.kind) / bytes);
  const auto copied = std::ranges::lower_bound(places, end) - places.begin();
  if (copied > 0) writer_.write(batch.larger, bytes, places.first(std::size_t(copied)), data);
}

void GpuScene::update(const Snapshot& snapshot, std::span<const Slot> changed, const gpuprims::Joints& joints) {
  for_each_batch(snapshot, changed, [&](const Batch& target, const Changed& now) {
    const std::vector<Texel> texels = pack_slots(snapshot, joints, target.kind, now.slots);
    write(target, record_bytes(target.kind), now.records, texels.data());
  });
}

void GpuScene::update_styles(const Snapshot& snapshot, std::span<const Slot> changed, const gpuprims::Joints& joints) {
  for_each_batch(snapshot, changed, [&](const Batch& target, const Changed& now) {
    const std::uint32_t stride = std::uint32_t(record_bytes(target.kind) / sizeof(std::uint32_t));
    std::vector<std::uint32_t> places, words;
    for (std::size_t i = 0; i < now.slots.size(); ++i) {
      places.push_back(now.records[i] * stride + gpuprims::kMaterialWord);
      words.push_back(record_word(snapshot, joints, now.slots[i]));
    }
    write(target, sizeof(std::uint32_t), places, words.data());
  });
}

/// Calls visit() for each batch that has some of the slots.
template <class Visit>
void GpuScene::for_each_batch(const Snapshot& snapshot, std::span<const Slot> changed, const Visit& visit) {
  std::array<std::vector<std::uint64_t>, kBatchKindCount> of_kind;  // record << 32 | slot
  for (std::size_t i = 0; i < changed.size(); ++i) {
    if (i + kPrefetchAhead < changed.size()) prefetch_slot(snapshot, changed[i + kPrefetchAhead]);
    const std::uint64_t record = record_of(snapshot, changed[i]);
    of_kind[std::size_t(batch_of(snapshot.kind(changed[i])))].push_back(record << 32 | changed[i]);
  }
  for (std::size_t kind = 0; kind < of_kind.size(); ++kind) {
    if (of_kind[kind].empty()) continue;
    const Batch* target = batch(BatchKind(kind));
    assert(target && "slots were appended: append() comes first");
    core::radix_sort<32>(of_kind[kind]);
    Changed now;
    for (const std::uint64_t entry : of_kind[kind]) {
      now.records.push_back(std::uint32_t(entry >> 32));
      now.slots.push_back(Slot(entry));
      if (target->kind == BatchKind::kMesh) meshes_.update(snapshot, now.slots.back(), now.records.back());
    }
    visit(*target, now);
  }
}

const Batch* GpuScene::batch(BatchKind kind) const {
  for (const Batch& b : batches_)
    if (b.kind == kind) return &b;
  return nullptr;
}

std::size_t GpuScene::memory_bytes() const {
  std::size_t bytes = meshes_.memory_bytes() + materials_.buffer.size();
  for (const Batch& b : batches_) bytes += b.records.size() + b.larger.size();
  return bytes;
}

}  // namespace sightline::gpuscene
