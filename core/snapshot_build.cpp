// Building a snapshot anew, from a scene or from copies of items.
//
// Items are asked for twice: for their boxes, from which the order follows, and again to write each into its slot.
// Nothing lies between but the boxes and the order. Threads share everything but the walk over the nodes, the counts of
// kinds and the cut into chunks.
#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <vector>

#include "sightline/core/block_order.h"
#include "sightline/core/internal/prefetch.h"
#include "sightline/core/internal/snapshot_copies.h"

#ifdef _OPENMP
#include <omp.h>
#endif

namespace sightline::core {
namespace {

/// Items that a thread takes at once. Several words of vacant bits, several blocks, several steps of ranks: what lies
/// in such a thing belongs to one thread.
constexpr std::size_t kPiece = 1024;

std::size_t piece_count(std::size_t count) {
  return (count + kPiece - 1) / kPiece;
}

/// work(piece, first, end) for each piece of 0 … count.
template <class Work>
void for_pieces(std::size_t count, [[maybe_unused]] int threads, const Work& work) {
  const std::size_t pieces = piece_count(count);
#ifdef _OPENMP
  constexpr std::size_t kSlotsWorthThreads = 65536;
  const int used = threads > 0 ? threads : count < kSlotsWorthThreads ? 1 : omp_get_max_threads();
#pragma omp parallel for schedule(dynamic) num_threads(used) if (used > 1 && pieces > 1)
#endif
  for (std::size_t piece = 0; piece < pieces; ++piece)
    work(piece, piece * kPiece, std::min(count, (piece + 1) * kPiece));
}

/// Capacity with headroom, so that an edit that grows arrays of a million items does not copy them.
std::size_t with_headroom(std::size_t count) {
  return count + count * 3 / 8;
}

template <class T>
void resize(LargeArray<T>& array, std::size_t count) {
  array.reserve(with_headroom(count));
  array.resize_for_overwrite(count);
  array.spare_room();
}

std::uint64_t next_generation() {
  static std::atomic<std::uint64_t> counter{0};
  return ++counter;
}

/// Without a box and a payload.
ItemCopies::Record record_of(const Scene& scene, const Scene::ItemState& state, ItemId item) {
  ItemCopies::Record r;
  r.item = item;
  r.kind = scene.kind(item);
  r.layers = state.layers;
  r.material = state.material;
  r.linear = mat3(state.world_from_item.linear);
  r.origin = state.world_from_item.origin;
  return r;
}

}  // namespace

/// The items of a scene, by id. Each is looked up when it is asked for: copies would take as much memory as the
/// snapshot, and to get new memory from the system is what takes the longest.
class Snapshot::SceneItems {
 public:
  SceneItems(const Scene& scene, int threads) : scene_(scene) {
    nodes_.reserve(scene.node_count());
    scene.for_each_node(scene.root(),
                        [&](NodeId id, const Affine& world, bool visible, std::uint32_t layers, MaterialId material) {
                          if (scene.first_item(id) == kNoItem) return;
                          if (id.index >= nodes_.size()) nodes_.resize_for_overwrite(id.index + 1);
                          nodes_[id.index] = {world, layers, material, visible};
                        });
    const std::size_t ids = scene.item_slots();
    std::vector<std::size_t> places(piece_count(ids) + 1);
    for_pieces(ids, threads, [&](std::size_t piece, std::size_t first, std::size_t end) {
      std::size_t living = 0;
      for (std::size_t i = first; i < end; ++i) living += scene.contains_item(ItemId(i));
      places[piece + 1] = living;
    });
    std::partial_sum(places.begin(), places.end(), places.begin());
    items_.resize_for_overwrite(places.back());
    std::vector<Summary> summaries(piece_count(ids));
    for_pieces(ids, threads, [&](std::size_t piece, std::size_t first, std::size_t end) {
      std::size_t place = places[piece];
      Summary summary;
      for (std::size_t i = first; i < end; ++i) {
        if (!scene.contains_item(ItemId(i))) continue;
        items_[place++] = ItemId(i);
        const Scene::ItemState item = state(ItemId(i));
        summary.origins.grow(item.world_from_item.origin);
        summary.layers |= item.layers;
      }
      summaries[piece] = summary;
    });
    AabbD origins;
    for (const Summary& some : summaries) origins.grow(some.origins), layers_ |= some.layers;
    // Whole metres, so that the origin itself is exact in float while it is small.
    if (!origins.empty()) origin_ = glm::round(origins.centre());
  }

