// Internal: the kernels of frustum culling over any instruction set. `Simd` tests sixteen boxes at a time. It lies in
// the anonymous namespace of its file, so that every instance is local to the file.
//
// The walk goes down level by level, through work queues. Nodes that one plane alone crosses wait in the queue of that
// plane. All others wait in a common queue, with the planes still to be tested. So the loop over a plane's queue has no
// branches, keeps its constants in registers, and can prefetch well ahead. (U. Assarsson, T. Möller 2000: planes a
// parent is inside of are not tested below.)
#pragma once

#include <cstring>

#include "sightline/core/internal/intrinsics.h"
#include "sightline/culling/frustum/internal/kernels.h"

namespace sightline::culling {

/// Tests sixteen items at a time against planes.
template <class Simd>
class ItemTester {
 public:
  static constexpr unsigned kAllLanes = 0xffff;

  explicit ItemTester(const ItemTest& test) : test_(test) {
    for (int k = 0; k < test.plane_count; ++k)
      for (int axis = 0; axis < 3; ++axis) p_vertex_[k][axis] = test.coordinates[test.planes[k].p_axis[axis]];
  }

  /// The items that one plane lets pass. Tests nothing else.
  unsigned visible(const typename Simd::Plane& plane, int k, const float* x, const float* y, const float* z,
                   std::size_t first) const {
    const typename Simd::Values s = Simd::evaluate(plane, x + first, y + first, z + first);
    const unsigned kept = ~Simd::below(s, plane) & kAllLanes, open = kept & ~Simd::above(s, plane);
    if (open == 0) [[likely]]
      return kept;
    return (kept & ~open) | test_.resolve(test_, first, open, PlaneMask(1) << k);
  }

  /// The visible items, for one plane or more. kPlain: layers do not matter, and no plane lets an empty box pass.
  template <bool kPlain>
  unsigned visible(std::size_t first, PlaneMask mask) const {
    const FloatPlane* planes = test_.planes;
    unsigned outside = 0, open = 0;
    for (PlaneMask m = mask & (kUnionPlanes - 1); m != 0; m &= m - 1) {
      const int k = int(core::lowest_bit(m));
      const typename Simd::Plane plane = Simd::spread(planes[k]);
      const typename Simd::Values s = p_values(k, plane, first);
      outside |= Simd::below(s, plane);
      if (outside == kAllLanes) return 0;
      open |= ~Simd::above(s, plane);
    }
    if ((mask & kUnionPlanes) != 0) {
      unsigned outside_all = kAllLanes, inside_any = 0;
      for (int k = test_.union_first; k < test_.plane_count; ++k) {
        const typename Simd::Plane plane = Simd::spread(planes[k]);
        const typename Simd::Values s = p_values(k, plane, first);
        outside_all &= Simd::below(s, plane);
        inside_any |= Simd::above(s, plane);
      }
      outside |= outside_all;
      open |= ~inside_any;
    }
    unsigned kept = ~outside & kAllLanes;
    if (kept == 0) return 0;
    if constexpr (!kPlain) kept &= items_shown(first);
    open &= kept;
    if (open != 0) kept = (kept & ~open) | test_.resolve(test_, first, open, mask);
    return kept;
  }

  /// Items that are not empty and on a layer of the view. A box with a NaN is not empty.
  unsigned items_shown(std::size_t first) const {
    unsigned empty = 0;
    for (int axis = 0; axis < 3; ++axis)
      empty |= Simd::less(Simd::load(test_.coordinates[axis + 3] + first), Simd::load(test_.coordinates[axis] + first));
    unsigned shown = ~empty & kAllLanes;
    // Layers are not padded: the last few are tested one by one.
    if (test_.layers != nullptr) shown &= layers_shared(first);
    return shown;
  }

 private:
  typename Simd::Values p_values(int k, const typename Simd::Plane& plane, std::size_t first) const {
    const auto& c = p_vertex_[k];
    return Simd::evaluate(plane, c[0] + first, c[1] + first, c[2] + first);
  }

  unsigned layers_shared(std::size_t first) const {
    if (first + kLanes <= test_.item_count) return Simd::share(test_.layers + first, test_.view_layers);
    unsigned bits = 0;
    for (std::size_t i = first; i < test_.item_count; ++i)
      bits |= unsigned((test_.layers[i] & test_.view_layers) != 0) << (i - first);
    return bits;
  }

