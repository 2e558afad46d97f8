#include "sightline/engine/tour.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "sightline/core/item_bounds.h"

namespace sightline::engine {
namespace {

using core::dvec3;

constexpr double kPi = 3.14159265358979323846;
constexpr double kFovy = kPi / 3.0;
constexpr double kFarthest = 1e37;  // limit of a scene's coordinates

double magnitude(const dvec3& v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

dvec3 unit(const dvec3& v) {
  return glm::normalize(v / magnitude(v));
}

/// The model as the tour sees it: never empty, never flat.
struct Stage {
  dvec3 centre{0.0};
  dvec3 half{1.0};      // at least a tenth of the largest one in each axis
  double radius = 1.0;  // of the sphere around the real bounds
  double floor = -1.0;  // lowest z of the real bounds
};

bool usable(const core::AabbD& box) {
  return !box.empty() && core::is_finite(box.min) && core::is_finite(box.max);
}

Stage set_stage(core::AabbD bounds, const std::vector<dvec3>& places) {
  if (!usable(bounds)) {
    bounds = {};
    for (const dvec3& p : places)
      if (core::is_finite(p)) bounds.grow(p);
  }
  if (!usable(bounds)) return {};
  bounds.min = glm::clamp(bounds.min, dvec3(-kFarthest), dvec3(kFarthest));
  bounds.max = glm::clamp(bounds.max, dvec3(-kFarthest), dvec3(kFarthest));
  Stage stage;
  stage.centre = bounds.centre();
  stage.half = 0.5 * bounds.size();
  stage.radius = glm::length(stage.half);
  stage.floor = bounds.min.z;
  // A model smaller than this counts as a point: double precision could not tell places around it apart.
  const double noise = 1e-8 * magnitude(stage.centre);
  if (stage.radius < std::max(1e-6, noise)) stage.radius = std::max(1.0, noise);
  stage.half = glm::max(stage.half, dvec3(0.1 * stage.radius));
  return stage;
}

/// Up to `wanted` centres of gravity of the fullest cells of a coarse grid, apart from each other, fullest first.
std::vector<dvec3> dense_places(const Stage& stage, const std::vector<dvec3>& places, std::size_t wanted) {
  constexpr int kCells = 24;
  struct Cell {
    dvec3 sum{0.0};
    std::size_t count = 0, index = 0;
  };
  std::vector<Cell> cells(std::size_t(kCells) * kCells * kCells);
  const double edge = 2.0 * std::max({stage.half.x, stage.half.y, stage.half.z}) / kCells;
  const dvec3 low = stage.centre - stage.half, high = stage.centre + stage.half;
  for (const dvec3& p : places) {
    if (!core::is_finite(p)) continue;
    const dvec3 inside = glm::clamp(p, low, high);
    const dvec3 place = glm::clamp((inside - low) / edge, dvec3(0.0), dvec3(kCells - 1));
    Cell& cell = cells[(std::size_t(place.z) * kCells + std::size_t(place.y)) * kCells + std::size_t(place.x)];
    cell.sum += inside - stage.centre;
    ++cell.count;
  }
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i].index = i;
  std::sort(cells.begin(), cells.end(),
            [](const Cell& a, const Cell& b) { return a.count != b.count ? a.count > b.count : a.index < b.index; });
  std::vector<dvec3> found;
  for (const Cell& cell : cells) {
    if (cell.count == 0 || found.size() == wanted) break;
    const dvec3 p = stage.centre + cell.sum / double(cell.count);
    const bool apart = std::none_of(found.begin(), found.end(),
                                    [&](const dvec3& f) { return glm::length(f - p) < 0.3 * stage.radius; });
    if (apart) found.push_back(p);
  }
  if (found.empty()) found = {stage.centre - 0.5 * stage.half, stage.centre + 0.5 * stage.half};
  return found;
}

/// Collects keys with the time each leg takes, in arbitrary units.
class Tour {
 public:
  explicit Tour(const Stage& stage) : stage_(stage) {}

  void overview(double degrees, double elevation, double leg) {
    const double angle = degrees * kPi / 180.0;
    const dvec3 from(std::cos(angle), std::sin(angle), elevation);
    look(stage_.centre + unit(from) * (2.2 * stage_.radius), stage_.centre, leg);
  }

