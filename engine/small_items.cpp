#include "sightline/engine/internal/small_items.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <unordered_map>

#include "sightline/core/surface_area.h"

namespace sightline::engine {
namespace {

double surface_of(const core::Snapshot& snapshot, core::Slot slot) {
  return int(snapshot.kind(slot)) >= core::kPrimitiveKindCount ? core::surface_area(snapshot.mesh(slot))
                                                               : core::surface_area(snapshot.primitive(slot));
}

float projected(double surface, const core::Snapshot& snapshot, core::Slot slot) {
  const double volume = std::abs(glm::determinant(snapshot.world_from_item(slot).linear));
  if (!(volume > 0.0)) return std::numeric_limits<float>::infinity();
  const double scale = std::cbrt(volume);
  return float(0.25 * surface * scale * scale);
}

/// Areas of items. Looks at each mesh once.
class Measure {
 public:
  explicit Measure(const core::Snapshot& snapshot) : snapshot_(snapshot) {}

  float operator()(core::Slot slot) {
    const core::Kind kind = snapshot_.kind(slot);
    if (snapshot_.vacant(slot)) return 0.0f;
    if (int(kind) < core::kPrimitiveKindCount) return mean_projected_area(snapshot_, slot);
    const std::uint32_t mesh = snapshot_.of_kind(kind).meshes[snapshot_.index_in_kind(slot)];
    const auto [place, fresh] = of_mesh_.try_emplace(mesh);
    if (fresh) place->second = surface_of(snapshot_, slot);
    return projected(place->second, snapshot_, slot);
  }

 private:
  const core::Snapshot& snapshot_;
  std::unordered_map<std::uint32_t, double> of_mesh_;
};

// --- squares -------------------------------------------------------------------------------------------------------

/// Where boxes lie in the picture and how large they are there.
class Projection {
 public:
  Projection(const core::View& view, const core::dvec3& origin, int width, int height)
      : width_(float(width)), height_(float(height)), perspective_(!view.orthographic()) {
    const core::dmat4 eye = view.eye_from_world(), &clip = view.clip_from_eye();
    const core::dvec3 moved(eye * core::dvec4(origin, 1.0));
    linear_ = core::mat3(eye);
    offset_ = core::vec3(moved);
    x_ = {float(0.5 * width * clip[0][0]), float(0.5 * width * clip[2][0]), float(0.5 * width * clip[3][0])};
    y_ = {float(0.5 * height * clip[1][1]), float(0.5 * height * clip[2][1]), float(0.5 * height * clip[3][1])};
    w_ = {float(clip[2][3]), float(clip[3][3])};
    scale_ = std::abs(x_.x * y_.x);
  }

  struct Place {
    core::vec3 eye;  // of the centre
    float x, y;      // of the centre, pixels from the lower left corner
    float w;
  };
  /// False when the centre is behind the eye or outside the picture.
  bool project(const core::vec3& centre, Place& place) const {
    place.eye = linear_ * centre + offset_;
    place.w = w_.x * place.eye.z + w_.y;
    if (!(place.w > 0.0f)) return false;
    place.x = (x_.x * place.eye.x + x_.y * place.eye.z + x_.z) / place.w + 0.5f * width_;
    place.y = (y_.x * place.eye.y + y_.y * place.eye.z + y_.z) / place.w + 0.5f * height_;
    return place.x >= 0.0f && place.x <= width_ && place.y >= 0.0f && place.y <= height_;
  }
  /// Pixels of an item with that mean area, at most those of its box from there: the areas of the box's faces times the
  /// cosines. What lies aside of the axis is drawn larger by one over the cosine, since the picture is flat.
  float area(const core::vec3& size, float mean, const Place& place) const {
    const core::vec3 towards = perspective_ ? place.eye / glm::length(place.eye) : core::vec3(0.0f, 0.0f, -1.0f);
    const core::vec3 cosines = glm::abs(towards * linear_);
    const float seen = size.y * size.z * cosines.x + size.z * size.x * cosines.y + size.x * size.y * cosines.z;
    return std::min(mean, seen) * scale_ / (place.w * place.w * -towards.z);
  }