  const dvec3& origin() const { return origin_; }   ///< of the bounds
  std::uint32_t layers() const { return layers_; }  ///< that any visible item is on
  std::size_t size() const { return items_.size(); }
  std::size_t item_slots() const { return scene_.item_slots(); }
  Kind kind(std::size_t i) const { return scene_.kind(items_[i]); }
  Items::Record record(std::size_t i) const {
    Items::Record r = record_of(scene_, state(items_[i]), items_[i]);
    r.payload = scene_.items_[to_index(items_[i])].payload;
    return r;
  }
  Aabb box(std::size_t i) const {
    return round_outwards(scene_.bounds_under(items_[i], state(items_[i]).world_from_item), origin_);
  }
  const float* parameters() const { return scene_.parameters_.data(); }
  /// What record(order[at]) reads, ahead of it, and half as far ahead what that leads to.
  void prefetch_ahead(std::span<const std::uint32_t> order, std::size_t at) const {
    if (at + kPrefetchAhead < order.size()) prefetch(scene_.items_[to_index(items_[order[at + kPrefetchAhead]])]);
    if (at + kPrefetchAhead / 2 >= order.size()) return;
    const Scene::Item& item = scene_.items_[to_index(items_[order[at + kPrefetchAhead / 2]])];
    prefetch(nodes_[item.node]);
    if (int(item.kind) < kPrimitiveKindCount) prefetch(scene_.parameters_[item.payload]);
  }

 private:
  struct Node {
    Affine world;
    std::uint32_t layers;
    MaterialId material;
    bool visible;
  };
  struct Summary {
    AabbD origins;
    std::uint32_t layers = 0;
  };
  Scene::ItemState state(ItemId item) const {
    const Node& node = nodes_[scene_.items_[to_index(item)].node];
    return scene_.state(item, node.world, node.visible, node.layers, node.material);
  }

  const Scene& scene_;
  LargeArray<Node> nodes_;  // by index; set for those with items
  LargeArray<ItemId> items_;
  dvec3 origin_{0.0};
  std::uint32_t layers_ = 0;
};

/// Copies of items, each once.
class Snapshot::CopiedItems {
 public:
  explicit CopiedItems(const Items& items) : items_(items) {
    for (const auto& r : items.records)
      item_slots_ = std::max(item_slots_, std::size_t(to_index(r.item)) + 1), layers_ |= r.layers;
  }
  std::uint32_t layers() const { return layers_; }
  std::size_t size() const { return items_.records.size(); }
  std::size_t item_slots() const { return item_slots_; }
  Kind kind(std::size_t i) const { return items_.records[i].kind; }
  const Items::Record& record(std::size_t i) const { return items_.records[i]; }
  const Aabb& box(std::size_t i) const { return items_.records[i].box; }
  const float* parameters() const { return items_.parameters.data(); }
  void prefetch_ahead(std::span<const std::uint32_t> order, std::size_t at) const {
    if (at + kPrefetchAhead < order.size()) prefetch(items_.records[order[at + kPrefetchAhead]]);
  }

 private:
  const Items& items_;
  std::size_t item_slots_ = 0;
  std::uint32_t layers_ = 0;
};

Snapshot::Snapshot(const Scene& scene, int threads) : scene_(&scene), generation_(next_generation()) {
  meshes_ = scene.mesh_table_.list();
  const auto stored = scene.stored_snapshot_;
  const bool restored = stored && (*stored)(*this);
  table_ = updated({}, scene, {});
  if (restored) return;
  const SceneItems items(scene, threads);
  bounds_.origin = items.origin();
  build(items, threads);
}

Snapshot::Snapshot(const Snapshot& like, Items&& items, int threads)
    : scene_(like.scene_), generation_(next_generation()) {
  bounds_.origin = like.bounds_.origin;
  if (items.materials) table_ = items.materials;
  meshes_ = items.meshes;
  auto& records = items.records;
  LargeArray<std::uint32_t> latest;  // by item
  latest.resize(CopiedItems(items).item_slots(), kNone);
  for (std::size_t i = 0; i < records.size(); ++i) latest[to_index(records[i].item)] = std::uint32_t(i);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (latest[to_index(records[i].item)] != i) continue;
    Items::Record& r = records[kept++] = records[i];
    if (r.layers != 0) continue;
    // Hidden items are ordered by where they will reappear. That is exact for primitives; a mesh would have to be
    // walked over, so the origin of its item must do.
    const Affine world{dmat3(r.linear), r.origin};
    AabbD box{r.origin, r.origin};
    if (int(r.kind) < kPrimitiveKindCount)
      box = core::bounds(
          make_primitive(r.kind, std::span(items.parameters).subspan(r.payload, std::size_t(parameter_count(r.kind)))),
          world);
    r.box = round_outwards(box, bounds_.origin);
  }
  records.resize(kept);
  latest = {};
  build(CopiedItems(items), threads);
}

/// Appends a record without a box; returns the box in the world.
AabbD Snapshot::gather(const Scene& scene, const Scene::ItemState& state, ItemId item, Items& out) {
  Items::Record r = record_of(scene, state, item);
  if (int(r.kind) >= kPrimitiveKindCount) {
    r.payload = scene.mesh_of(item).index;
  } else {
    r.payload = std::uint32_t(out.parameters.size());
    const Primitive primitive = scene.primitive(item);
    const auto values = parameters(primitive);
    out.parameters.insert(out.parameters.end(), values.begin(), values.end());
  }
  out.records.push_back(r);
  return scene.bounds_under(item, state.world_from_item);
}

