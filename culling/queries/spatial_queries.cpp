// Rounding. u = 2^-53. A query's coordinate q is moved to the bounds' origin o as an unevaluated sum: s = fl(q - o) and
// the error e = (q - o) - s, itself a double (T. Dekker, 1971; D. Knuth, TAOCP 2, 4.2.2).
//
// Ranges. For a float c, o + c <= q is c <= q - o, hence c <= T with T the largest float that is not above s + e. So
// nodes and items are compared in float, exactly.
//
// Distances. a = fl(fl(c - s) - e) differs from c - (q - o) by a relative error below 2.1 u: where c and s are within a
// factor of two, c - s is exact (P. Sterbenz) and only the second subtraction rounds; elsewhere |c - s| >= |s| / 2 and
// |e| <= u |s|. Squares and sums of three such terms have a relative error below 2 * 2.1 u + 3.1 u < 8 u, so every box
// within the radius passes when its squared distance is compared with (1 + 10 u) radius^2 and a few denormals.
//
// Rays: slabs (A. Williams et al., "An efficient and robust ray-box intersection algorithm", 2005) with rounding on the
// side of a hit (T. Ize, "Robust BVH ray traversal", 2013). t = fl(a * fl(1 / d)) has a relative error below 4.2 u;
// before they are compared the ends of the interval are moved apart by 8 u of themselves, and by what underflow can do.
// On an axis with d = 0, 1 / d is infinite and so is t, of the sign of a, or NaN when the ray runs in the slab's face:
// comparisons let NaN pass, and the face belongs to the box. An end that is infinite on the wrong side becomes NaN when
// it is moved, and misses.
//
// All these functions are monotone in the box as computed: what passes lies in nodes that pass, at keys not above its
// own. Hence one answer with any hierarchy or none.
#include "sightline/culling/queries/spatial_queries.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "sightline/core/internal/scratch.h"

namespace sightline::culling {
namespace {

using core::AabbD;
using core::dvec3;
using core::ItemBounds;
using core::Slot;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLargest = std::numeric_limits<double>::max();
constexpr double kUnit = 0x1p-53, kUnderflow = 0x1p-1060;
constexpr double kLargestQuery = 1e150;

using Lanes = std::array<double, kLanes>;

/// Sixteen boxes: children of a node, or items from a slot on. Coordinates: min x, min y, min z, max x, max y, max z.
struct BoxGroup {
  const float* coordinates[6];

  explicit BoxGroup(const HierarchyNode& node) {
    for (int axis = 0; axis < 6; ++axis) coordinates[axis] = node.bounds[axis];
  }
  BoxGroup(const ItemBounds& bounds, std::size_t first) {
    for (int axis = 0; axis < 6; ++axis) coordinates[axis] = bounds.coordinate(axis) + first;
  }
};

/// Bit per lane for which `test(lane)` holds.
template <class Test>
unsigned lanes_where(const Test& test) {
  unsigned mask = 0;
  for (int lane = 0; lane < kLanes; ++lane) mask |= unsigned(test(lane)) << lane;
  return mask;
}

unsigned first_lanes(std::size_t count) {
  return count >= std::size_t(kLanes) ? (1u << kLanes) - 1 : (1u << count) - 1;
}

/// Head + tail: minuend - subtrahend without rounding.
struct Difference {
  double head, tail;
  Difference(double minuend, double subtrahend) : head(minuend - subtrahend) {
    const double b = minuend - head, a = head + b;
    tail = (minuend - a) + (b - subtrahend);
  }
};

/// Largest float <= a - b; -infinity below all floats. `a` may be infinite.
float largest_not_above(double a, double b) {
  constexpr float kMax = std::numeric_limits<float>::max();
  const Difference x(a, b);
  if (x.head > double(kMax)) return kMax;
  if (!(x.head >= -double(kMax))) return -std::numeric_limits<float>::infinity();
  const auto f = static_cast<float>(x.head);
  const bool above = double(f) > x.head || (double(f) == x.head && x.tail < 0.0);
  return above ? std::nextafterf(f, -std::numeric_limits<float>::infinity()) : f;
}
float smallest_not_below(double a, double b) {
  return -largest_not_above(-a, -b);
}

bool usable(const dvec3& v) {
  return std::abs(v.x) < kLargestQuery && std::abs(v.y) < kLargestQuery && std::abs(v.z) < kLargestQuery;
}

// --- tests of sixteen boxes ------------------------------------------------------------------------------------------

class RangeTest {
 public:
  RangeTest(const AabbD& range, const dvec3& origin) {
    for (int i = 0; i < 3; ++i) {
      low_[i] = smallest_not_below(range.min[i], origin[i]);
      high_[i] = largest_not_above(range.max[i], origin[i]);
    }
  }
  unsigned meeting(const BoxGroup& b) const {
    const auto& c = b.coordinates;
    return lanes_where([&](int i) {
      return (c[0][i] <= high_[0]) & (c[1][i] <= high_[1]) & (c[2][i] <= high_[2]) & (c[3][i] >= low_[0]) &
             (c[4][i] >= low_[1]) & (c[5][i] >= low_[2]);
    });
  }
  unsigned inside(const BoxGroup& b) const {
    const auto& c = b.coordinates;
    return lanes_where([&](int i) {
      return (c[0][i] >= low_[0]) & (c[1][i] >= low_[1]) & (c[2][i] >= low_[2]) & (c[3][i] <= high_[0]) &
             (c[4][i] <= high_[1]) & (c[5][i] <= high_[2]);
    });
  }

