#include "sightline/core/snapshot.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <limits>

namespace sightline::core {
namespace {

constexpr std::uint32_t kRankStride = 64;
constexpr double kChunkSize = 16.0;       // metres: float then resolves a micrometre at the chunk's edge
constexpr std::size_t kMaxChunks = 4096;  // their camera-relative origins are uploaded every frame

std::uint64_t next_generation() {
  static std::atomic<std::uint64_t> counter{0};
  return ++counter;
}

Placement relative_placement(const Affine& world_from_item, const dvec3& chunk_origin, std::uint32_t chunk) {
  return {mat3(world_from_item.linear), vec3(world_from_item.origin - chunk_origin), chunk};
}

/// Cuts a sequence of points into runs whose bounds are at most `limit` wide; gives each run's centre and the run of
/// each point.
std::vector<dvec3> cut_into_chunks(const std::vector<dvec3>& points, double limit,
                                   std::vector<std::uint32_t>& chunk_of) {
  std::vector<dvec3> origins;
  AabbD run;
  const auto close = [&] {
    if (!run.empty()) origins.push_back(run.centre());
    run = {};
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    AabbD grown = run;
    grown.grow(points[i]);
    const dvec3 size = grown.size();
    if (!run.empty() && std::max({size.x, size.y, size.z}) > limit) {
      close();
      grown = {points[i], points[i]};
    }
    run = grown;
    chunk_of[i] = std::uint32_t(origins.size());
  }
  close();
  return origins;
}

}  // namespace

/// The scene's live items in scene order, before they are sorted.
struct Snapshot::Gathered {
  std::vector<ItemId> items;
  std::vector<Scene::ItemState> states;
};

Snapshot::Snapshot(const Scene& scene, const BvhConfig& config) : scene_(&scene), generation_(next_generation()) {
  Gathered all;
  all.items.reserve(scene.item_count());
  all.states.reserve(scene.item_count());
  AabbD origins;
  scene.for_each_node(scene.root(),
                      [&](NodeId node, const Affine& world, bool visible, std::uint32_t layers, MaterialId m) {
                        for (ItemId item = scene.first_item(node); item != kNone; item = scene.next_item(item)) {
                          all.items.push_back(item);
                          all.states.push_back(scene.state(item, world, visible, layers, m));
                          origins.grow(all.states.back().world_from_item.origin);
                        }
                      });
  // Whole metres, so that the origin itself is exact in float while it is small.
  if (!origins.empty()) bounds_.origin = glm::round(origins.centre());

  const std::size_t n = all.items.size();
  std::vector<Aabb> boxes(n);
  for (std::size_t i = 0; i < n; ++i)
    boxes[i] = round_outwards(scene.bounds_under(all.items[i], all.states[i].world_from_item), bounds_.origin);
  // Only the order is kept: a subtree is a range of slots, and whoever traverses one makes the nodes it needs.
  const std::vector<std::uint32_t> order = build_bvh(boxes, config).order;

  std::vector<dvec3> places(n);
  for (std::size_t s = 0; s < n; ++s) places[s] = all.states[order[s]].world_from_item.origin;
  std::vector<std::uint32_t> chunk_of(n);
  chunk_size_ = kChunkSize;
  while ((chunk_origins_ = cut_into_chunks(places, chunk_size_, chunk_of)).size() > kMaxChunks) chunk_size_ *= 2.0;

  bounds_.resize(n);
  slots_.assign(scene.item_slots(), kNone);
  for (std::size_t s = 0; s < n; ++s) {
    const std::uint32_t i = order[s];
    append(all.items[i], all.states[i], chunk_of[s]);
    bounds_.set(s, boxes[i]);
    bounds_.set_layers(s, all.states[i].layers);
  }
  tree_size_ = n;
  extend_ranks();
}

void Snapshot::append(ItemId item, const Scene::ItemState& state, std::uint32_t chunk) {
  const Slot slot = Slot(kinds_.size());
  const Kind kind = scene_->kind(item);
  KindItems& list = kind_items_[std::size_t(kind)];
  kinds_.push_back(kind);
  index_in_kind_.push_back(std::uint32_t(list.size()));
  items_.push_back(item);
  slots_[item] = slot;
  materials_.push_back(state.material);
  list.slots.push_back(slot);
  list.placements.push_back(relative_placement(state.world_from_item, chunk_origins_[chunk], chunk));
  if (int(kind) < kPrimitiveKindCount) {
    const Primitive primitive = scene_->primitive(item);
    const auto values = parameters(primitive);
    list.parameters.insert(list.parameters.end(), values.begin(), values.end());
  } else {
    list.meshes.push_back(scene_->mesh_of(item).index);
  }
}

std::uint32_t Snapshot::chunk_for(const dvec3& place, std::uint32_t own, std::uint32_t likely, const dvec3& fresh) {
  const auto distance = [&](std::uint32_t c) { return glm::distance(chunk_origins_[c], place); };
  for (const std::uint32_t c : {own, likely})
    if (c < chunk_origins_.size() && distance(c) <= chunk_size_) return c;
  std::uint32_t nearest = kNone;
  double nearest_distance = std::numeric_limits<double>::infinity();
  for (std::uint32_t c = 0; c < chunk_origins_.size(); ++c) {
    const double d = distance(c);
    if (d < nearest_distance) nearest = c, nearest_distance = d;
  }
  const bool near_enough =
      nearest != kNone && (nearest_distance <= chunk_size_ || chunk_origins_.size() >= 2 * kMaxChunks);
  if (near_enough) return nearest;
  chunk_origins_.push_back(fresh);
  return std::uint32_t(chunk_origins_.size() - 1);
}

void Snapshot::apply(const SceneDelta& delta) {
  for (const ItemId item : delta.removed) {
    const Slot s = slot(item);
    if (s == kNone) continue;
    bounds_.set(s, {});
    bounds_.set_layers(s, 0);
    slots_[item] = kNone;
  }
  slots_.resize(scene_->item_slots(), kNone);
  std::vector<ItemId> known, fresh;
  for (const auto* list : {&delta.changed, &delta.inserted})
    for (const ItemId item : *list)
      if (scene_->contains_item(item)) (slot(item) != kNone ? known : fresh).push_back(item);

  const auto set_bounds = [&](Slot s, const Scene::ItemState& state) {
    bounds_.set(s, round_outwards(scene_->bounds_under(items_[s], state.world_from_item), bounds_.origin));
    bounds_.set_layers(s, state.layers);
  };
  std::vector<std::uint32_t> moved_to(chunk_origins_.size(), kNone);  // by chunk: where the last item of it went
  scene_->for_each_state(known, [&](ItemId item, const Scene::ItemState& state) {
    const Slot s = slots_[item];
    Placement& placement = kind_items_[std::size_t(kinds_[s])].placements[index_in_kind_[s]];
    // What moves as a whole keeps its chunks: a new one lies where the old one has moved to.
    const dvec3 place = state.world_from_item.origin, offset(placement.origin);
    const std::uint32_t own = placement.chunk;
    const std::uint32_t chunk =
        chunk_for(place, own, moved_to[own], glm::length(offset) <= chunk_size_ ? place - offset : place);
    moved_to[own] = chunk;
    placement = relative_placement(state.world_from_item, chunk_origins_[chunk], chunk);
    materials_[s] = state.material;
    set_bounds(s, state);
  });
  bounds_.resize(bounds_.size() + fresh.size());
  std::uint32_t chunk = kNone;
  scene_->for_each_state(fresh, [&](ItemId item, const Scene::ItemState& state) {
    chunk = chunk_for(state.world_from_item.origin, chunk, chunk, state.world_from_item.origin);
    append(item, state, chunk);
    set_bounds(slots_[item], state);
  });
  extend_ranks();
}

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

Affine Snapshot::world_from_item(Slot s) const {
  const Placement& p = kind_items_[std::size_t(kinds_[s])].placements[index_in_kind_[s]];
  return {dmat3(p.linear), dvec3(p.origin) + chunk_origins_[p.chunk]};
}

Primitive Snapshot::primitive(Slot s) const {
  const int count = parameter_count(kinds_[s]);
  const KindItems& list = kind_items_[std::size_t(kinds_[s])];
  return make_primitive(
      kinds_[s],
      std::span(list.parameters).subspan(std::size_t(index_in_kind_[s]) * std::size_t(count), std::size_t(count)));
}

std::size_t Snapshot::memory_bytes() const {
  std::size_t bytes = bounds_.memory_bytes() + kinds_.capacity() * sizeof(Kind) +
                      (index_in_kind_.capacity() + items_.capacity() + slots_.capacity() + materials_.capacity()) * 4 +
                      ranks_.capacity() * sizeof(ranks_[0]) + chunk_origins_.capacity() * sizeof(dvec3);
  for (const KindItems& k : kind_items_)
    bytes += k.placements.capacity() * sizeof(Placement) +
             (k.slots.capacity() + k.parameters.capacity() + k.meshes.capacity()) * 4;
  return bytes;
}

}  // namespace sightline::core