  const ItemTest& test_;
  const float* p_vertex_[kMaxCullPlanes][3];  // coordinate arrays
};

template <class Simd, bool kLayers>
class Traversal {
 public:
  explicit Traversal(TraversalInput& in) : in_(in), items_(in.test) {}

  /// Whether every item is on a layer of the view. Then layers need no further test.
  static bool all_shown(const TraversalInput& in) {
    const LevelView& top = in.levels[in.level_count - 1];
    unsigned alive = kAllLanes;
    return (~look_at_layers(top.layers[0], in.test.view_layers, alive) & top.last_lanes) == 0;
  }

  void run() {
    crossing_count_[0] = 1;
    in_.crossings[0][0] = {0, in_.all_planes};
    int current = 0;
    for (int level = in_.level_count - 1; level > 0; --level, current ^= 1) {
      begin_level(level, current);
      cross_nodes<false>();
      for (int k = 0; k < in_.test.plane_count; ++k)
        next_count_[k] = std::uint32_t(plane_nodes<false>(k, next_queue(k) + next_count_[k]) - next_queue(k));
      for (int k = 0; k < in_.test.plane_count; ++k) plane_count_[k] = next_count_[k];
      crossing_count_[0] = crossing_count_[1];
    }
    begin_level(0, current);
    cross_nodes<true>();
    for (int k = 0; k < in_.test.plane_count; ++k)
      plane_leaves(k, std::size_t(plane_nodes<true>(k, leaf_queue(k) + next_count_[k]) - leaf_queue(k)));
    cross_leaves();
  }

 private:
  static constexpr unsigned kAllLanes = 0xffff;
  // Entries between prefetch and use. A core can wait for some two dozen lines at a time for its first cache, which is
  // four leaves, and for more for its second: hence two steps.
  static constexpr std::size_t kAhead = 4, kFarAhead = 28;
  static constexpr core::CacheLevel kToL1 = core::CacheLevel::kL1, kToL2 = core::CacheLevel::kL2;

  std::uint32_t* next_queue(int k) const { return in_.node_queues[current_ ^ 1] + std::size_t(k) * in_.stride; }
  std::uint32_t* leaf_queue(int k) const { return in_.leaf_queue + std::size_t(k) * in_.leaf_stride; }
  const std::uint32_t* queue(int k) const { return in_.node_queues[current_] + std::size_t(k) * in_.stride; }

  void begin_level(int level, int current) {
    level_ = in_.levels[level];
    current_ = current;
    child_nodes_ = 1;  // in nodes of level 0
    for (int i = 1; i < level; ++i) child_nodes_ *= kLanes;
    for (std::uint32_t& count : next_count_) count = 0;
    crossing_count_[1] = 0;
  }

  unsigned used_lanes(std::uint32_t node) const { return node + 1 == level_.count ? level_.last_lanes : kAllLanes; }

  /// Records lanes that are wholly inside: as bits of leaves at the bottom, as toggles at both ends of runs of nodes
  /// above.
  template <bool kBottom>
  void emit_inside(std::uint32_t node, unsigned lanes) {
    if constexpr (kBottom) {
      in_.inside[node] = std::uint16_t(lanes);
      return;
    }
    const unsigned ends = lanes ^ lanes << 1;
    if (child_nodes_ == 1) {
      in_.toggles[node] = std::uint16_t(in_.toggles[node] ^ ends);
      in_.toggles[node + 1] = std::uint16_t(in_.toggles[node + 1] ^ ends >> 16);
      return;
    }
    for (unsigned rest = ends; rest != 0; rest &= rest - 1) {
      const std::uint64_t place = (std::uint64_t(node) * kLanes + core::lowest_bit(rest)) * child_nodes_;
      const std::uint32_t last = in_.levels[0].count;
      const std::uint32_t at = place < last ? std::uint32_t(place) : last;
      in_.toggles[at / kLanes] = std::uint16_t(in_.toggles[at / kLanes] ^ 1u << at % kLanes);
    }
  }

  /// Removes lanes without a common layer from `alive`. Returns the lanes of which every item is shown.
  static unsigned look_at_layers(const LayerNode& layers, std::uint32_t view_layers, unsigned& alive) {
    alive &= Simd::share(layers.any, view_layers);
    return Simd::share(layers.all, view_layers) | ~Simd::share(layers.any, ~view_layers);
  }