 private:
  float width_, height_;
  bool perspective_;
  core::mat3 linear_;
  core::vec3 offset_, x_, y_;
  glm::vec2 w_;
  float scale_;
};

/// What is drawn so far.
struct NearestKnown {
  int width, height;
  std::span<const float> distances;  // row by row from the bottom up; empty: not known
  float error;                       // metres
};

/// Whether a square may cover a pixel centre where nothing nearer is known.
bool shows(const Projection::Place& place, float side, const NearestKnown& known) {
  constexpr float kMargin = 0.01f;  // pixels
  const float reach = 0.5f * side + kMargin;
  // Without std::floor and std::ceil, which are function calls where the instruction set has neither.
  const auto first = [reach](float at) {
    const float least = std::max(0.0f, at - 0.5f - reach);
    return int(least) + int(float(int(least)) < least);
  };
  const auto last = [reach](float at, int size) {
    const float most = at - 0.5f + reach;
    return most < 0.0f ? -1 : std::min(size - 1, int(most));
  };
  const int x1 = last(place.x, known.width), y1 = last(place.y, known.height);
  const float distance = -place.eye.z - known.error - 1e-4f * std::abs(place.eye.z);
  for (int y = first(place.y); y <= y1; ++y)
    for (int x = first(place.x); x <= x1; ++x)
      if (known.distances.empty() || known.distances[std::size_t(y * known.width + x)] >= distance) return true;
  return false;
}

}  // namespace

float mean_projected_area(const core::Snapshot& snapshot, core::Slot slot) {
  return projected(surface_of(snapshot, slot), snapshot, slot);
}

bool in_share(core::ItemId item, float share) {
  // The last step of MurmurHash3 (A. Appleby): each bit of the id changes each bit of the result with probability 1/2.
  std::uint32_t h = item + 0x9e3779b9u;
  h = (h ^ h >> 16) * 0x85ebca6bu;
  h = (h ^ h >> 13) * 0xc2b2ae35u;
  h ^= h >> 16;
  return float(h >> 8) * 0x1p-24f < share;
}

void SmallItems::grow(const core::Snapshot& snapshot) {
  Measure measure(snapshot);
  if (areas_.empty()) areas_.reserve(snapshot.size());
  while (areas_.size() < snapshot.size()) areas_.push_back(measure(core::Slot(areas_.size())));
}

void SmallItems::update(const core::Snapshot& snapshot, std::span<const core::Slot> touched) {
  if (areas_.empty()) return;
  Measure measure(snapshot);
  for (const core::Slot slot : touched)
    if (slot < areas_.size()) areas_[slot] = measure(slot);
}

core::Expected<void> SmallItems::draw(const gl::Context& context, const core::View& view,
                                      const core::Snapshot& snapshot, const core::VisibleSet& visible,
                                      culling::SlotBits large, const Rule& rule, std::span<const float> distances,
                                      const gpuscene::GpuScene& scene, const render::RenderTarget& target) {
  if (!points_) {
    auto points = render::PointSplats::create(context, target.format());
    if (!points) return tl::unexpected(points.error());
    points_ = std::move(*points);
  }
  grow(snapshot);
  splats_.clear();
  const core::ItemBounds& bounds = snapshot.bounds();
  const Projection projection(view, bounds.origin, target.width(), target.height());
  const bool one_sample = target.format().samples == 1;
  const NearestKnown known{target.width(), target.height(), distances,
                           float(render::RenderTarget::orthographic_error(view))};
  const bool stochastic = rule.way == ContributionWay::kStochastic;
  constexpr float kFewPixels = 4.0f;
  const float fixed_side = std::sqrt(rule.threshold);
  visible.for_each_slot([&](core::Slot slot) {
    if (culling::contains(large, slot) || bounds.vacant(slot)) return;
    const core::Aabb box = bounds.box(slot);
    Projection::Place place;
    if (!projection.project(0.5f * (box.min + box.max), place)) return;
    // No square is much larger, as the box is below the threshold. Most are hidden, or between pixel centres.
    if (one_sample && fixed_side <= kFewPixels && !shows(place, 1.01f * fixed_side, known)) return;
    const float area = projection.area(box.max - box.min, areas_[slot], place);
    const core::ItemId item = snapshot.item(slot);
    if (stochastic && !in_share(item, area / rule.threshold)) return;
    const float side = stochastic ? fixed_side : std::sqrt(area);
    if (one_sample && !shows(place, side, known)) return;
    splats_.push_back(
        {place.eye, std::min(side, points_->largest_side()), item, gpuscene::GpuScene::material_row(snapshot, slot)});
  });
  return points_->draw(view, splats_, scene, target);
}

}  // namespace sightline::engine