 private:
  float low_[3], high_[3];
};

/// Squared distances from a point.
class DistanceTest {
 public:
  DistanceTest(const dvec3& point, const dvec3& origin)
      : p_{{point.x, origin.x}, {point.y, origin.y}, {point.z, origin.z}} {}

  void operator()(const BoxGroup& b, Lanes& squared) const {
    squared.fill(0.0);
    for (int axis = 0; axis < 3; ++axis) {
      const float *low = b.coordinates[axis], *high = b.coordinates[axis + 3];
      const double head = p_[axis].head, tail = p_[axis].tail;
      for (std::size_t i = 0; i < std::size_t(kLanes); ++i) {
        const double below = (double(low[i]) - head) - tail, above = (head - double(high[i])) + tail;
        const double outside = std::max(std::max(below, above), 0.0);
        squared[i] += outside * outside;
      }
    }
  }

 private:
  Difference p_[3];
};

/// Where a ray enters: +infinity where it misses.
class EntryTest {
 public:
  EntryTest(const core::Ray& ray, const dvec3& origin)
      : o_{{ray.origin.x, origin.x}, {ray.origin.y, origin.y}, {ray.origin.z, origin.z}},
        t_min_(ray.t_min),
        t_max_(ray.t_max) {
    for (int axis = 0; axis < 3; ++axis) {
      const double d = ray.direction[axis];
      inverse_[axis] = std::abs(d) < 1.0 / kLargestQuery ? kInfinity : 1.0 / d;
    }
  }

  void operator()(const BoxGroup& b, Lanes& entry) const {
    Lanes exit;
    entry.fill(t_min_);
    exit.fill(t_max_);
    for (int axis = 0; axis < 3; ++axis) {
      const bool backwards = inverse_[axis] < 0.0;
      const float *first = b.coordinates[backwards ? axis + 3 : axis],
                  *last = b.coordinates[backwards ? axis : axis + 3];
      const double head = o_[axis].head, tail = o_[axis].tail, inverse = inverse_[axis];
      for (std::size_t i = 0; i < std::size_t(kLanes); ++i) {
        const double in = ((double(first[i]) - head) - tail) * inverse;
        const double out = ((double(last[i]) - head) - tail) * inverse;
        entry[i] = in > entry[i] ? in : entry[i];
        exit[i] = out < exit[i] ? out : exit[i];
      }
    }
    for (std::size_t i = 0; i < std::size_t(kLanes); ++i) {
      const double in = entry[i] - (8.0 * kUnit * std::abs(entry[i]) + kUnderflow);
      const double out = exit[i] + (8.0 * kUnit * std::abs(exit[i]) + kUnderflow);
      entry[i] = in <= out ? entry[i] : kInfinity;
    }
  }

 private:
  Difference o_[3];
  double inverse_[3], t_min_, t_max_;
};

// --- traversal -------------------------------------------------------------------------------------------------------

/// A node or, at level -1, a leaf.
struct Place {
  int level;
  std::uint32_t index;
};

struct Search {
  const ItemBounds& bounds;
  const Hierarchy& hierarchy;
  std::uint32_t layers;

  bool hopeless() const { return !bounds.uses_layers() && (layers & core::kLayerModel) == 0; }
  Place root() const { return {hierarchy.level_count() - 1, 0}; }

  /// Lanes of a node that exist and have an item on one of the layers below.
  unsigned open_lanes(Place node) const {
    unsigned open = first_lanes(hierarchy.lane_count(node.level) - node.index * std::uint32_t(kLanes));
    if (hierarchy.uses_layers()) {
      const LayerNode& below = hierarchy.layers(node.level)[node.index];
      open &= lanes_where([&](int lane) { return (below.any[lane] & layers) != 0; });
    }
    return open;
  }

