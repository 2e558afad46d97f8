// Internal: the kernels' common part. Form is that of an instruction set: a BlockForm.
// Static and in each file once: see kernels.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "sightline/core/internal/intrinsics.h"
#include "sightline/raytrace/internal/kernels.h"

namespace sightline::raytrace {
namespace {

/// t and child in one word, whose order is that of t: t is never below 0.
using Entry = std::uint64_t;
inline constexpr int kMostEntries = kMostLevels * (kLanes - 1) + 1;

union FloatBits {
  float value;
  std::uint32_t bits;
};
inline Entry entry_of(float t, std::uint32_t child) {
  FloatBits u;
  u.value = t;
  return Entry(u.bits) << 32 | child;
}
inline float t_of(Entry entry) {
  FloatBits u;
  u.bits = std::uint32_t(entry >> 32);
  return u.value;
}

/// As BoxRay, of several rays: lowest and highest scales.
struct Hull {
  float near_origin[3], far_origin[3], near_scale[2][3], far_scale[2][3];
  int near_plane[3], far_plane[3];
  float limit;
};

/// Corners of a triangle as the ray sees them: across the ray, and along it in units of t.
struct Sheared {
  float x[3], y[3], z[3];
};

/// Twice the signed area between the ray and an edge, exact in sign; 0 only for an edge that passes through the ray.
inline double edge_area(float ax, float ay, float bx, float by) {
  return double(ax) * double(by) - double(ay) * double(bx);
}
/// The side of an edge on which the ray lies. A ray through the edge counts as displaced by an infinitely small step
/// along x, and a smaller one along y. So of the triangles around an edge or a corner exactly one is met.
inline int edge_side(double area, float ax, float ay, float bx, float by) {
  if (area != 0.0) return area > 0.0 ? 1 : -1;
  if (ay != by) return by > ay ? 1 : -1;
  return ax == bx ? 0 : ax > bx ? 1 : -1;
}

/// A triangle whose area is less than this part of its extents' product is slim: across the ray its areas are right,
/// but so few of their digits are that t could lie anywhere between those of its corners.
inline constexpr float kSlim = 0.25f;

/// The triangle test for a lane whose areas float cannot tell from 0, or that is slim.
inline bool hit_exactly(const Sheared& s, float& t) {
  const double u = edge_area(s.x[2], s.y[2], s.x[1], s.y[1]);
  const double v = edge_area(s.x[0], s.y[0], s.x[2], s.y[2]);
  const double w = edge_area(s.x[1], s.y[1], s.x[0], s.y[0]);
  const int side = edge_side(u, s.x[2], s.y[2], s.x[1], s.y[1]);
  if (side == 0 || side != edge_side(v, s.x[0], s.y[0], s.x[2], s.y[2]) ||
      side != edge_side(w, s.x[1], s.y[1], s.x[0], s.y[0]))
    return false;
  const double sum = u + v + w;
  if (sum == 0.0) return false;
  t = float((u * double(s.z[0]) + v * double(s.z[1]) + w * double(s.z[2])) / sum);
  return true;
}

// How far t may be off: a triangle's corners are off by less than half of `across` in x and y, and its areas by their
// roundings. So twice its area is off by less than kAreaLost * across * (the sum of its extents), and t by `across`
// times the slope of the triangle's plane, which is at most kSlope * (the range of z) * (the sum of its extents) /
// (twice its area). Roundings along the ray are less than `across`, too.
inline constexpr float kAreaLost = 3.0f, kSlope = 4.0f;

/// Whether `hit` is nearer than `best`. What float cannot tell is found in double, both hits' t included: by
/// crossed(place), see HitFilter. `limit`: nothing beyond it counts.
template <class Crossed>
inline bool is_nearer(TriangleHit& hit, TriangleHit& best, float t_sure, float limit, const Crossed& crossed) {
  const float first = hit.t - hit.lost, last = hit.t + hit.lost;
  if (last < 0.0f || first > limit) return false;
  if (first >= t_sure && last <= limit && last < best.t - best.lost) return true;
  hit.t = crossed(hit.place);
  hit.lost = 0.0f;
  if (!(hit.t >= 0.0f)) return false;
  if (best.lost != 0.0f) {
    best.t = crossed(best.place);
    best.lost = 0.0f;
    if (!(best.t >= 0.0f)) return true;
  }
  return hit.t < best.t || (hit.t == best.t && hit.triangle < best.triangle);
}

/// The largest magnitude of three, and how far they are apart.
template <class Floats>
inline Floats extent(const Floats (&place)[3]) {
  return most(magnitude(place[0]), most(magnitude(place[1]), magnitude(place[2])));
}
template <class Floats>
inline Floats range(const Floats (&place)[3]) {
  return most(place[0], most(place[1], place[2])) - least(place[0], least(place[1], place[2]));
}

/// A ray against a node's boxes and a block's triangles. Floats: kLanes of them.
template <class Floats>
struct BlockForm {
  struct Ray {
    Floats near_origin[3], far_origin[3], near_scale[3], far_scale[3];
    std::ptrdiff_t near_plane[3], far_plane[3];  // in bytes from the node's start

