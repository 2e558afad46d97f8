#include "sightline/study/gpu/frontier.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <utility>

#include "sightline/study/gpu/feedback_pass.h"
#include "sightline/study/gpu/planes.h"

namespace sightline::study {
namespace {

constexpr std::uint32_t kNotLookedAt = 0x80000000u;

/// A node as frontier.geom reads it: two texels.
struct NodeTexels {
  std::uint32_t low[3], escape, high[3], first;
};
static_assert(sizeof(NodeTexels) == 32);

gl::ProgramDescription describe_walk(std::uint32_t ranges_per_node) {
  gl::ProgramDescription description =
      describe_feedback("GPU frontier", {"MAX_RANGES " + std::to_string(ranges_per_node)});
  description.stages = {{GL_VERTEX_SHADER, {"frontier.vert"}}, {GL_GEOMETRY_SHADER, {"frontier.geom"}}};
  description.feedback_varyings = {"range"};
  return description;
}

/// One more than there are nodes: the last says where the last range ends.
std::vector<NodeTexels> pack(const Tree& tree) {
  std::vector<NodeTexels> packed;
  packed.reserve(tree.nodes.size() + 1);
  for (const TreeNode& node : tree.nodes) {
    NodeTexels texels{{}, node.escape, {}, node.first};
    for (int i = 0; i < 3; ++i) {
      texels.low[i] = std::bit_cast<std::uint32_t>(node.box.min[i]);
      texels.high[i] = std::bit_cast<std::uint32_t>(node.box.max[i]);
    }
    packed.push_back(texels);
  }
  packed.push_back({{}, 0, {}, std::uint32_t(tree.order.size())});
  return packed;
}

/// Appends the nodes below `node` where a walk ends: leaves, nodes of at most `few` places, and those that
/// `ends(node)`.
template <class Ends>
void append_ends(const Tree& tree, std::uint32_t node, std::uint32_t few, std::vector<std::uint32_t>& cut,
                 const Ends& ends) {
  for (std::uint32_t i = node; i < tree.nodes[node].escape;) {
    const TreeNode& n = tree.nodes[i];
    const bool end = tree.leaf(i) || n.end - n.first <= few || ends(n);
    if (end) cut.push_back(i);
    i = end ? n.escape : i + 1;
  }
}

/// Whether two neighbours of a cut are the children of one node, which then comes before the first.
bool siblings(const Tree& tree, std::uint32_t a, std::uint32_t b) {
  return a > 0 && tree.nodes[a].escape == b && tree.nodes[a - 1].escape == tree.nodes[b].escape;
}

}  // namespace

std::vector<std::uint32_t> cut_of_walk(const Tree& tree, const culling::CullPlanes& planes, std::uint32_t few) {
  std::vector<std::uint32_t> cut;
  if (tree.nodes.empty()) return cut;
  append_ends(tree, 0, few, cut, [&](const TreeNode& node) {
    return planes.outside(node.box, planes.all()) || planes.remaining(node.box, planes.all()) == 0;
  });
  return cut;
}

std::vector<std::uint32_t> next_cut(const Tree& tree, std::span<const std::uint32_t> cut, std::span<const Found> found,
                                    std::uint32_t few) {
  assert(cut.size() == found.size());
  std::vector<std::uint32_t> next;
  next.reserve(cut.size());
  for (std::size_t k = 0; k < cut.size(); ++k) {
    const std::uint32_t node = cut[k];
    const bool alike = k + 1 < cut.size() && found[k] == found[k + 1] &&
                       (found[k] == Found::kNothing || found[k] == Found::kEverything);
    if (alike && siblings(tree, node, cut[k + 1])) {
      next.push_back(node - 1);
      ++k;
    } else if (found[k] == Found::kTooMuch) {
      append_ends(tree, node, few, next, [](const TreeNode&) { return false; });
    } else {
      next.push_back(node);
    }
  }
  return next;
}

struct Frontier::State {
  State(const gl::Functions& functions, const Tree& of, std::span<const core::Aabb> all, std::uint32_t ranges_of_node)
      : gl(&functions), tree(&of), ranges_per_node(ranges_of_node), extent(extent_of(all)) {}

  const gl::Functions* gl;
  const Tree* tree;
  std::uint32_t ranges_per_node;
  core::ItemBounds extent;
  GpuPlanes planes;
  FeedbackPass walk;
  TexelArray boxes, nodes, cut_nodes;
  std::vector<std::uint32_t> cut;
  bool cut_changed = true;
  std::vector<core::SlotRange> ranges;
  std::vector<Found> found;  // of the last cut
  std::size_t overflowed = 0;