  /// The lanes of `found` (lane i: slot first + i) before slot `end` that have a box and one of the layers.
  unsigned items_of(std::size_t first, std::size_t end, unsigned found) const {
    found &= first_lanes(end - first);
    for (unsigned m = found; m != 0; m &= m - 1) {
      const std::size_t slot = first + std::size_t(std::countr_zero(m));
      if ((bounds.layers(slot) & layers) == 0 || bounds.box(slot).empty()) found &= ~(m & -m);
    }
    return found;
  }

  /// visit(first, end) for groups of up to sixteen slots.
  template <class Visit>
  static void groups(std::size_t first, std::size_t end, const Visit& visit) {
    for (; first < end; first += kLanes) visit(first, std::min(end, first + kLanes));
  }
  template <class Visit>
  void leaf_groups(std::uint32_t leaf, const Visit& visit) const {
    const std::size_t first = std::size_t(leaf) * kLeafSize;
    groups(first, std::min<std::size_t>(hierarchy.slot_count(), first + kLeafSize), visit);
  }
  template <class Visit>
  void tail_groups(const Visit& visit) const {
    groups(hierarchy.slot_count(), bounds.size(), visit);
  }

  /// All groups of slots below lanes that `meeting` allows, and the tail, in rising order.
  template <class Meeting, class Visit>
  void depth_first(const Meeting& meeting, const Visit& visit) const {
    std::array<Place, std::size_t(kLanes) * 8> stack;  // eight levels hold 2^37 slots
    std::size_t height = 0;
    if (!hierarchy.empty()) stack[height++] = root();
    while (height != 0) {
      const Place place = stack[--height];
      if (place.level < 0) {
        leaf_groups(place.index, visit);
        continue;
      }
      unsigned open = open_lanes(place) & meeting(BoxGroup(hierarchy.level(place.level)[place.index]));
      while (open != 0) {  // the last lane first, so that the first is on top
        const unsigned lane = unsigned(std::bit_width(open)) - 1;
        stack[height++] = {place.level - 1, place.index * std::uint32_t(kLanes) + lane};
        open &= ~(1u << lane);
      }
    }
    tail_groups(visit);
  }

  template <class NodeTest, class ItemTest>
  void collect(const NodeTest& meeting, const ItemTest& test, std::vector<Slot>& slots) const {
    if (hopeless()) return;
    depth_first(meeting, [&](std::size_t first, std::size_t end) {
      for (unsigned found = items_of(first, end, test(BoxGroup(bounds, first))); found != 0; found &= found - 1)
        slots.push_back(Slot(first) + Slot(std::countr_zero(found)));
    });
  }