  template <bool kBottom>
  void push_crossing(std::uint32_t index, PlaneMask mask) {
    if constexpr (kBottom)
      in_.leaf_crossings[leaf_crossing_count_++] = {index, mask};
    else
      in_.crossings[current_ ^ 1][crossing_count_[1]++] = {index, mask};
  }

  /// Processes the queue of plane k. Children that the plane crosses go to `out`.
  template <bool kBottom>
  std::uint32_t* plane_nodes(int k, std::uint32_t* out) {
    const std::size_t count = plane_count_[k];
    if (count == 0) return out;
    const std::uint32_t* entries = queue(k);
    const FloatPlane& f = in_.test.planes[k];
    const typename Simd::Plane plane = Simd::spread(f);
    const HierarchyNode* nodes = level_.nodes;
    in_.nodes_tested += count * kLanes;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t node = entries[i];
      if (i + kFarAhead < count) prefetch_node<kToL2>(entries[i + kFarAhead]);
      if (i + kAhead < count) prefetch_node<kToL1>(entries[i + kAhead]);
      const auto& b = nodes[node].bounds;
      const typename Simd::Values p = Simd::evaluate(plane, b[f.p_axis[0]], b[f.p_axis[1]], b[f.p_axis[2]]);
      const typename Simd::Values n = Simd::evaluate(plane, b[f.n_axis[0]], b[f.n_axis[1]], b[f.n_axis[2]]);
      unsigned alive = ~Simd::below(p, plane) & used_lanes(node), shown = kAllLanes;
      const unsigned free = Simd::above(n, plane);
      if constexpr (kLayers) shown = look_at_layers(level_.layers[node], in_.test.view_layers, alive);
      const unsigned inside = alive & free & shown, open = alive & ~inside;
      emit_inside<kBottom>(node, inside);
      if constexpr (kBottom) in_.partial[node] = std::uint16_t(open);
      // A plane's queue ignores layers. So two kinds of children go to the common queue instead: at the bottom, leaves
      // with some items hidden; above it, nodes that only their layers keep open.
      unsigned elsewhere = 0;
      if constexpr (kLayers) elsewhere = open & (kBottom ? ~shown : free);
      for (unsigned rest = elsewhere; rest != 0; rest &= rest - 1) {
        const unsigned lane = core::lowest_bit(rest);
        push_crossing<kBottom>(node * kLanes + lane, (free >> lane & 1u) != 0 ? 0 : PlaneMask(1) << k);
      }
      out = Simd::append(out, node * kLanes, open & ~elsewhere);
    }
    return out;
  }

  /// Processes the common queue: nodes that several planes cross, or that only their layers keep open.
  template <bool kBottom>
  void cross_nodes() {
    in_.nodes_tested += crossing_count_[0] * kLanes;
    for (std::size_t i = 0; i < crossing_count_[0]; ++i) {
      const Crossing c = in_.crossings[current_][i];
      Crossed crossed;
      unsigned alive = used_lanes(c.index);
      find_crossed(level_.nodes[c.index], c.mask, alive, crossed);
      unsigned shown = kAllLanes;
      if constexpr (kLayers) shown = look_at_layers(level_.layers[c.index], in_.test.view_layers, alive);
      const unsigned inside = alive & ~crossed.any & shown, open = alive & ~inside;
      emit_inside<kBottom>(c.index, inside);
      const unsigned single = open & crossed.any & ~crossed.several & (kBottom ? shown : kAllLanes);
      if constexpr (kBottom) in_.partial[c.index] = std::uint16_t(open);
      for (PlaneMask m = single != 0 ? c.mask & (kUnionPlanes - 1) : 0; m != 0; m &= m - 1) {
        const int k = int(core::lowest_bit(m));
        std::uint32_t* const out = kBottom ? leaf_queue(k) : next_queue(k);
        next_count_[k] =
            std::uint32_t(Simd::append(out + next_count_[k], c.index * kLanes, crossed.by[k] & single) - out);
      }
      for (unsigned rest = open & ~single; rest != 0; rest &= rest - 1) {
        const unsigned lane = core::lowest_bit(rest);
        PlaneMask mask = 0;
        for (PlaneMask m = c.mask; m != 0; m &= m - 1)
          mask |= PlaneMask(crossed.by[core::lowest_bit(m)] >> lane & 1u) << core::lowest_bit(m);
        push_crossing<kBottom>(c.index * kLanes + lane, mask);
      }
    }
  }

