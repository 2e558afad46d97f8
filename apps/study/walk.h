// Internal: node layouts, and one frame's walk over them. Templates over layout and test; the flags of a variant are
// looked at as the walk goes, as their branches are the same every time.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/apps/study/camera.h"
#include "sightline/apps/study/motion.h"
#include "sightline/apps/study/variant.h"
#include "sightline/core/visible_set.h"

namespace sightline::study {

/// Nodes of the traversal with a stack: pointers, and what coherency and masking keep.
struct FullNode {
  FullNode *parent, *left, *right;
  std::uint32_t plane, mask, first, end, depth, escape;
  Box box;
};

/// Nodes of the traversal by escape index alone.
struct CompactNode {
  std::uint32_t depth, escape, plane, mask, first, end;
  Box box;
};
static_assert(sizeof(FullNode) == 72 && sizeof(CompactNode) == 48);

/// All threads of one frame share this. Boxes and what belongs to them are numbered: nodes first, then items in the
/// order of the tree.
struct Frame {
  const Variant& variant;
  const Camera& camera;
  const Motion& motion;
  std::span<const Box> items;       // in the tree's order
  std::span<const Sphere> spheres;  // empty when nothing needs them
  std::span<Memory> memories;       // empty without motion
  std::span<std::uint8_t> item_planes;
  std::uint32_t node_count;
};

inline Sphere sphere_around(const Box& b) {
  Sphere s;
  float square = 0.0f;
  for (int i = 0; i < 3; ++i) {
    s.centre[i] = 0.5f * b.lo[i] + 0.5f * b.hi[i];
    const float half = std::max(b.hi[i] - s.centre[i], s.centre[i] - b.lo[i]);
    square += half * half;
  }
  s.radius = std::sqrt(square) * 1.000001f;
  return s;
}

/// The test itself. `mask`: planes still to be tested, cleared by what the box lies inside of.
template <Test kTest, bool kSimd>
Answer run_test(const Frame& f, const Box& box, std::size_t number, unsigned& mask, std::uint8_t* first,
                Rejection& rejection) {
  const Camera& c = f.camera;
  if constexpr (kTest == Test::kRadar || kTest == Test::kRadarTwoAnswers) {
    if (!c.radar_usable) return Answer::kIntersecting;
    return kTest == Test::kRadar ? radar_counting(c.radar, box) : radar_two_answers(c.radar, box);
  } else if constexpr (kTest == Test::kSplit) {
    return split_planes<kSimd>(c.split, box, mask, mask, rejection);
  } else {
    unsigned todo = mask;
    if (f.variant.has(kOctant) && c.has_corners) {
      const Sphere& s = f.spheres[number];
      if (s.radius <= c.octant_radius) todo &= c.octant(s.centre);
    }
    const auto one_plane = [&](int k, float& below) {
      const Plane& p = c.planes[std::size_t(k)];
      if constexpr (kTest == Test::kCorners) return corners_against_plane<kSimd>(p, box, below);
      return vertices_against_plane<kSimd>(p, box, below);
    };
    return in_turn(one_plane, todo, mask, first, rejection);
  }
}

/// The test with what may come before it.
template <Test kTest, bool kSimd>
Answer check(const Frame& f, const Box& box, std::size_t number, unsigned& mask, std::uint8_t* first) {
  if (!f.memories.empty() && f.motion.still_outside(f.memories[number])) return Answer::kOutside;
  if (f.variant.has(kPreTest) && f.camera.has_corners && apart(box, f.camera.bounds)) return Answer::kOutside;
  Rejection rejection;
  const Answer answer = run_test<kTest, kSimd>(f, box, number, mask, first, rejection);
  if (!f.memories.empty() && answer == Answer::kOutside) f.memories[number] = f.motion.remember(rejection, box);
  return answer;
}

/// Items first … end - 1, one by one.
template <Test kTest, bool kSimd>
void check_items(const Frame& f, std::uint32_t first, std::uint32_t end, unsigned mask, core::VisibleSet& out) {
  out.counters.boxes_tested += end - first;
  for (std::uint32_t i = first; i < end; ++i) {
    unsigned item_mask = mask;
    std::uint8_t* plane = f.variant.has(kPlaneCoherency) ? &f.item_planes[i] : nullptr;
    if (check<kTest, kSimd>(f, f.items[i], f.node_count + i, item_mask, plane) != Answer::kOutside)
      out.single_slots.push_back(i);
  }
}

inline void emit(std::uint32_t first, std::uint32_t end, core::VisibleSet& out) {
  if (!out.ranges.empty() && out.ranges.back().first + out.ranges.back().count == first)
    out.ranges.back().count += end - first;
  else
    out.ranges.push_back({first, end - first});
}

/// Tests a node and settles it when it can be: true when its children must be looked at. Masks of children lie in the
/// nodes, written by the parent just before.
template <Test kTest, bool kSimd, class Node>
bool open(const Frame& f, Node* nodes, std::uint32_t index, core::VisibleSet& out) {
  Node& node = nodes[index];
  const bool leaf = node.escape == index + 1;
  unsigned mask = f.variant.has(kMasking) ? node.mask : kAllPlanes;
  std::uint8_t plane = std::uint8_t(node.plane);
  ++out.counters.nodes_tested;
  const Answer answer =
      check<kTest, kSimd>(f, node.box, index, mask, f.variant.has(kPlaneCoherency) ? &plane : nullptr);
  if (f.variant.has(kPlaneCoherency)) node.plane = plane;
  if (answer == Answer::kOutside) return false;
  if (answer == Answer::kInside || (leaf && !f.variant.test_items)) {
    emit(node.first, node.end, out);
    return false;
  }
  if (leaf) {
    check_items<kTest, kSimd>(f, node.first, node.end, f.variant.has(kMasking) ? mask : kAllPlanes, out);
    return false;
  }
  if (f.variant.has(kMasking)) nodes[index + 1].mask = nodes[nodes[index + 1].escape].mask = mask;
  return true;
}

/// The subtree of `root`, by escape index.
template <Test kTest, bool kSimd, class Node>
void walk_stackless(const Frame& f, Node* nodes, std::uint32_t root, core::VisibleSet& out) {
  const std::uint32_t end = nodes[root].escape;
  for (std::uint32_t i = root; i < end;) i = open<kTest, kSimd>(f, nodes, i, out) ? i + 1 : nodes[i].escape;
}

/// A walk with a stack of pointers.
template <Test kTest, bool kSimd>
void walk_with_stack(const Frame& f, FullNode* nodes, std::vector<FullNode*>& stack, core::VisibleSet& out) {
  stack.assign(1, nodes);
  while (!stack.empty()) {
    FullNode* node = stack.back();
    stack.pop_back();
    if (!open<kTest, kSimd>(f, nodes, std::uint32_t(node - nodes), out)) continue;
    stack.push_back(node->right);
    stack.push_back(node->left);
  }
}

/// One subtree of compact nodes on the calling thread, and one node alone: what the schemes of threads.h hand out.
using WalkSubtree = void (*)(const Frame&, CompactNode*, std::uint32_t, core::VisibleSet&);
using OpenNode = bool (*)(const Frame&, CompactNode*, std::uint32_t, core::VisibleSet&);

}  // namespace sightline::study
