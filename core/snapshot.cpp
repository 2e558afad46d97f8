#include "sightline/core/snapshot.h"

#include <algorithm>
#include <bit>
#include <cassert>

#include "sightline/core/internal/snapshot_copies.h"

namespace sightline::core {
namespace {

glm::vec4 material_row(const Scene& scene, std::size_t material) {
  const MaterialId id = scene.material_at(material);
  const Material style = id.valid() ? scene.material(id) : Material();
  return {style.colour, style.alpha};
}

}  // namespace

// --- slots -----------------------------------------------------------------------------------------------------------

/// Width + depth + height.
float Snapshot::size_of(const Aabb& box) {
  return box.empty() ? 0.0f : box.max.x - box.min.x + (box.max.y - box.min.y) + (box.max.z - box.min.z);
}

void Snapshot::append(const Items& items, std::uint32_t record, std::uint32_t chunk) {
  const Items::Record& r = items.records[record];
  const Slot s = Slot(kinds_.size());
  KindItems& list = kind_items_[std::size_t(r.kind)];
  if (to_index(r.item) >= slots_.size()) slots_.resize(to_index(r.item) + 1, kNone);
  if (int(r.kind) < kPrimitiveKindCount) {
    const std::size_t count = std::size_t(parameter_count(r.kind));
    const auto values = items.parameters.begin() + std::ptrdiff_t(r.payload);
    list.parameters.insert(list.parameters.end(), values, values + std::ptrdiff_t(count));
  } else {
    list.meshes.push_back(r.payload);
  }
  kinds_.push_back(r.kind);
  index_in_kind_.push_back(std::uint32_t(list.size()));
  items_.push_back(r.item);
  slots_[to_index(r.item)] = s;
  materials_.push_back(r.material);
  list.members.push_back(s);
  list.placements.push_back(place(r.linear, r.origin, chunk));
  show(s, r.box, r.layers);
}

void Snapshot::show(Slot s, const Aabb& box, std::uint32_t layers) {
  const bool vacant = layers == 0 || box.empty();
  bounds_.set(s, vacant ? Aabb{} : box);
  if (layers != 0) bounds_.set_layers(s, layers);
  const std::size_t word = s / kRankStride;
  if (vacant && word >= vacant_.size()) vacant_.resize(word + 1);
  if (word >= vacant_.size()) return;
  const std::uint64_t bit = std::uint64_t(1) << s % kRankStride;
  vacant_[word] = vacant ? vacant_[word] | bit : vacant_[word] & ~bit;
}

Placement Snapshot::place(const mat3& linear, const dvec3& origin, std::uint32_t chunk) const {
  return {linear, vec3(origin - chunks_.origins()[chunk]), chunk};
}

/// `former` with the current colours of `materials`, and with the materials that were added since.
std::shared_ptr<Snapshot::Table> Snapshot::updated(const Table& former, const Scene& scene,
                                                   std::span<const std::uint32_t> materials) {
  auto table = std::make_shared<Table>(former);
  const std::size_t known = former.of_scene;
  table->of_scene = std::max(known, scene.material_slots());
  if (table->first_override_row == 0)
    table->rows.resize(table->of_scene);
  else if (table->of_scene > table->first_override_row)
    table->move_override_rows();
  for (const std::uint32_t material : materials)
    if (material < known) table->rows[material] = material_row(scene, material);
  for (std::size_t material = known; material < table->of_scene; ++material)
    table->rows[material] = material_row(scene, material);
  return table;
}

/// Leaves room for as many materials as the scene has, so that overrides seldom move.
void Snapshot::Table::move_override_rows() {
  constexpr std::size_t kSpare = 64;
  const std::size_t before = first_override_row == 0 ? rows.size() : first_override_row;
  first_override_row = 2 * of_scene + kSpare;
  rows.insert(rows.begin() + std::ptrdiff_t(before), first_override_row - before, glm::vec4(0.0f));
}

// --- overrides -------------------------------------------------------------------------------------------------------

void Snapshot::hide(std::span<const Slot> slots) {
  if (!slots.empty()) stored_.reset();
  for (const Slot s : slots) show(s, {}, 0);
  count_vacant();
}

void Snapshot::show(std::span<const Slot> slots, std::span<const Shown> as) {
  assert(slots.size() == as.size());
  if (!slots.empty()) stored_.reset();
  for (std::size_t i = 0; i < slots.size(); ++i) show(slots[i], as[i].box, as[i].layers);
  count_vacant();
}

void Snapshot::set_override_row(std::uint32_t number, const glm::vec4& style) {
  if (table_.use_count() > 1) table_ = std::make_shared<Table>(*table_);
  if (table_->first_override_row == 0) table_->move_override_rows();
  const std::size_t row = table_->first_override_row + number;
  if (row >= table_->rows.size()) table_->rows.resize(row + 1, glm::vec4(0.0f));
  table_->rows[row] = style;
}

// --- counting --------------------------------------------------------------------------------------------------------

void Snapshot::extend_ranks() {
  if (ranks_.empty()) ranks_.push_back({});
  // The last block may have been partial: everything before it stays.
  for (std::size_t block = ranks_.size() - 1; (block + 1) * kRankStride <= kinds_.size(); ++block) {
    auto next = ranks_[block];
    for (std::size_t s = block * kRankStride; s < (block + 1) * kRankStride; ++s) ++next[std::size_t(kinds_[s])];
    ranks_.push_back(next);
  }
}

std::uint32_t Snapshot::rank(Kind kind, Slot slot) const {
  assert(slot <= size());
  const std::size_t block = slot / kRankStride;
  std::uint32_t rank = ranks_[block][std::size_t(kind)];
  for (std::size_t s = block * kRankStride; s < slot; ++s) rank += kinds_[s] == kind;
  return rank;
}

void Snapshot::count_vacant() {
  if (vacant_.empty()) return;
  vacant_.resize(size() / kRankStride + 1);
  vacant_before_.resize(vacant_.size() + 1);
  std::uint32_t before = 0;
  for (std::size_t word = 0; word < vacant_.size(); ++word) {
    vacant_before_[word] = before;
    before += std::uint32_t(std::popcount(vacant_[word]));
  }
  vacant_before_.back() = before;
}

std::uint32_t Snapshot::vacant_below(Slot s) const {
  const std::size_t word = s / kRankStride;
  const std::uint64_t below = (std::uint64_t(1) << s % kRankStride) - 1;
  return vacant_before_[word] + std::uint32_t(std::popcount(vacant_[word] & below));
}

Slot Snapshot::first_where(bool vacant, Slot first, Slot end) const {
  for (Slot s = first; s < end; s = Slot((s / kRankStride + 1) * kRankStride)) {
    const std::uint64_t word = vacant ? vacant_[s / kRankStride] : ~vacant_[s / kRankStride];
    if (const std::uint64_t found = word >> s % kRankStride) return std::min(end, s + Slot(std::countr_zero(found)));
  }
  return end;
}

std::uint64_t Snapshot::count(const VisibleSet& visible) const {
  std::uint64_t n = visible.count();
  if (vacant_count() > 0)
    for (const SlotRange& r : visible.ranges) n -= vacant_below(r.first + r.count) - vacant_below(r.first);
  return n;
}

// --- looking up ------------------------------------------------------------------------------------------------------

Affine Snapshot::world_from_item(Slot s) const {
  const Placement& p = kind_items_[std::size_t(kinds_[s])].placements[index_in_kind_[s]];
  return {dmat3(p.linear), dvec3(p.origin) + chunks_.origins()[p.chunk]};
}

Primitive Snapshot::primitive(Slot s) const {
  const int count = parameter_count(kinds_[s]);
  const KindItems& list = kind_items_[std::size_t(kinds_[s])];
  return make_primitive(
      kinds_[s],
      std::span(list.parameters).subspan(std::size_t(index_in_kind_[s]) * std::size_t(count), std::size_t(count)));
}

const Mesh& Snapshot::mesh(Slot s) const {
  return meshes_[kind_items_[std::size_t(kinds_[s])].meshes[index_in_kind_[s]]];
}

std::shared_ptr<const Mesh> Snapshot::share_mesh(Slot s) const {
  return meshes_.share(kind_items_[std::size_t(kinds_[s])].meshes[index_in_kind_[s]]);
}

std::size_t Snapshot::memory_bytes() const {
  std::size_t bytes = bounds_.memory_bytes() + table_->rows.capacity() * sizeof(glm::vec4) +
                      kinds_.capacity() * sizeof(Kind) +
                      (index_in_kind_.capacity() + items_.capacity() + slots_.capacity() + materials_.capacity()) * 4 +
                      ranks_.capacity() * sizeof(ranks_[0]) + chunks_.memory_bytes() +
                      (block_sizes_.capacity() + vacant_before_.capacity()) * 4 + vacant_.capacity() * 8;
  for (const KindItems& k : kind_items_)
    bytes += k.placements.capacity() * sizeof(Placement) +
             (k.members.capacity() + k.parameters.capacity() + k.meshes.capacity()) * 4;
  return bytes;
}

}  // namespace sightline::core
