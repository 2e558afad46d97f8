#include "sightline/study/culler.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "sightline/core/item_bounds.h"
#include "sightline/study/threads.h"
#include "sightline/study/walk.h"

namespace sightline::study {
namespace {

/// Everything that is compiled anew for each test.
struct Functions {
  void (*items)(const Frame&, std::uint32_t, std::uint32_t, unsigned, Visible&);
  void (*with_stack)(const Frame&, FullNode*, std::vector<FullNode*>&, Visible&);
  void (*stackless)(const Frame&, FullNode*, std::uint32_t, Visible&);
  WalkSubtree compact;
  OpenNode open_compact;
};

template <Test kTest, bool kSimd>
Functions functions_of() {
  return {check_items<kTest, kSimd>, walk_with_stack<kTest, kSimd>, walk_stackless<kTest, kSimd, FullNode>,
          walk_stackless<kTest, kSimd, CompactNode>, open<kTest, kSimd, CompactNode>};
}

Functions choose(Test test, bool simd) {
  switch (test) {
    case Test::kCorners:
      return simd ? functions_of<Test::kCorners, true>() : functions_of<Test::kCorners, false>();
    case Test::kVertices:
      return simd ? functions_of<Test::kVertices, true>() : functions_of<Test::kVertices, false>();
    case Test::kSplit:
      return simd ? functions_of<Test::kSplit, true>() : functions_of<Test::kSplit, false>();
    case Test::kRadar:
      return functions_of<Test::kRadar, false>();
    case Test::kRadarTwoAnswers:
      return functions_of<Test::kRadarTwoAnswers, false>();
    case Test::kRadarByLimit:
      return functions_of<Test::kRadarByLimit, false>();
    case Test::kSphere:
      break;
  }
  return functions_of<Test::kSphere, false>();
}

Box to_box(const core::Aabb& b) {
  return {{b.min.x, b.min.y, b.min.z}, {b.max.x, b.max.y, b.max.z}};
}

void set_up(const Tree& tree, std::uint32_t i, FullNode* nodes) {
  const TreeNode& from = tree.nodes[i];
  FullNode& node = nodes[i];
  node = {node.parent, nullptr,  nullptr,    0,           kAllPlanes,
          from.first,  from.end, from.depth, from.escape, to_box(from.box)};
  if (tree.leaf(i)) return;
  node.left = nodes + i + 1;
  node.right = nodes + tree.nodes[i + 1].escape;
  node.left->parent = node.right->parent = &node;
}

/// Four boxes at a time, p-vertex only: what remains of the test when boxes lie side by side.
void cull_four_at_a_time(const core::ItemBounds& bounds, const Camera& camera, Visible& out) {
  const std::size_t count = bounds.size();
  out.counters.boxes_tested += count;
  out.items.resize(count + 4);
  std::uint32_t* next = out.items.data();
  const float* corner[kPlanes][3];
  for (std::size_t k = 0; k < camera.planes.size(); ++k)
    for (int axis = 0; axis < 3; ++axis)
      corner[k][axis] = bounds.coordinate(camera.planes[k].n[axis] >= 0.0f ? axis + 3 : axis);
  for (std::size_t i = 0; i < count; i += 4) {
    unsigned outside = 0;
    for (std::size_t k = 0; k < camera.planes.size() && outside != 0xfu; ++k) {
      const Plane& p = camera.planes[k];
#ifdef SIGHTLINE_STUDY_SSE
      const __m128 x = _mm_mul_ps(_mm_set1_ps(p.n[0]), _mm_loadu_ps(corner[k][0] + i));
      const __m128 y = _mm_mul_ps(_mm_set1_ps(p.n[1]), _mm_loadu_ps(corner[k][1] + i));
      const __m128 z = _mm_mul_ps(_mm_set1_ps(p.n[2]), _mm_loadu_ps(corner[k][2] + i));
      const __m128 above = _mm_add_ps(_mm_add_ps(_mm_add_ps(x, y), z), _mm_set1_ps(p.out));
      outside |= unsigned(_mm_movemask_ps(_mm_cmplt_ps(above, _mm_setzero_ps())));
#else
      for (std::size_t lane = 0; lane < 4; ++lane)
        outside |=
            unsigned(height(p, corner[k][0][i + lane], corner[k][1][i + lane], corner[k][2][i + lane]) + p.out < 0.0f)
            << lane;
#endif
    }
    for (unsigned lane = 0; lane < 4; ++lane) {  // branch-free: the place is kept only when the box is
      *next = std::uint32_t(i) + lane;
      next += ~outside >> lane & 1u;
    }
  }
  std::size_t kept = std::size_t(next - out.items.data());
  while (kept > 0 && out.items[kept - 1] >= count) --kept;  // padding
  out.items.resize(kept);
}

}  // namespace

void Visible::clear() {
  ranges.clear();
  items.clear();
  counters = {};
}

void Visible::append(const Visible& other) {
  ranges.insert(ranges.end(), other.ranges.begin(), other.ranges.end());
  items.insert(items.end(), other.items.begin(), other.items.end());
  counters.nodes_tested += other.counters.nodes_tested;
  counters.boxes_tested += other.counters.boxes_tested;
}

std::uint64_t Visible::count() const {
  std::uint64_t n = items.size();
  for (const core::SlotRange& r : ranges) n += r.count;
  return n;
}

struct Culler::State {
  std::vector<std::uint32_t> order;
  std::vector<Box> items;
  std::vector<Sphere> spheres;
  std::vector<Memory> memories;
  std::vector<std::uint8_t> item_planes;
  std::vector<FullNode> full;
  std::vector<CompactNode> compact;
  std::vector<FullNode*> stack;
  std::vector<Visible> parts;
  core::Aabb extent;
  Motion motion;
  Functions functions{};
  core::ItemBounds bounds;  // four boxes at a time
};

Culler::Culler(const Variant& variant, std::span<const core::Aabb> boxes, const Tree& tree)
    : variant_(variant), state_(std::make_unique<State>()) {
  assert(valid(variant));
  State& s = *state_;
  for (const core::Aabb& b : boxes) s.extent.grow(b);
  s.functions = choose(variant.test, variant.simd == Simd::kPerTest);
  const bool has_tree = variant.tree != TreeKind::kNone;
  if (has_tree) {
    s.order = tree.order;
  } else {
    s.order.resize(boxes.size());
    std::iota(s.order.begin(), s.order.end(), 0u);
  }
  assert(s.order.size() == boxes.size());
  if (variant.simd == Simd::kOverBoxes) {
    s.bounds.resize(boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) s.bounds.set(i, boxes[i]);
    return;
  }
  s.items.reserve(boxes.size());
  for (const std::uint32_t i : s.order) s.items.push_back(to_box(boxes[i]));
  const std::size_t nodes = has_tree ? tree.nodes.size() : 0;
  if (has_tree && variant.traversal != Traversal::kCompact) {
    s.full.resize(nodes);
    for (std::uint32_t i = 0; i < nodes; ++i) set_up(tree, i, s.full.data());
  } else if (has_tree) {
    for (const TreeNode& n : tree.nodes)
      s.compact.push_back({n.depth, n.escape, 0, kAllPlanes, n.first, n.end, to_box(n.box)});
  }
  if (variant.octant || variant.test == Test::kSphere) {
    for (std::size_t i = 0; i < nodes; ++i) s.spheres.push_back(sphere_around(to_box(tree.nodes[i].box)));
    for (const Box& b : s.items) s.spheres.push_back(sphere_around(b));
  }
  if (variant.motion) s.memories.resize(nodes + s.items.size());
  if (variant.plane_coherency) s.item_planes.resize(s.items.size());
  s.parts.resize(std::size_t(variant.thread_count));
}

Culler::~Culler() = default;

void Culler::cull(const core::View& view, Visible& visible) {
  State& s = *state_;
  visible.clear();
  const Camera camera(view, s.extent);
  if (variant_.simd == Simd::kOverBoxes) {
    cull_four_at_a_time(s.bounds, camera, visible);
    return;
  }
  if (s.items.empty()) return;
  if (variant_.motion) s.motion.advance(camera);
  const std::size_t nodes = std::max(s.full.size(), s.compact.size());
  const Frame frame{variant_, camera, s.motion, s.items, s.spheres, s.memories, s.item_planes, std::uint32_t(nodes)};
  if (nodes == 0) {
    s.functions.items(frame, 0, std::uint32_t(s.items.size()), kAllPlanes, visible);
    return;
  }
  if (variant_.traversal == Traversal::kStack) {
    s.functions.with_stack(frame, s.full.data(), s.stack, visible);
    return;
  }
  if (variant_.traversal == Traversal::kStackless) {
    s.functions.stackless(frame, s.full.data(), 0, visible);
    return;
  }
  CompactNode* compact = s.compact.data();
  if (variant_.threads == Threads::kOne) {
    s.functions.compact(frame, compact, 0, visible);
    return;
  }
  for (Visible& part : s.parts) part.clear();
  if (variant_.threads == Threads::kStatic)
    walk_static(frame, compact, s.functions.compact, variant_.thread_count, s.parts);
  else if (variant_.threads == Threads::kTasks)
    walk_tasks(frame, compact, s.functions.compact, s.functions.open_compact, variant_.thread_count, s.parts);
  else
    walk_ring(frame, compact, s.functions.compact, s.functions.open_compact, variant_.thread_count, s.parts);
  for (const Visible& part : s.parts) visible.append(part);
}

std::vector<std::uint32_t> Culler::ids(const Visible& visible) const {
  std::vector<std::uint32_t> ids;
  ids.reserve(visible.count());
  for (const core::SlotRange& r : visible.ranges)
    for (std::uint32_t i = 0; i < r.count; ++i) ids.push_back(state_->order[r.first + i]);
  for (const std::uint32_t i : visible.items) ids.push_back(state_->order[i]);
  std::sort(ids.begin(), ids.end());
  return ids;
}

std::size_t Culler::node_bytes() const {
  const State& s = *state_;
  return s.full.size() * sizeof(FullNode) + s.compact.size() * sizeof(CompactNode);
}

std::size_t Culler::memory_bytes() const {
  const State& s = *state_;
  const std::size_t order = variant_.tree == TreeKind::kNone ? 0 : s.order.size() * sizeof(std::uint32_t);
  return node_bytes() + order + s.items.size() * sizeof(Box) + s.spheres.size() * sizeof(Sphere) +
         s.memories.size() * sizeof(Memory) + s.item_planes.size() + (s.items.empty() ? s.bounds.memory_bytes() : 0);
}

}  // namespace sightline::study
