#include "sightline/apps/study/culler.h"

#include <algorithm>
#include <cassert>
#include <numeric>

#include "sightline/apps/study/threads.h"
#include "sightline/apps/study/walk.h"

namespace sightline::study {
namespace {

/// Everything that is compiled anew for each test.
struct Functions {
  void (*items)(const Frame&, std::uint32_t, std::uint32_t, unsigned, core::VisibleSet&);
  void (*with_stack)(const Frame&, FullNode*, std::vector<FullNode*>&, core::VisibleSet&);
  void (*stackless)(const Frame&, FullNode*, std::uint32_t, core::VisibleSet&);
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
      break;
  }
  return functions_of<Test::kRadarTwoAnswers, false>();
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

void append(const core::VisibleSet& part, core::VisibleSet& to) {
  to.ranges.insert(to.ranges.end(), part.ranges.begin(), part.ranges.end());
  to.single_slots.insert(to.single_slots.end(), part.single_slots.begin(), part.single_slots.end());
  to.counters.nodes_tested += part.counters.nodes_tested;
  to.counters.boxes_tested += part.counters.boxes_tested;
}

}  // namespace

struct Culler::State {
  std::vector<std::uint32_t> order;
  std::vector<Box> items;
  std::vector<Sphere> spheres;
  std::vector<Memory> memories;
  std::vector<std::uint8_t> item_planes;
  std::vector<FullNode> full;
  std::vector<CompactNode> compact;
  std::vector<FullNode*> stack;
  std::vector<core::VisibleSet> parts;  // by thread
  core::Aabb extent;
  Motion motion;
  Functions functions{};
};

Culler::Culler(const Variant& variant, std::span<const core::Aabb> boxes, const Tree& tree)
    : variant_(variant), state_(std::make_unique<State>()) {
  assert(valid(variant));
  State& s = *state_;
  for (const core::Aabb& b : boxes) s.extent.grow(b);
  s.functions = choose(variant.test, variant.simd);
  const bool has_tree = variant.tree != TreeKind::kNone;
  if (has_tree) {
    s.order = tree.order;
  } else {
    s.order.resize(boxes.size());
    std::iota(s.order.begin(), s.order.end(), 0u);
  }
  assert(s.order.size() == boxes.size());
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
  if (variant.has(kOctant)) {
    for (std::size_t i = 0; i < nodes; ++i) s.spheres.push_back(sphere_around(to_box(tree.nodes[i].box)));
    for (const Box& b : s.items) s.spheres.push_back(sphere_around(b));
  }
  if (variant.has(kMotion)) s.memories.resize(nodes + s.items.size());
  if (variant.has(kPlaneCoherency)) s.item_planes.resize(s.items.size());
  s.parts.resize(std::size_t(variant.thread_count));
}

Culler::~Culler() = default;

void Culler::cull(const core::View& view) {
  State& s = *state_;
  visible_.clear();
  const Camera camera(view, s.extent);
  if (s.items.empty()) return;
  if (variant_.has(kMotion)) s.motion.advance(camera);
  const std::size_t nodes = std::max(s.full.size(), s.compact.size());
  const Frame frame{variant_, camera, s.motion, s.items, s.spheres, s.memories, s.item_planes, std::uint32_t(nodes)};
  CompactNode* compact = s.compact.data();
  if (nodes == 0) return s.functions.items(frame, 0, std::uint32_t(s.items.size()), kAllPlanes, visible_);
  if (variant_.traversal == Traversal::kStack) return s.functions.with_stack(frame, s.full.data(), s.stack, visible_);
  if (variant_.traversal == Traversal::kStackless) return s.functions.stackless(frame, s.full.data(), 0, visible_);
  if (variant_.threads == Threads::kOne) return s.functions.compact(frame, compact, 0, visible_);
  for (core::VisibleSet& part : s.parts) part.clear();
  if (variant_.threads == Threads::kStatic)
    walk_static(frame, compact, s.functions.compact, variant_.thread_count, s.parts);
  else if (variant_.threads == Threads::kTasks)
    walk_tasks(frame, compact, s.functions.compact, s.functions.open_compact, variant_.thread_count, s.parts);
  else
    walk_ring(frame, compact, s.functions.compact, s.functions.open_compact, variant_.thread_count, s.parts);
  for (const core::VisibleSet& part : s.parts) append(part, visible_);
}

std::vector<std::uint32_t> Culler::ids() const {
  std::vector<std::uint32_t> ids;
  visible_.for_each_slot([&](core::Slot place) { ids.push_back(state_->order[place]); });
  std::sort(ids.begin(), ids.end());
  return ids;
}

std::size_t Culler::memory_bytes() const {
  const State& s = *state_;
  const std::size_t order = variant_.tree == TreeKind::kNone ? 0 : s.order.size() * sizeof(std::uint32_t);
  return s.full.size() * sizeof(FullNode) + s.compact.size() * sizeof(CompactNode) + order +
         s.items.size() * sizeof(Box) + s.spheres.size() * sizeof(Sphere) + s.memories.size() * sizeof(Memory) +
         s.item_planes.size();
}

}  // namespace sightline::study
