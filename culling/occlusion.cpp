#include "sightline/culling/occlusion.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "sightline/culling/internal/filter_slots.h"
#include "sightline/culling/internal/kernels.h"

namespace sightline::culling {
namespace {

constexpr float kCentre[1][2] = {{0.0f, 0.0f}};  // the one sample of a pixel
constexpr int kCoarsest = 3;                     // blocks along each axis of the last level

/// Which children of nodes are hidden. What lies below a hidden one is, and is not tested. Remembers the last node of
/// each level, so nodes should be asked for in rising order.
template <class HiddenOf>
class HiddenNodes {
 public:
  HiddenNodes(const Hierarchy& hierarchy, const HiddenOf& hidden_of) : hierarchy_(hierarchy), hidden_of_(hidden_of) {}

  /// Bit per child.
  unsigned children(int level, std::uint32_t node) {
    Known& known = known_[std::size_t(level)];
    if (known.node != node) known = {node, in_hidden(level, node) ? ~0u : test(level, node)};
    return known.hidden;
  }

 private:
  static constexpr std::size_t kMostLevels = 8;
  struct Known {
    std::uint32_t node = core::kNone;
    unsigned hidden = 0;
  };

  bool in_hidden(int level, std::uint32_t node) {
    return level + 1 < hierarchy_.level_count() && (children(level + 1, node / kLanes) >> node % kLanes & 1u) != 0;
  }
  unsigned test(int level, std::uint32_t node) const {
    const float* coordinates[6];
    for (int axis = 0; axis < 6; ++axis) coordinates[axis] = hierarchy_.level(level)[node].bounds[axis];
    return hidden_of_(coordinates);
  }