  /// by: the lanes of a node that each plane of a mask crosses; the last entry is for the union. any: lanes that any
  /// plane crosses. several: lanes that go on as crossed by several planes.
  struct Crossed {
    unsigned by[kMaxCullPlanes + 1];
    unsigned any = 0, several = 0;
  };

  /// Removes lanes that are outside from `alive`.
  void find_crossed(const HierarchyNode& node, PlaneMask mask, unsigned& alive, Crossed& crossed) const {
    for (PlaneMask m = mask & (kUnionPlanes - 1); m != 0; m &= m - 1) {
      const int k = int(core::lowest_bit(m));
      unsigned outside = 0, inside = 0;
      classify(node, k, outside, inside);
      alive &= ~outside;
      crossed.by[k] = ~inside & kAllLanes;
      crossed.several |= crossed.any & crossed.by[k];
      crossed.any |= crossed.by[k];
    }
    if ((mask & kUnionPlanes) != 0) {
      unsigned outside_all = kAllLanes, inside_any = 0;
      for (int k = in_.test.union_first; k < in_.test.plane_count; ++k) {
        unsigned outside = 0, inside = 0;
        classify(node, k, outside, inside);
        outside_all &= outside;
        inside_any |= inside;
      }
      alive &= ~outside_all;
      crossed.by[kMaxCullPlanes] = ~inside_any & kAllLanes;
      crossed.several |= crossed.by[kMaxCullPlanes];
      crossed.any |= crossed.by[kMaxCullPlanes];
    }
  }

  void classify(const HierarchyNode& node, int k, unsigned& outside, unsigned& inside) const {
    const FloatPlane& f = in_.test.planes[k];
    const typename Simd::Plane plane = Simd::spread(f);
    const auto& b = node.bounds;
    outside = Simd::below(Simd::evaluate(plane, b[f.p_axis[0]], b[f.p_axis[1]], b[f.p_axis[2]]), plane);
    inside = Simd::above(Simd::evaluate(plane, b[f.n_axis[0]], b[f.n_axis[1]], b[f.n_axis[2]]), plane);
  }

  void plane_leaves(int k, std::size_t count) {
    const FloatPlane& f = in_.test.planes[k];
    const typename Simd::Plane plane = Simd::spread(f);
    const float *x = in_.test.coordinates[f.p_axis[0]], *y = in_.test.coordinates[f.p_axis[1]],
                *z = in_.test.coordinates[f.p_axis[2]];
    const std::uint32_t whole_leaves = in_.slot_count / kLeafSize;
    const std::uint32_t* const leaves = leaf_queue(k);
    in_.boxes_tested += count * kLeafSize;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t leaf = leaves[i];
      if (i + kFarAhead < count) prefetch<kToL2>(x, y, z, leaves[i + kFarAhead]);
      if (i + kAhead < count) prefetch<kToL1>(x, y, z, leaves[i + kAhead]);
      if (leaf >= whole_leaves) {
        answer_leaf(leaf, leaf_mask(leaf, PlaneMask(1) << k));
        continue;
      }
      const std::size_t first = std::size_t(leaf) * kLeafSize;
      const unsigned low = items_.visible(plane, k, x, y, z, first);
      answer_leaf(leaf, low | items_.visible(plane, k, x, y, z, first + kLanes) << kLanes);
    }
  }

  /// Marks leaves that turn out to be wholly inside or outside. Without a branch, which would be unpredictable.
  void answer_leaf(std::uint32_t leaf, std::uint32_t mask) {
    in_.leaf_masks[leaf] = mask;
    const std::uint32_t node = leaf / kLanes, lane = leaf % kLanes;
    const unsigned all = mask == ~0u, none = mask == 0;
    in_.inside[node] = std::uint16_t(in_.inside[node] | all << lane);
    in_.partial[node] = std::uint16_t(in_.partial[node] & ~((all | none) << lane));
  }

  template <core::CacheLevel kLevel>
  static void prefetch(const float* x, const float* y, const float* z, std::uint32_t leaf) {
    const std::size_t first = std::size_t(leaf) * kLeafSize;
    for (const float* c : {x + first, y + first, z + first}) {
      core::prefetch_line<kLevel>(c);
      core::prefetch_line<kLevel>(c + kLanes);
    }
  }
  template <core::CacheLevel kLevel>
  void prefetch_node(std::uint32_t node) const {
    for (int axis = 0; axis < 6; ++axis) core::prefetch_line<kLevel>(level_.nodes[node].bounds[axis]);
    if constexpr (kLayers) {
      core::prefetch_line<kLevel>(level_.layers[node].any);
      core::prefetch_line<kLevel>(level_.layers[node].all);
    }
  }

  void cross_leaves() {
    in_.boxes_tested += leaf_crossing_count_ * kLeafSize;
    for (std::size_t i = 0; i < leaf_crossing_count_; ++i) {
      if (i + kAhead < leaf_crossing_count_) {
        const float* const* c = in_.test.coordinates;
        prefetch<kToL1>(c[0], c[1], c[2], in_.leaf_crossings[i + kAhead].index);
        prefetch<kToL1>(c[3], c[4], c[5], in_.leaf_crossings[i + kAhead].index);
      }
      const Crossing& c = in_.leaf_crossings[i];
      answer_leaf(c.index, leaf_mask(c.index, c.mask));
    }
  }

  /// Tests any leaf against any planes. Slots behind the tree are left out.
  std::uint32_t leaf_mask(std::uint32_t leaf, PlaneMask mask) const {
    const std::size_t first = std::size_t(leaf) * kLeafSize, left = in_.slot_count - first;
    std::uint32_t kept = items_.template visible<!kLayers>(first, mask);
    if (left > kLanes) kept |= items_.template visible<!kLayers>(first + kLanes, mask) << kLanes;
    return left < kLeafSize ? kept & ((1u << left) - 1u) : kept;
  }

  TraversalInput& in_;
  ItemTester<Simd> items_;
  LevelView level_{};
  int current_ = 0;
  std::uint64_t child_nodes_ = 1;
  std::uint32_t plane_count_[kMaxCullPlanes] = {}, next_count_[kMaxCullPlanes] = {};
  std::size_t crossing_count_[2] = {}, leaf_crossing_count_ = 0;
};