    explicit Ray(const BoxRay& r) {
      for (int axis = 0; axis < 3; ++axis) {
        near_origin[axis] = Floats::spread(r.near_origin[axis]);
        far_origin[axis] = Floats::spread(r.far_origin[axis]);
        near_scale[axis] = Floats::spread(r.near_scale[axis]);
        far_scale[axis] = Floats::spread(r.far_scale[axis]);
        near_plane[axis] = std::ptrdiff_t(sizeof(WideNode::bounds[0])) * r.near_plane[axis];
        far_plane[axis] = std::ptrdiff_t(sizeof(WideNode::bounds[0])) * r.far_plane[axis];
      }
    }
    /// A row of WideNode::bounds, without a multiplication in the chain of each node.
    static Floats plane_at(const WideNode& node, std::ptrdiff_t offset) {
      return Floats::load(reinterpret_cast<const float*>(reinterpret_cast<const char*>(&node) + offset));
    }
    Floats enter(const WideNode& node, int axis) const {
      return (plane_at(node, near_plane[axis]) - near_origin[axis]) * near_scale[axis];
    }
    Floats leave(const WideNode& node, int axis) const {
      return (plane_at(node, far_plane[axis]) - far_origin[axis]) * far_scale[axis];
    }
  };

  static unsigned meet(const WideNode& node, const Ray& ray, float t_max, float* t) {
    core::prefetch_line<core::CacheLevel::kL1>(node.children);
    const Floats enter =
        most(most(ray.enter(node, 0), ray.enter(node, 1)), most(ray.enter(node, 2), Floats::spread(0.0f)));
    const Floats leave =
        least(least(ray.leave(node, 0), ray.leave(node, 1)), least(ray.leave(node, 2), Floats::spread(t_max)));
    enter.store(t);
    return at_most(enter, leave);
  }

  /// Children whose boxes any of the rays may meet, and where the first of them may enter.
  static unsigned meet_hull(const WideNode& node, const Hull& hull, float* t) {
    Floats enter = Floats::spread(0.0f), leave = Floats::spread(hull.limit);
    for (int axis = 0; axis < 3; ++axis) {
      const Floats near = Floats::load(node.bounds[hull.near_plane[axis]]) - Floats::spread(hull.near_origin[axis]);
      const Floats far = Floats::load(node.bounds[hull.far_plane[axis]]) - Floats::spread(hull.far_origin[axis]);
      enter = most(enter, least(near * Floats::spread(hull.near_scale[0][axis]),
                                near * Floats::spread(hull.near_scale[1][axis])));
      leave = least(leave,
                    most(far * Floats::spread(hull.far_scale[0][axis]), far * Floats::spread(hull.far_scale[1][axis])));
    }
    enter.store(t);
    return at_most(enter, leave);
  }

  struct Areas {
    Floats x[3], y[3], z[3], u, v, w;
  };
  static void shear(const TriangleRay& ray, const TriangleBlock& block, Areas& a, unsigned& hit, unsigned& unsure) {
    const Floats ox = Floats::spread(ray.origin[0]), oy = Floats::spread(ray.origin[1]);
    const Floats oz = Floats::spread(ray.origin[2]);
    const Floats sx = Floats::spread(ray.shear[0]), sy = Floats::spread(ray.shear[1]);
    const Floats sz = Floats::spread(ray.shear[2]), zero = Floats::spread(0.0f);
    for (int corner = 0; corner < 3; ++corner) {
      const float(*place)[kLanes] = block.corners[corner];
      const Floats z = Floats::load(place[ray.axes[2]]) - oz;
      a.x[corner] = (Floats::load(place[ray.axes[0]]) - ox) - sx * z;
      a.y[corner] = (Floats::load(place[ray.axes[1]]) - oy) - sy * z;
      a.z[corner] = sz * z;
    }
    a.u = a.x[2] * a.y[1] - a.y[2] * a.x[1];
    a.v = a.x[0] * a.y[2] - a.y[0] * a.x[2];
    a.w = a.x[1] * a.y[0] - a.y[1] * a.x[0];
    const Floats low = least(least(a.u, a.v), a.w), high = most(most(a.u, a.v), a.w);
    hit = less(zero, low) | less(high, zero);
    unsure = equal(low, zero) | equal(high, zero);
  }
  /// Returns the slim ones. `lost`: what t may be off by; infinite or NaN where float does not know.
  static unsigned distances(const Areas& a, float across, float* t, float* lost) {
    const Floats sum = (a.u + a.v) + a.w, twice = magnitude(sum), off = Floats::spread(across);
    (((a.u * a.z[0] + a.v * a.z[1]) + a.w * a.z[2]) / sum).store(t);
    const Floats wide = extent(a.x), high = extent(a.y), size = wide + high;
    const Floats area = most(twice - Floats::spread(kAreaLost * across) * size, Floats::spread(0.0f));
    (off + off * ((Floats::spread(kSlope) * range(a.z)) * size / area)).store(lost);
    return less(twice, Floats::spread(kSlim) * (wide * high));
  }
  static void corners(const Areas& a, unsigned lane, Sheared& out) {
    float lanes[3][kLanes];
    for (int corner = 0; corner < 3; ++corner) {
      a.x[corner].store(lanes[0]), a.y[corner].store(lanes[1]), a.z[corner].store(lanes[2]);
      out.x[corner] = lanes[0][lane], out.y[corner] = lanes[1][lane], out.z[corner] = lanes[2][lane];
    }
  }
};

template <class Form>
struct Tracing {
  /// Meets a block: updates `best`. Returns true when any hit suffices and there is one.
  template <bool kAny>
  static inline bool meet_block(const TriangleQuery& query, std::uint32_t index, float t_max, TriangleHit& best) {
    const TriangleBlock& block = query.blocks[index];
    typename Form::Areas areas;
    unsigned hit, unsure;
    Form::shear(query.ray, block, areas, hit, unsure);
    if ((hit | unsure) == 0) return false;
    float t[kLanes], lost[kLanes];
    unsure |= hit & Form::distances(areas, query.across, t, lost);
    while (unsure != 0) {
      const unsigned lane = core::lowest_bit(unsure);
      unsure &= unsure - 1;
      Sheared corners;
      Form::corners(areas, lane, corners);
      float exact;
      hit &= ~(1u << lane);
      if (hit_exactly(corners, exact)) {
        t[lane] = exact;
        hit |= 1u << lane;
      }
    }
    for (; hit != 0; hit &= hit - 1) {
      const unsigned lane = core::lowest_bit(hit);
      TriangleHit found{t[lane], lost[lane], block.triangles[lane], index * kLanes + lane};
      const float so_far = best.t + best.lost, limit = so_far < t_max ? so_far : t_max;
      if (!is_nearer(found, best, query.t_sure, limit,
                     [&](std::uint32_t place) { return query.filter->crossed(*query.filter, place); }))
        continue;
      best = found;
      if (kAny) return true;
    }
    return false;
  }