  const Hierarchy& hierarchy_;
  const HiddenOf& hidden_of_;
  std::array<Known, kMostLevels> known_;
};

/// The greater of two; NaN counts as infinity.
float farther(float a, float b) {
  return a >= b ? a : a < b ? b : std::numeric_limits<float>::infinity();
}

}  // namespace

void DepthPyramid::resize(int width, int height) {
  assert(width > 0 && height > 0);
  levels_.clear();
  std::size_t size = 0;
  for (int w = width, h = height;; w = (w + 1) / 2, h = (h + 1) / 2) {
    levels_.push_back({w, h, size});
    size += std::size_t(w) * std::size_t(h);
    if (w <= kCoarsest && h <= kCoarsest) break;
  }
  texels_.resize(size);
}

void DepthPyramid::clear(int width, int height) {
  resize(width, height);
  std::fill(texels_.begin(), texels_.end(), std::numeric_limits<float>::infinity());
}

void DepthPyramid::build(std::span<const float> distances, int width, int height) {
  assert(distances.size() == std::size_t(width) * std::size_t(height));
  resize(width, height);
  for (std::size_t i = 0; i < distances.size(); ++i) texels_[i] = farther(distances[i], distances[i]);
  for (std::size_t l = 1; l < levels_.size(); ++l) {
    const Level &fine = levels_[l - 1], &coarse = levels_[l];
    for (int y = 0; y < coarse.height; ++y) {
      const float* low = texels_.data() + fine.first + std::size_t(2 * y) * std::size_t(fine.width);
      const float* high = 2 * y + 1 < fine.height ? low + fine.width : low;
      float* out = texels_.data() + coarse.first + std::size_t(y) * std::size_t(coarse.width);
      for (int x = 0; x < fine.width / 2; ++x)
        out[x] = std::max(std::max(low[2 * x], low[2 * x + 1]), std::max(high[2 * x], high[2 * x + 1]));
      if (fine.width % 2 == 1) out[coarse.width - 1] = std::max(low[fine.width - 1], high[fine.width - 1]);
    }
  }
}

bool DepthPyramid::all_nearer(int x0, int y0, int x1, int y1, float distance) const {
  assert(0 <= x0 && x0 <= x1 && x1 < width() && 0 <= y0 && y0 <= y1 && y1 < height());
  // The finest level at which the pixels lie in 9 x 9 blocks at most.
  const unsigned span = unsigned(std::max(x1 - x0, y1 - y0));
  const std::size_t level = std::min(levels_.size() - 1, std::size_t(std::max(3, int(std::bit_width(span))) - 3));
  const Level& blocks = levels_[level];
  for (int y = y0 >> level; y <= y1 >> level; ++y) {
    const float* row = texels_.data() + blocks.first + std::size_t(y) * std::size_t(blocks.width);
    for (int x = x0 >> level; x <= x1 >> level; ++x)
      if (!(row[x] < distance)) return false;
  }
  return true;
}

OcclusionTest::OcclusionTest(const core::View& view, const core::dvec3& origin, int width, int height,
                             const DepthPyramid& pyramid, double error)
    : view_(make_screen_view(view, origin, width, height)), pyramid_(&pyramid), error_(float(error)) {
  view_.samples = kCentre;
  view_.sample_count = 1;
}

/// The rectangle of a box in pixels, centres at integers, and its least distance. It must contain a pixel centre of the
/// picture. Without std::floor, which is a function call where the instruction set has no floor.
bool OcclusionTest::hides(float left, float right, float bottom, float top, float nearest) const {
  left = std::max(left, 0.0f), right = std::min(right, view_.last_x);
  bottom = std::max(bottom, 0.0f), top = std::min(top, view_.last_y);
  const int x0 = int(left) + (float(int(left)) < left), y0 = int(bottom) + (float(int(bottom)) < bottom);
  return pyramid_->all_nearer(x0, y0, int(right), int(top), nearest - (kDistanceMargin * std::abs(nearest) + error_));
}

bool OcclusionTest::hidden(const core::Aabb& box) const {
  return of_one_box(box, [&](const auto& boxes) { return hidden_of(boxes); });
}

/// Bit i: box i of sixteen is hidden, or covers no pixel centre.
unsigned OcclusionTest::hidden_of(const float* const (&coordinates)[6]) const {
  BoxRectangles r;
  kernels().rectangles(view_, coordinates, r);
  unsigned found = ~r.covering;
  for (unsigned bits = r.covering & r.projects; bits != 0; bits &= bits - 1) {
    const int i = std::countr_zero(bits);
    if (hides(r.left[i], r.right[i], r.bottom[i], r.top[i], r.nearest[i])) found |= 1u << i;
  }
  return found;
}

void OcclusionTest::filter(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& open,
                           SlotBits exempt) const {
  filter_slots(bounds, in, open, exempt, [&](const auto& boxes) { return ~hidden_of(boxes); });
}

void OcclusionTest::filter_leaves(const Hierarchy& hierarchy, const core::VisibleSet& in, core::VisibleSet& open,
                                  SlotBits exempt) const {
  static_assert(64 % kLeafSize == 0);
  open.clear();
  open.generation = in.generation;
  open.items = in.items;
  const auto append = [&](core::Slot first, core::Slot end) {
    if (first < end) append_range(first, end, open.ranges);
  };
  const auto spared = [&](std::uint32_t leaf) {
    const std::size_t slot = std::size_t(leaf) * kLeafSize, word = slot / 64;
    return word < exempt.size() && (exempt[word] >> slot % 64 & ((std::uint64_t(1) << kLeafSize) - 1)) != 0;
  };
  const auto of_boxes = [&](const auto& boxes) { return hidden_of(boxes); };
  HiddenNodes nodes(hierarchy, of_boxes);
  for (const core::SlotRange& range : in.ranges) {
    const core::Slot end = range.first + range.count;
    const core::Slot begin = std::min(end, (range.first + kLeafSize - 1) / kLeafSize * kLeafSize);
    append(range.first, begin);
    for (core::Slot first = begin; first < end; first += kLeafSize) {
      const std::uint32_t leaf = first / kLeafSize;
      const unsigned hidden = nodes.children(0, leaf / kLanes);
      if ((hidden >> leaf % kLanes & 1u) == 0 || spared(leaf)) append(first, std::min(end, first + kLeafSize));
    }
  }
}

void OcclusionTest::split_by_distance(const core::ItemBounds& bounds, const core::VisibleSet& in, std::size_t count,
                                      core::VisibleSet& near, core::VisibleSet& far) const {
  struct Placed {
    float distance;
    core::Slot slot;
  };
  thread_local std::vector<Placed> placed;
  placed.clear();
  for_each_group(bounds, in, [&](const SlotGroup& group, unsigned, bool) {
    for (int i = 0; i < group.count; ++i) {
      if (bounds.vacant(group.slots[i])) continue;
      const auto middle = [&](int axis) { return group.coordinates[axis][i] + group.coordinates[axis + 3][i]; };
      placed.push_back({view_.t.x * middle(0) + view_.t.y * middle(1) + view_.t.z * middle(2), group.slots[i]});
    }
  });
  count = std::min(count, placed.size());
  std::nth_element(placed.begin(), placed.begin() + std::ptrdiff_t(count), placed.end(),
                   [](const Placed& a, const Placed& b) { return a.distance < b.distance; });
  near.clear();
  far.clear();
  near.generation = far.generation = in.generation;
  for (std::size_t i = 0; i < placed.size(); ++i) (i < count ? near : far).items.push_back(placed[i].slot);
  std::sort(near.items.begin(), near.items.end());
  std::sort(far.items.begin(), far.items.end());
}

}  // namespace sightline::culling
