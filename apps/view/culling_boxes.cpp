#include "sightline/apps/view/culling_boxes.h"

#include <algorithm>
#include <cmath>

#include "sightline/culling/frustum/linear_culler.h"

namespace sightline::apps {
namespace {

using core::dvec2;
using core::dvec3;
using core::dvec4;

constexpr double kStep = 2.0;       // pixels between looks at the depth along a line
constexpr double kInFront = 2e-3;   // of the distance: lines on surfaces are not behind them
constexpr double kLeastLine = 0.5;  // pixels

/// Puts lines into an image, in parts before and behind what it shows.
class Projection {
 public:
  Projection(const core::View& view, const image::DepthImage& depth, std::vector<CullingLine>& lines)
      : view_(view), clip_from_world_(view.clip_from_world()), depth_(depth), lines_(lines) {}

  void draw(const dvec3& a, const dvec3& b, std::uint8_t ink) const {
    End from = end(a), to = end(b);
    if (!clip(from, to)) return;
    const dvec2 at_a = place(from), at_b = place(to);
    const double length = glm::length(at_b - at_a);
    if (!(length >= kLeastLine)) return;
    const int steps = std::max(1, int(std::ceil(length / kStep)));
    dvec2 begin = at_a;
    bool behind = hidden(at_a, at_b, from, to, 0.5 / steps);
    for (int i = 1; i <= steps; ++i) {
      const bool next = i < steps ? hidden(at_a, at_b, from, to, (i + 0.5) / steps) : !behind;
      if (next == behind) continue;
      const dvec2 now = at_a + (at_b - at_a) * (double(i) / steps);
      lines_.push_back({begin, now, ink, behind});
      begin = now;
      behind = next;
    }
  }

 private:
  struct End {
    dvec4 clip;
    double distance;  // along the axis
  };
  End end(const dvec3& p) const {
    return {clip_from_world_ * dvec4(p, 1.0), -(view_.eye_from_world() * dvec4(p, 1.0)).z};
  }
  static End between(const End& a, const End& b, double t) {
    return {a.clip + t * (b.clip - a.clip), a.distance + t * (b.distance - a.distance)};
  }
  /// Clips to the image's four sides and the near plane: Y. Liang, B. Barsky, 1984.
  bool clip(End& a, End& b) const {
    double low = 0.0, high = 1.0;
    const auto inside = [&](double at_a, double at_b) {
      if (at_a < 0.0 && at_b < 0.0) return false;
      if (at_a < 0.0) low = std::max(low, at_a / (at_a - at_b));
      if (at_b < 0.0) high = std::min(high, at_a / (at_a - at_b));
      return low < high;
    };
    const double near = core::near_depth(view_.clip_depth()), sign = core::far_depth(view_.clip_depth()) - near;
    const auto before = [&](const dvec4& c) { return sign * (c.z - near * c.w); };
    if (!inside(before(a.clip), before(b.clip))) return false;
    for (int axis = 0; axis < 2; ++axis)
      if (!inside(a.clip.w - a.clip[axis], b.clip.w - b.clip[axis]) ||
          !inside(a.clip.w + a.clip[axis], b.clip.w + b.clip[axis]))
        return false;
    const End from = between(a, b, low), to = between(a, b, high);
    a = from, b = to;
    return a.clip.w > 0.0 && b.clip.w > 0.0;
  }
  dvec2 place(const End& end) const {
    const dvec2 at = dvec2(end.clip.x, end.clip.y) / end.clip.w;
    return {0.5 * (at.x + 1.0) * depth_.width, 0.5 * (1.0 - at.y) * depth_.height};
  }
  /// At a share of the line's way through the image.
  bool hidden(const dvec2& at_a, const dvec2& at_b, const End& a, const End& b, double share) const {
    const dvec2 at = at_a + share * (at_b - at_a);
    const int x = std::clamp(int(at.x), 0, depth_.width - 1), y = std::clamp(int(at.y), 0, depth_.height - 1);
    const double shown = depth_.metres[std::size_t(y) * std::size_t(depth_.width) + std::size_t(x)];
    const double of_b = share / b.clip.w, of_a = (1.0 - share) / a.clip.w;  // perspective-correct
    const double distance = (of_a * a.distance + of_b * b.distance) / (of_a + of_b);
    return distance - kInFront * std::abs(distance) > shown;
  }

  const core::View& view_;
  const core::dmat4 clip_from_world_;
  const image::DepthImage& depth_;
  std::vector<CullingLine>& lines_;
};

void draw_box(const Projection& projection, const dvec3& origin, const culling::CullBox& box) {
  const auto corner = [&](int i) {
    return origin + dvec3(i & 1 ? box.box.max.x : box.box.min.x, i & 2 ? box.box.max.y : box.box.min.y,
                          i & 4 ? box.box.max.z : box.box.min.z);
  };
  for (int i = 0; i < 8; ++i)
    for (const int axis : {1, 2, 4})
      if ((i & axis) == 0) projection.draw(corner(i), corner(i | axis), std::uint8_t(box.state));
}

}  // namespace

void CullingBoxes::clear() {
  lines_.clear();
  drawn_ = wanted_ = 0;
}

std::vector<CullingBoxes::SlotArea> CullingBoxes::in_image(const core::View& view, const image::DepthImage& depth,
                                                           const culling::CullStates& states,
                                                           const CullingSwitches& switches) const {
  core::VisibleSet seen, wanted;
  culling::LinearCuller(boxes_).cull(view, seen);
  seen.for_each_slot([&](core::Slot slot) {
    if (switches.states[std::size_t(states.boxes[slot].state)]) wanted.single_slots.push_back(slot);
  });
  std::vector<SlotArea> areas;
  culling::ContributionTest(view, boxes_.origin, depth.width, depth.height).areas(boxes_, wanted, areas);
  return areas;
}

void CullingBoxes::update(const core::View& view, const image::DepthImage& depth, const FrozenCamera& frozen,
                          const core::dvec3& origin, const core::AabbD& reach, const CullingSwitches& switches) {
  clear();
  if (!switches.boxes || !frozen.states() || depth.metres.empty()) return;
  const culling::CullStates& states = *frozen.states();
  if (version_ != frozen.version()) {
    version_ = frozen.version();
    boxes_ = {};
    boxes_.origin = origin;
    boxes_.resize(states.boxes.size());
    for (std::size_t i = 0; i < states.boxes.size(); ++i) boxes_.set(i, states.boxes[i].box);
  }
  core::View whole = view;  // boxes of what is cut away or on other layers show, too
  whole.sections.clear();
  whole.layers = ~0u;
  std::vector<SlotArea> areas = in_image(whole, depth, states, switches);
  wanted_ = areas.size();
  drawn_ = std::min(wanted_, kMost);
  const auto last = areas.begin() + std::ptrdiff_t(drawn_);
  if (drawn_ < wanted_)
    std::nth_element(areas.begin(), last, areas.end(), [](const SlotArea& a, const SlotArea& b) {
      return a.area != b.area ? a.area > b.area : a.slot < b.slot;
    });
  const Projection projection(whole, depth, lines_);
  for (auto it = areas.begin(); it != last; ++it) draw_box(projection, origin, states.boxes[it->slot]);
  for (const WorldLine& line : outline(frozen.view(), reach))
    projection.draw(line.from, line.to, std::uint8_t(CullingLine::kVolume + std::uint8_t(line.part)));
}

}  // namespace sightline::apps
