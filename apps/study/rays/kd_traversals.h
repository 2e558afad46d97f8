// The eleven traversals of kd-trees. Each walks the leaves along the ray front to back until the query is answered.
//
// A ray's parameter at a split plane is always computed by the same expression, so that a search that starts anew at
// the parameter where it stopped makes the same decisions. Which child is near follows from the direction alone; this
// decides rightly for origins behind the plane and in it, too.
#pragma once

#include <algorithm>
#include <array>
#include <type_traits>

#include "sightline/apps/study/rays/kd_tree.h"
#include "sightline/apps/study/rays/query.h"

namespace sightline::study::rays {

/// Parameter where the ray leaves the box, and the axis of the face there.
struct BoxExit {
  float t;
  int axis;
};
inline BoxExit exit_of(const core::Aabb& box, const UnitRay& ray) {
  BoxExit exit{0.0f, 0};
  for (int a = 0; a < 3; ++a) {
    const float t = ray.at(a, ray.negative(a) ? box.min[a] : box.max[a]);
    if (a == 0 || t < exit.t) exit = {t, a};
  }
  return exit;
}

/// Descends to the leaf where the interval begins, and ends the interval where that leaf ends. `one(node)` is called
/// when all of the interval lies in one child, and `both(far child, interval there)` when it is cut.
template <class Q, class One, class Both>
std::uint32_t descend(const KdTree& tree, const UnitRay& ray, std::uint32_t node, Interval& t, Q& query, One&& one,
                      Both&& both) {
  for (query.visit(); !tree.nodes[node].is_leaf(); query.visit()) {
    const KdNode& n = tree.nodes[node];
    const float split = ray.at(n.axis(), n.split());
    const std::uint32_t near = n.left() + std::uint32_t(ray.negative(n.axis()));
    const std::uint32_t far = n.left() + std::uint32_t(!ray.negative(n.axis()));
    if (split >= t.max) {
      one(node = near);
    } else if (split <= t.min) {
      one(node = far);
    } else {
      both(far, Interval{split, t.max});
      node = near;
      t.max = split;
    }
  }
  return node;
}

inline constexpr auto kIgnoreOne = [](std::uint32_t) {};
inline constexpr auto kIgnoreBoth = [](std::uint32_t, const Interval&) {};

/// Standard: the far children wait on a stack of 12 bytes an entry, or in the dissertation's own form of 8: an entry's
/// interval begins where the last leaf ended.
template <bool eight_bytes>
struct KdStandard {
  struct ShortEntry {
    std::uint32_t node;
    float t_max;
    ShortEntry() = default;
    ShortEntry(const Entry& entry) : node(entry.node), t_max(entry.t.max) {}
  };

  template <class Q>
  static void walk(const KdTree& tree, const UnitRay& ray, Q& query) {
    std::array<std::conditional_t<eight_bytes, ShortEntry, Entry>, KdTree::kMaxDepth> stack;
    std::size_t size = 0;
    Entry at{0, {0.0f, ray.exit}};
    for (;;) {
      const std::uint32_t leaf =
          descend(tree, ray, at.node, at.t, query, kIgnoreOne, [&](std::uint32_t far, const Interval& t) {
            stack[size++] = Entry{far, t};
          });
      if (query.test(tree.triangles_of(tree.nodes[leaf]), at.t.max) || size == 0) return;
      const auto& next = stack[--size];
      if constexpr (eight_bytes)
        at = {next.node, {at.t.max, next.t_max}};
      else
        at = next;
    }
  }
};

/// V. Havran's: compares the coordinates where the interval begins and ends with the plane, and divides only when both
/// children are visited.
struct KdHavran {
  template <class Q>
  static void walk(const KdTree& tree, const UnitRay& ray, Q& query) {
    std::array<Entry, KdTree::kMaxDepth> stack;
    std::size_t size = 0;
    Entry at{0, {0.0f, ray.exit}};
    for (;;) {
      query.visit();
      const KdNode& n = tree.nodes[at.node];
      if (n.is_leaf()) {
        if (query.test(tree.triangles_of(n), at.t.max) || size == 0) return;
        at = stack[--size];
        continue;
      }
      const bool begins_low = ray.point(n.axis(), at.t.min) <= n.split();
      const bool ends_low = ray.point(n.axis(), at.t.max) <= n.split();
      at.node = n.left() + std::uint32_t(!begins_low);
      if (begins_low == ends_low) continue;
      const float split = ray.at(n.axis(), n.split());
      stack[size++] = {n.left() + std::uint32_t(begins_low), {split, at.t.max}};
      at.t.max = split;
    }
  }
};

/// Restart: no stack; after each leaf the search starts anew at the root, where the leaf ended.
struct KdRestart {
  template <class Q>
  static void walk(const KdTree& tree, const UnitRay& ray, Q& query) {
    for (Interval t{0.0f, ray.exit};; t = {t.max, ray.exit}) {
      const std::uint32_t leaf = descend(tree, ray, 0, t, query, kIgnoreOne, kIgnoreBoth);
      if (query.test(tree.triangles_of(tree.nodes[leaf]), t.max) || t.max >= ray.exit) return;
    }
  }
};

/// Backtrack: goes up to the first node that the ray has not left, by parents and boxes.
struct KdBacktrack {
  template <class Q>
  static void walk(const KdTreeWithParents& kd, const UnitRay& ray, Q& query) {
    std::uint32_t node = 0;
    Interval t{0.0f, ray.exit};
    for (;;) {
      node = descend(kd.tree, ray, node, t, query, kIgnoreOne, kIgnoreBoth);
      if (query.test(kd.tree.triangles_of(kd.tree.nodes[node]), t.max) || t.max >= ray.exit) return;
      t = {t.max, t.max};
      while (node != 0 && t.max <= t.min) {
        query.visit();
        node = kd.parents[node];
        t.max = std::min(ray.exit, exit_of(kd.boxes[node], ray).t);
      }
      if (node == 0) t.max = ray.exit;
    }
  }
};

/// Push-down: a restart begins at the deepest node that holds all of the ray that remains.
struct KdPushDown {
  template <class Q>
  static void walk(const KdTree& tree, const UnitRay& ray, Q& query) {
    std::uint32_t root = 0;
    for (Interval t{0.0f, ray.exit};; t = {t.max, ray.exit}) {
      bool whole = true;
      const std::uint32_t leaf = descend(
          tree, ray, root, t, query,
          [&](std::uint32_t child) {
            if (whole) root = child;
          },
          [&](std::uint32_t, const Interval&) { whole = false; });
      if (query.test(tree.triangles_of(tree.nodes[leaf]), t.max) || t.max >= ray.exit) return;
    }
  }
};

/// Short-stack: a circular stack of five entries that loses the oldest; once it is empty the search starts anew at the
/// root, or with push-down at the deepest node that holds all of the ray that remains.
template <bool push_down>
struct KdShortStack {
  static constexpr std::uint32_t kEntries = 5;