  core::Expected<void> make(const gl::Context& context, std::span<const core::Aabb> all);
  void set_cut(std::vector<std::uint32_t> nodes);
  void read_ranges();
  Found take(const TreeNode& node, std::size_t& at);
};

core::Expected<void> Frontier::State::make(const gl::Context& context, std::span<const core::Aabb> all) {
  const gl::Capabilities& can = context.capabilities();
  const int room = std::min(can.max_geometry_output_vertices, can.max_geometry_output_components / 2);
  if (ranges_per_node < 1 || ranges_per_node > std::uint32_t(room))
    return core::fail("frontier: a geometry stage of this context writes 1 to " + std::to_string(room) +
                      " ranges, not " + std::to_string(ranges_per_node));
  std::vector<core::Aabb> sorted;
  for (const std::uint32_t i : tree->order) sorted.push_back(all[i]);
  const auto upload = [&](TexelArray& out, auto values, GLenum format, GLbitfield flags) -> core::Expected<void> {
    auto made = TexelArray::create(*gl, values, format, flags, "frontier");
    if (!made) return tl::unexpected(made.error());
    out = std::move(*made);
    return {};
  };
  const std::vector<NodeTexels> packed = pack(*tree);
  const std::vector<std::uint32_t> unused(tree->order.size());  // no cut has more nodes
  auto done = upload(boxes, std::span(sorted), GL_RGB32F, 0);
  if (done) done = upload(nodes, std::span(packed), GL_RGBA32UI, 0);
  if (done) done = upload(cut_nodes, std::span(unused), GL_R32UI, GL_DYNAMIC_STORAGE_BIT);
  if (!done) return done;

  auto made_planes = GpuPlanes::create(*gl);
  if (!made_planes) return tl::unexpected(made_planes.error());
  planes = std::move(*made_planes);
  // Ranges are disjoint and not empty, so there are no more of them than places.
  auto pass = FeedbackPass::create(*gl, describe_walk(ranges_per_node), sizeof(core::SlotRange), tree->order.size());
  if (!pass) return tl::unexpected(pass.error());
  walk = std::move(*pass);
  return {};
}

void Frontier::State::set_cut(std::vector<std::uint32_t> nodes_of_it) {
  cut_changed |= nodes_of_it != cut;
  cut = std::move(nodes_of_it);
}

void Frontier::State::read_ranges() {
  ranges.resize(walk.written());
  if (!ranges.empty()) walk.read(ranges.size(), ranges.data());
  found.clear();
  overflowed = 0;
  std::size_t at = 0;
  for (const std::uint32_t node : cut) found.push_back(take(tree->nodes[node], at));
  assert(at == ranges.size());
}

/// Takes the ranges below a node, which begin at `at`: feedback keeps the order of the cut.
Found Frontier::State::take(const TreeNode& node, std::size_t& at) {
  const std::size_t begin = at;
  while (at < ranges.size() && ranges[at].first < node.end) {
    core::SlotRange& range = ranges[at++];
    if ((range.count & kNotLookedAt) == 0) continue;
    range.count &= ~kNotLookedAt;
    ++overflowed;
    return Found::kTooMuch;
  }
  if (begin == at) return Found::kNothing;
  return ranges[begin].count == node.end - node.first ? Found::kEverything : Found::kSomething;
}

Frontier::Frontier(std::unique_ptr<State> state) : state_(std::move(state)) {}
Frontier::~Frontier() = default;

std::vector<gl::PipelineDescription> Frontier::all_programs() {
  std::vector<gl::PipelineDescription> all;
  for (std::uint32_t ranges = 1; ranges <= kRangesPerNode; ++ranges) all.push_back({describe_walk(ranges)});
  return all;
}

core::Expected<std::unique_ptr<Frontier>> Frontier::create(const gl::Context& context, const Tree& tree,
                                                           std::span<const core::Aabb> boxes,
                                                           std::uint32_t ranges_per_node) {
  assert(tree.order.size() == boxes.size());
  auto state = std::make_unique<State>(context.functions(), tree, boxes, ranges_per_node);
  if (!boxes.empty())
    if (auto done = state->make(context, boxes); !done) return tl::unexpected(done.error());
  return std::unique_ptr<Frontier>(new Frontier(std::move(state)));
}

void Frontier::take_over(const core::View& view) {
  const culling::CullPlanes planes(view, state_->extent);
  state_->set_cut(cut_of_walk(*state_->tree, planes, state_->ranges_per_node));
}

void Frontier::cull(const core::View& view) {
  State& s = *state_;
  s.ranges.clear();
  s.overflowed = 0;
  const culling::CullPlanes planes(view, s.extent);
  if (s.tree->nodes.empty() || planes.nothing_visible()) return;
  if (s.cut.empty()) take_over(view);
  if (std::exchange(s.cut_changed, false)) s.cut_nodes.buffer.write(0, s.cut.size() * sizeof(s.cut[0]), s.cut.data());
  s.planes.upload(planes, s.extent);
  s.gl->BindTextureUnit(kBoxUnit, s.boxes.texels.id());
  s.gl->BindTextureUnit(kNodeUnit, s.nodes.texels.id());
  s.gl->BindTextureUnit(kCutUnit, s.cut_nodes.texels.id());
  s.walk.run(std::uint32_t(s.cut.size()));
  s.read_ranges();
  s.set_cut(next_cut(*s.tree, s.cut, s.found, s.ranges_per_node));
}

std::uint64_t Frontier::count() const {
  std::uint64_t n = 0;
  for (const core::SlotRange& range : state_->ranges) n += range.count;
  return n;
}

std::vector<std::uint32_t> Frontier::ids() const {
  std::vector<std::uint32_t> ids;
  for (const core::SlotRange& range : state_->ranges)
    for (std::uint32_t i = 0; i < range.count; ++i) ids.push_back(state_->tree->order[range.first + i]);
  std::sort(ids.begin(), ids.end());
  return ids;
}

std::size_t Frontier::memory_bytes() const {
  return state_->boxes.buffer.size() + state_->nodes.buffer.size() + state_->cut_nodes.buffer.size() +
         state_->walk.output().size();
}

const std::vector<std::uint32_t>& Frontier::cut() const {
  return state_->cut;
}
const std::vector<core::SlotRange>& Frontier::ranges() const {
  return state_->ranges;
}
std::size_t Frontier::overflowed() const {
  return state_->overflowed;
}

}  // namespace sightline::study