  void dive(const dvec3& place, double degrees) {
    const double angle = degrees * kPi / 180.0;
    const dvec3 from = unit({std::cos(angle), std::sin(angle), 0.5});
    look(place + from * (0.9 * stage_.radius), place, 3.0);
    look(place + from * (0.15 * stage_.radius), place, 3.0);
    look(place + unit({-from.y, from.x, 0.3}) * (0.12 * stage_.radius), place, 2.0);
    look(place + unit({-from.x, -from.y, 1.5}) * (0.9 * stage_.radius), place, 3.0);
  }

  /// Along the longest horizontal axis at eye height, swinging a little from side to side.
  void walk() {
    constexpr int kSteps = 6;
    for (int i = 0; i <= kSteps; ++i) {
      const double along = 2.1 * i / kSteps - 1.05, swing = i % 2 == 0 ? 0.1 : -0.1;
      const dvec3 eye = on_foot(along, swing);
      look(eye, eye + forward() * (0.3 * reach()), i == 0 ? 5.0 : 2.0);
    }
  }

  /// A full turn on the spot and one back, faster than anybody would steer by hand.
  void turns() {
    const dvec3 eye = on_foot(0.0, 0.0), ahead = forward(), side(-ahead.y, ahead.x, 0.0);
    const double r = 0.3 * reach();
    const dvec3 around[] = {ahead, side, -ahead, -side, ahead, -side, -ahead, side, ahead};
    for (std::size_t i = 0; i < std::size(around); ++i) look(eye, eye + around[i] * r, i == 0 ? 4.0 : 0.5);
  }

  core::CameraPath path(double duration) && {
    const double total = keys_.back().time;
    for (core::CameraKey& key : keys_) key.time *= duration / total;
    core::Expected<core::CameraPath> created = core::CameraPath::create(std::move(keys_));
    assert(created.has_value());
    return std::move(*created);
  }

 private:
  void look(const dvec3& eye, const dvec3& target, double leg) {
    const double time = keys_.empty() ? 0.0 : keys_.back().time + leg;
    keys_.push_back({time, {eye, target, {0.0, 0.0, 1.0}}, kFovy});
  }
  bool along_x() const { return stage_.half.x >= stage_.half.y; }
  dvec3 forward() const { return along_x() ? dvec3(1.0, 0.0, 0.0) : dvec3(0.0, 1.0, 0.0); }
  double reach() const { return along_x() ? stage_.half.x : stage_.half.y; }
  dvec3 on_foot(double along, double swing) const {
    const double width = along_x() ? stage_.half.y : stage_.half.x;
    const dvec3 side(-forward().y, forward().x, 0.0);
    dvec3 eye = stage_.centre + forward() * (along * reach()) + side * (swing * width);
    eye.z = stage_.floor + std::min(1.7, 0.3 * stage_.half.z);  // eye height; 15 % of a model lower than 11 m
    return eye;
  }

  Stage stage_;
  std::vector<core::CameraKey> keys_;
};

/// 0.0001 of the diagonal, clamped to 1 cm … 10 m, but never so far that a small model would be cut away.
double near_for(double diagonal) {
  return std::min(std::clamp(1e-4 * diagonal, 0.01, 10.0), 0.01 * diagonal);
}

}  // namespace

core::CameraPath make_tour(const core::AabbD& bounds, const std::vector<core::dvec3>& places, double duration) {
  const Stage stage = set_stage(bounds, places);
  if (!(duration > 0.0 && std::isfinite(duration))) duration = 60.0;
  Tour tour(stage);
  tour.overview(-60.0, 0.6, 0.0);
  tour.overview(20.0, 0.5, 4.0);
  double angle = 60.0;
  for (const dvec3& place : dense_places(stage, places, 3)) {
    tour.dive(place, angle);
    angle += 110.0;
  }
  tour.overview(150.0, 0.5, 4.0);
  tour.walk();
  tour.turns();
  tour.overview(230.0, 0.4, 5.0);
  tour.overview(300.0, 0.6, 4.0);
  core::CameraPath path = std::move(tour).path(duration);
  path.near = near_for(2.0 * stage.radius);
  path.far = core::kInfiniteFar;
  return path;
}

core::CameraPath make_tour(const core::ItemBounds& items, const core::FittedBounds& fitted, double duration) {
  constexpr std::size_t kPlaces = 4096;
  std::vector<dvec3> places;
  const std::size_t step = std::max<std::size_t>(1, items.size() / kPlaces);
  for (std::size_t i = 0; i < items.size(); i += step) {
    const core::Aabb box = items.box(i);
    if (!box.empty()) places.push_back(items.origin + 0.5 * (dvec3(box.min) + dvec3(box.max)));
  }
  return make_tour(fitted.bounds, places, duration);
}

}  // namespace sightline::engine