/// Turns the answers of a traversal into merged ranges and single slots, in rising order: 64 leaves, which are four
/// nodes, at a time. The leaves that are inside form a string of bits. A range begins and ends where neighbouring bits
/// differ.
template <class Simd>
class Extraction {
 public:
  Extraction(const TraversalInput& in, FoundSlots& found) : in_(in), items_(found.items), edges_(found.edges) {}

  void run(FoundSlots& found) {
    const std::uint32_t count = in_.levels[0].count;
    unsigned carry = 0;  // all ones while nodes are wholly inside
    for (std::uint32_t first = 0; first < count; first += kLanes) {
      unsigned whole = in_.toggles[first / kLanes];
      whole ^= whole << 1;
      whole ^= whole << 2;
      whole ^= whole << 4;
      whole ^= whole << 8;
      whole = (whole ^ carry) & 0xffffu;
      carry = 0u - (whole >> 15 & 1u);
      for (int quarter = 0; quarter < kLanes; quarter += kWordNodes)
        take(first + unsigned(quarter), whole >> quarter & (kLanes - 1));
    }
    if (last_inside_ != 0) *edges_++ = (count + kLanes - 1) / kLanes * kLanes * kLanes;
    found = {items_, edges_};
  }

 private:
  static constexpr int kWordNodes = 64 / kLanes;

  static std::uint64_t word(const std::uint16_t* bits) {
    std::uint64_t value;
    std::memcpy(&value, bits, sizeof(value));
    return value;
  }
  /// Widens each bit to sixteen.
  static std::uint64_t widen(unsigned bits) {
    const std::uint64_t places =
        (bits & 1u) | (bits & 2u) << 15 | std::uint64_t(bits & 4u) << 30 | std::uint64_t(bits & 8u) << 45;
    return places * 0xffffu;
  }

  void take(std::uint32_t node, unsigned whole) {
    const std::uint64_t inside = word(in_.inside + node) | widen(whole), partial = word(in_.partial + node);
    const std::uint64_t edges = inside ^ (inside << 1 | last_inside_);
    last_inside_ = inside >> 63;
    const std::uint32_t leaf = node * kLanes;
    if (edges != 0)
      for (int i = 0; i < kWordNodes; ++i)
        edges_ = Simd::append(edges_, leaf + unsigned(i) * kLanes, unsigned(edges >> (i * kLanes)) & 0xffffu);
    for (std::uint64_t rest = partial; rest != 0; rest &= rest - 1) {
      const std::uint32_t at = leaf + core::lowest_bit(rest), mask = in_.leaf_masks[at];
      items_ = Simd::append(items_, at * kLeafSize, mask & 0xffffu);
      items_ = Simd::append(items_, at * kLeafSize + kLanes, mask >> kLanes);
    }
  }