  template <class Keys>
  void best_first(const Keys& keys, std::size_t count, std::vector<SlotDistance>& best) const;
};

/// The order of answers: by distance, then slot.
bool before(const SlotDistance& a, const SlotDistance& b) {
  return a.distance < b.distance || (a.distance == b.distance && a.slot < b.slot);
}

struct QueuedPlace {
  double key;
  Place place;
  friend bool operator<(const QueuedPlace& a, const QueuedPlace& b) { return a.key > b.key; }  // smallest on top
};

struct QueueBuffers {
  std::vector<QueuedPlace> queue;
  std::size_t memory_bytes() const { return core::bytes_of(queue); }
};

/// The `count` items of least finite key, in order. Nodes wait in a heap; the best items so far form another, the worst
/// of them on top (G. Hjaltason, H. Samet, "Distance browsing in spatial databases", 1999).
template <class Keys>
void Search::best_first(const Keys& keys, std::size_t count, std::vector<SlotDistance>& best) const {
  if (count == 0 || hopeless()) return;
  const core::Scratch<QueueBuffers> scratch;
  std::vector<QueuedPlace>& queue = scratch->queue;
  queue.clear();
  Lanes key;
  const auto limit = [&] { return best.size() < count ? kLargest : best.front().distance; };
  const auto offer = [&](std::size_t first, std::size_t end) {
    keys(BoxGroup(bounds, first), key);
    const double most = limit();
    unsigned near = lanes_where([&](int lane) { return key[std::size_t(lane)] <= most; });
    for (near = items_of(first, end, near); near != 0; near &= near - 1) {
      const int lane = std::countr_zero(near);
      const SlotDistance item{Slot(first) + Slot(lane), key[std::size_t(lane)]};
      if (best.size() == count) {
        if (!before(item, best.front())) continue;
        std::pop_heap(best.begin(), best.end(), before);
        best.pop_back();
      }
      best.push_back(item);
      std::push_heap(best.begin(), best.end(), before);
    }
  };
  tail_groups(offer);
  if (!hierarchy.empty()) queue.push_back({-kInfinity, root()});
  while (!queue.empty() && queue.front().key <= limit()) {
    const Place place = queue.front().place;
    std::pop_heap(queue.begin(), queue.end());
    queue.pop_back();
    if (place.level < 0) {
      leaf_groups(place.index, offer);
      continue;
    }
    keys(BoxGroup(hierarchy.level(place.level)[place.index]), key);
    const double most = limit();
    for (unsigned open = open_lanes(place); open != 0; open &= open - 1) {
      const auto lane = std::uint32_t(std::countr_zero(open));
      if (!(key[lane] <= most)) continue;
      queue.push_back({key[lane], {place.level - 1, place.index * std::uint32_t(kLanes) + lane}});
      std::push_heap(queue.begin(), queue.end());
    }
  }
  std::sort_heap(best.begin(), best.end(), before);
}

bool usable(const core::Ray& ray) {
  return usable(ray.origin) && usable(ray.direction) && ray.t_min <= ray.t_max && ray.t_min < kInfinity &&
         ray.t_max > -kInfinity;
}

}  // namespace

void SpatialQueries::intersecting(const AabbD& range, std::uint32_t layers, std::vector<Slot>& slots) const {
  slots.clear();
  if (range.empty()) return;
  const RangeTest test(range, bounds_->origin);
  const auto meeting = [&](const BoxGroup& b) { return test.meeting(b); };
  Search{*bounds_, *hierarchy_, layers}.collect(meeting, meeting, slots);
}

void SpatialQueries::inside(const AabbD& range, std::uint32_t layers, std::vector<Slot>& slots) const {
  slots.clear();
  if (range.empty()) return;
  const RangeTest test(range, bounds_->origin);
  Search{*bounds_, *hierarchy_, layers}.collect([&](const BoxGroup& b) { return test.meeting(b); },
                                                [&](const BoxGroup& b) { return test.inside(b); }, slots);
}

void SpatialQueries::around(const dvec3& point, double radius, std::uint32_t layers, std::vector<Slot>& slots) const {
  slots.clear();
  if (!usable(point) || !(radius >= 0.0)) return;
  const DistanceTest test(point, bounds_->origin);
  const double limit = radius * radius * (1.0 + 10.0 * kUnit) + 8.0 * std::numeric_limits<double>::denorm_min();
  const auto near = [&](const BoxGroup& b) {
    Lanes squared;
    test(b, squared);
    return lanes_where([&](int lane) { return squared[std::size_t(lane)] <= limit; });
  };
  Search{*bounds_, *hierarchy_, layers}.collect(near, near, slots);
}

void SpatialQueries::along(const core::Ray& ray, std::uint32_t layers, std::vector<SlotDistance>& hits) const {
  hits.clear();
  const Search search{*bounds_, *hierarchy_, layers};
  if (!usable(ray) || search.hopeless()) return;
  const EntryTest test(ray, bounds_->origin);
  Lanes entry;
  const auto met = [&](const BoxGroup& b) {
    test(b, entry);
    return lanes_where([&](int lane) { return entry[std::size_t(lane)] < kInfinity; });
  };
  search.depth_first(met, [&](std::size_t first, std::size_t end) {
    for (unsigned found = search.items_of(first, end, met(BoxGroup(*bounds_, first))); found != 0; found &= found - 1) {
      const int lane = std::countr_zero(found);
      hits.push_back({Slot(first) + Slot(lane), entry[std::size_t(lane)]});
    }
  });
}

void SpatialQueries::first_along(const core::Ray& ray, std::size_t count, std::uint32_t layers,
                                 std::vector<SlotDistance>& hits) const {
  hits.clear();
  if (!usable(ray)) return;
  Search{*bounds_, *hierarchy_, layers}.best_first(EntryTest(ray, bounds_->origin), count, hits);
}

void SpatialQueries::nearest(const dvec3& point, std::size_t count, std::uint32_t layers,
                             std::vector<SlotDistance>& hits) const {
  hits.clear();
  if (!usable(point)) return;
  const DistanceTest squared(point, bounds_->origin);
  const auto distances = [&](const BoxGroup& b, Lanes& key) {
    squared(b, key);
    for (double& k : key) k = std::sqrt(k);
  };
  Search{*bounds_, *hierarchy_, layers}.best_first(distances, count, hits);
}

}  // namespace sightline::culling