  template <class Q>
  static void walk(const KdTree& tree, const UnitRay& ray, Q& query) {
    std::array<Entry, kEntries> stack;
    std::uint32_t top = 0, size = 0, root = 0;
    bool whole = push_down;
    Entry at{0, {0.0f, ray.exit}};
    for (;;) {
      const std::uint32_t leaf = descend(
          tree, ray, at.node, at.t, query,
          [&](std::uint32_t child) {
            if (whole) root = child;
          },
          [&](std::uint32_t far, const Interval& t) {
            whole = false;
            stack[top] = {far, t};
            top = (top + 1) % kEntries;
            size = std::min(size + 1, kEntries);
          });
      if (query.test(tree.triangles_of(tree.nodes[leaf]), at.t.max) || at.t.max >= ray.exit) return;
      whole = push_down && size == 0;
      if (size == 0) {
        at = {root, {at.t.max, ray.exit}};
      } else {
        --size;
        top = (top + kEntries - 1) % kEntries;
        at = stack[top];
      }
    }
  }
};

/// A point that moves along the ray from leaf to leaf. On the axis it crosses it lies exactly in the face, and on the
/// others within it, so rounding never takes it back.
class Front {
 public:
  explicit Front(const UnitRay& ray) : ray_(ray), point_(ray.origin) {}

  template <class Nodes, class Q>
  std::uint32_t descend(const Nodes& nodes, std::uint32_t node, Q& query) const {
    for (query.visit(); !nodes[node].is_leaf(); query.visit()) {
      const KdNode& n = nodes[node];
      const float p = point_[n.axis()];
      const bool low = p < n.split() || (p == n.split() && ray_.negative(n.axis()));
      node = n.left() + std::uint32_t(!low);
    }
    return node;
  }

  void leave(const core::Aabb& box, const BoxExit& exit) {
    for (int a = 0; a < 3; ++a) point_[a] = std::clamp(ray_.point(a, exit.t), box.min[a], box.max[a]);
    point_[exit.axis] = ray_.negative(exit.axis) ? box.min[exit.axis] : box.max[exit.axis];
  }

 private:
  const UnitRay& ray_;
  core::vec3 point_;
};

/// Sequential: finds each leaf from the root, by a point.
struct KdSequential {
  template <class Q>
  static void walk(const KdTreeWithRopes& kd, const UnitRay& ray, Q& query) {
    for (Front front(ray);;) {
      const auto& leaf = kd.leaves[kd.nodes[front.descend(kd.nodes, 0, query)].first()];
      const BoxExit exit = exit_of(leaf.box, ray);
      if (query.test(kd.triangles_of(leaf), exit.t) || exit.t >= ray.exit) return;
      if (leaf.ropes[std::size_t(exit.axis) + (ray.negative(exit.axis) ? 0 : 3)] == core::kNone) return;
      front.leave(leaf.box, exit);
    }
  }
};

/// Ropes: finds the next leaf from the node behind the face where the ray leaves. S. Popov's intersects all six planes
/// of a leaf's box; the dissertation's own, ropes++, only the three where the ray can leave.
template <bool six_planes>
struct KdRopes {
  template <class Q>
  static void walk(const KdTreeWithRopes& kd, const UnitRay& ray, Q& query) {
    std::uint32_t node = 0;
    for (Front front(ray);;) {
      const auto& leaf = kd.leaves[kd.nodes[front.descend(kd.nodes, node, query)].first()];
      BoxExit exit = exit_of(leaf.box, ray);
      if constexpr (six_planes) exit.t = std::max(exit.t, entry_of(leaf.box, ray));
      if (query.test(kd.triangles_of(leaf), exit.t) || exit.t >= ray.exit) return;
      node = leaf.ropes[std::size_t(exit.axis) + (ray.negative(exit.axis) ? 0 : 3)];
      if (node == core::kNone) return;
      front.leave(leaf.box, exit);
    }
  }

 private:
  static float entry_of(const core::Aabb& box, const UnitRay& ray) {
    float t = 0.0f;
    for (int a = 0; a < 3; ++a) t = std::max(t, ray.at(a, ray.negative(a) ? box.max[a] : box.min[a]));
    return t;
  }
};

}  // namespace sightline::study::rays