  const TraversalInput& in_;
  core::Slot *items_, *edges_;
  std::uint64_t last_inside_ = 0;
};

/// Groups lie in spatial order, so the plane that rejected the last group is tested first.
template <class Simd>
void cull_items(const ItemTest& test, PlaneMask mask, std::size_t first, std::size_t end, FoundSlots& found) {
  constexpr unsigned kAllLanes = 0xffff;
  struct Tested {
    const FloatPlane* plane;
    const float *x, *y, *z;
  };
  Tested planes[kMaxCullPlanes];
  int count = 0;
  for (PlaneMask m = mask & (kUnionPlanes - 1); m != 0; m &= m - 1) {
    const FloatPlane& f = test.planes[core::lowest_bit(m)];
    const auto& c = test.coordinates;
    planes[count++] = {&f, c[f.p_axis[0]], c[f.p_axis[1]], c[f.p_axis[2]]};
  }
  const ItemTester<Simd> tester(test);
  core::Slot *items = found.items, *edges = found.edges;
  for (std::size_t group = first; group < end; group += kLanes) {
    const unsigned beyond = end - group < std::size_t(kLanes) ? kAllLanes & ~0u << (end - group) : 0;
    unsigned outside = beyond, open = 0;
    for (int k = 0; k < count; ++k) {
      const Tested& t = planes[k];
      const typename Simd::Plane plane = Simd::spread(*t.plane);
      const typename Simd::Values s = Simd::evaluate(plane, t.x + group, t.y + group, t.z + group);
      outside |= Simd::below(s, plane);
      if (outside == kAllLanes) {
        const Tested rejecting = t;
        planes[k] = planes[0];
        planes[0] = rejecting;
        break;
      }
      open |= ~Simd::above(s, plane);
    }
    if (outside == kAllLanes) continue;

    unsigned kept = ~outside & tester.items_shown(group);
    open &= kept;
    if (open != 0) kept = (kept & ~open) | test.resolve(test, group, open, mask & (kUnionPlanes - 1));
    if ((mask & kUnionPlanes) != 0) kept &= tester.template visible<true>(group, kUnionPlanes);
    if (kept != kAllLanes) {
      items = Simd::append(items, core::Slot(group), kept);
    } else if (edges != found.edges && edges[-1] == group) {
      edges[-1] += kLanes;
    } else {
      edges[0] = core::Slot(group);
      edges[1] = core::Slot(group + kLanes);
      edges += 2;
    }
  }
  found = {items, edges};
}

template <class Simd>
constexpr FrustumKernels make_frustum_kernels() {
  FrustumKernels k{};
  k.traverse = [](TraversalInput& in) {
    if (in.levels[0].layers != nullptr && !Traversal<Simd, true>::all_shown(in))
      Traversal<Simd, true>(in).run();
    else
      Traversal<Simd, false>(in).run();
  };
  k.extract = [](const TraversalInput& in, FoundSlots& found) { Extraction<Simd>(in, found).run(found); };
  k.cull_items = cull_items<Simd>;
  k.count_up = [](core::Slot* out, core::Slot first, std::uint32_t count) {
    std::uint32_t i = 0;
    for (; i + kLanes <= count; i += kLanes) Simd::store_places(out + i, first + i);
    for (; i < count; ++i) out[i] = first + i;
  };
  k.leaf_box = [](const float* const(&c)[6], std::size_t first, float(&box)[6]) {
    static_assert(kLeafSize == 2 * kLanes);
    unsigned numbers = 0xffff;  // x <= x fails for a NaN
    for (int axis = 0; axis < 3; ++axis) {
      const float *low = c[axis] + first, *high = c[axis + 3] + first;
      for (const float* half : {low, low + kLanes, high, high + kLanes})
        numbers &= Simd::at_most(Simd::load(half), Simd::load(half));
      box[axis] = Simd::least(low);
      box[axis + 3] = Simd::most(high);
    }
    return numbers == 0xffff;
  };
  return k;
}

}  // namespace sightline::culling