  /// Whether the ray meets any child of a node. `child` becomes the nearest of them; the others are pushed, the nearest
  /// last.
  static inline bool descend(const WideNode& node, const typename Form::Ray& ray, float t_max, Entry* stack, int& size,
                             std::uint32_t& child) {
    float t[kLanes];
    unsigned met = Form::meet(node, ray, t_max, t);
    if (met == 0) return false;
    const unsigned lane = core::lowest_bit(met);
    met &= met - 1;
    if (met == 0) {
      child = node.children[lane];  // without waiting for its t
      return true;
    }
    const auto entry_at = [&](unsigned at) { return entry_of(t[at], node.children[at]); };
    const Entry one = entry_at(lane), two = entry_at(core::lowest_bit(met));
    Entry* const first = stack + size;
    stack[size++] = one < two ? two : one;
    const Entry nearer = one < two ? one : two;
    met &= met - 1;
    if (met == 0) {
      child = std::uint32_t(nearer);
      return true;
    }
    stack[size++] = nearer;
    for (; met != 0; met &= met - 1) {
      const Entry entry = entry_at(core::lowest_bit(met));
      Entry* place = stack + size++;
      for (; place > first && place[-1] < entry; --place) *place = place[-1];
      *place = entry;
    }
    child = std::uint32_t(stack[--size]);
    return true;
  }

  /// Calls meet(leaf) for leaves that the ray meets, near ones first. meet() may shrink the limit; it returns true to
  /// end the walk.
  template <class Meet>
  static inline void traverse(const WideNode* nodes, std::uint32_t root, const BoxRay& boxes, const float& limit,
                              const Meet& meet) {
    const typename Form::Ray ray(boxes);
    Entry stack[kMostEntries];
    int size = 0;
    std::uint32_t child = root;
    for (;;) {
      if ((child & kLeafBit) == 0) {
        if (descend(nodes[child], ray, limit, stack, size, child)) continue;
      } else if (meet(child & ~kLeafBit)) {
        return;
      }
      Entry entry;
      do {
        if (size == 0) return;
        entry = stack[--size];
      } while (t_of(entry) > limit);
      child = std::uint32_t(entry);
    }
  }

  template <bool kAny>
  static TriangleHit trace(const TriangleQuery& query) {
    TriangleHit best{std::numeric_limits<float>::infinity(), 0.0f, kNoTriangle, 0};
    float limit = query.boxes->t_max;
    traverse(query.nodes, query.root, *query.boxes, limit, [&](std::uint32_t block) {
      if (meet_block<kAny>(query, block, query.boxes->t_max, best)) return true;
      if (best.t + best.lost < limit) limit = best.t + best.lost;
      return false;
    });
    return best;
  }

  static float walk(const WideNode* nodes, std::uint32_t root, const BoxRay& boxes, LeafVisitor& visitor) {
    float limit = boxes.t_max;
    traverse(nodes, root, boxes, limit, [&](std::uint32_t leaf) {
      limit = visitor.visit(visitor, leaf, limit);
      return limit < 0.0f;
    });
    return limit;
  }
};

template <class Form>
constexpr Kernels make_kernels() {
  return {Tracing<Form>::walk, Tracing<Form>::template trace<false>, Tracing<Form>::template trace<true>};
}

}  // namespace
}  // namespace sightline::raytrace