template <class Source>
void Snapshot::build(const Source& source, int threads) {
  const std::size_t n = source.size();
  LargeArray<Aabb> boxes;
  boxes.resize_for_overwrite(n);
  for_pieces(n, threads, [&](std::size_t, std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) boxes[i] = source.box(i);
  });
  // Only the order is kept. A subtree is a range of slots, and code that traverses the hierarchy builds the nodes it
  // needs.
  const std::vector<std::uint32_t> order = block_order({boxes.data(), n}, {.threads = threads});
  ordered_size_ = n;

  resize(kinds_, n);
  for_pieces(n, threads, [&](std::size_t, std::size_t first, std::size_t end) {
    for (std::size_t s = first; s < end; ++s) kinds_[s] = source.kind(order[s]);
  });
  ranks_.reserve(with_headroom(n) / kRankStride + 2);
  extend_ranks();
  resize(slots_, source.item_slots());
  for_pieces(slots_.size(), threads, [&](std::size_t, std::size_t first, std::size_t end) {
    std::fill(slots_.data() + first, slots_.data() + end, kNone);
  });
  make_room((source.layers() & ~std::uint32_t(kLayerModel)) != 0);

  LargeArray<dvec3> places;  // by slot
  places.resize_for_overwrite(n);
  std::vector<Aabb> extents(piece_count(n));
  for_pieces(n, threads, [&](std::size_t piece, std::size_t first, std::size_t end) {
    extents[piece] = write(source, order, boxes, first, end, places);
  });
  for (const Aabb& extent : extents) bounds_.extent_.grow(extent);
  count_vacant();
  if (vacant_count() == 0) vacant_ = {}, vacant_before_ = {};

  const std::vector<std::uint32_t> chunk_of = chunks_.cut({places.data(), n});
  for_pieces(n, threads, [&](std::size_t, std::size_t first, std::size_t end) {
    for (std::size_t s = first; s < end; ++s) {
      Placement& p = placement(Slot(s));
      p = place(p.linear, places[s], chunk_of[s]);
    }
  });
}

/// Writes the items of slots first … end - 1 into all arrays, all but where they lie in their chunk: that needs the
/// `places` of all slots, in the world. Returns the union of the boxes.
template <class Source>
Aabb Snapshot::write(const Source& source, std::span<const std::uint32_t> order, const LargeArray<Aabb>& boxes,
                     std::size_t first, std::size_t end, LargeArray<dvec3>& places) {
  std::array<std::uint32_t, kKindCount> next{};
  for (std::size_t k = 0; k < kKindCount; ++k) next[k] = rank(Kind(k), Slot(first));
  Aabb block, extent;
  for (std::size_t s = first; s < end; ++s) {
    source.prefetch_ahead(order, s);
    if (s + kPrefetchAhead < order.size()) prefetch(boxes[order[s + kPrefetchAhead]]);
    const Items::Record& r = source.record(order[s]);
    const std::uint32_t index = next[std::size_t(r.kind)]++;
    KindItems& list = kind_items_[std::size_t(r.kind)];
    if (int(r.kind) < kPrimitiveKindCount) {
      const auto count = std::size_t(parameter_count(r.kind));
      std::copy_n(source.parameters() + r.payload, count, list.parameters.data() + index * count);
    } else {
      list.meshes[index] = r.payload;
    }
    list.members[index] = Slot(s);
    list.placements[index].linear = r.linear;
    places[s] = r.origin;
    index_in_kind_[s] = index;
    items_[s] = r.item;
    slots_[to_index(r.item)] = Slot(s);
    materials_[s] = r.material;

    const Aabb& box = boxes[order[s]];
    block.grow(box);
    if ((s + 1) % kBlockSlots == 0 || s + 1 == order.size()) {
      block_sizes_[s / kBlockSlots] = size_of(block);
      block = {};
    }
    const bool vacant = r.layers == 0 || box.empty();
    bounds_.store(s, vacant ? Aabb{} : box);
    if (!vacant) extent.grow(box);
    if (vacant) vacant_[s / kRankStride] |= std::uint64_t(1) << s % kRankStride;
    if (bounds_.uses_layers()) bounds_.layers_[s] = r.layers != 0 ? r.layers : std::uint32_t(kLayerModel);
  }
  return extent;
}

/// Sizes the arrays by slot and by kind, once the kinds are known.
void Snapshot::make_room(bool with_layers) {
  const std::size_t n = kinds_.size();
  bounds_.reserve(with_headroom(n));
  bounds_.resize_for_overwrite(n, with_layers);
  resize(index_in_kind_, n), resize(items_, n), resize(materials_, n);
  resize(block_sizes_, (n + kBlockSlots - 1) / kBlockSlots);
  vacant_.resize(n / kRankStride + 1);
  for (std::size_t k = 0; k < kKindCount; ++k) {
    KindItems& list = kind_items_[k];
    const std::size_t count = rank(Kind(k), Slot(n));
    resize(list.members, count);
    resize(list.placements, count);
    if (int(k) < kPrimitiveKindCount)
      resize(list.parameters, count * std::size_t(parameter_count(Kind(k))));
    else
      resize(list.meshes, count);
  }
}

}  // namespace sightline::core
