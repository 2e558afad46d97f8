#include "sightline/apps/report/tour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "sightline/core/image_rays.h"
#include "sightline/engine/tour.h"

namespace sightline::apps {
namespace {

using core::dvec3;

constexpr int kSteps = 240;      // keys of the new path but one: four a second
constexpr int kEase = 3;         // keys over which a turn begins and ends
constexpr int kRounds = 4;       // of turning and smoothing
constexpr int kCandidates = 24;  // items that the camera may turn to

/// Centres of items within `bounds`, far apart from each other: each is the farthest from all before it.
std::vector<dvec3> spread_centres(const core::ItemBounds& items, const core::AabbD& bounds) {
  constexpr std::size_t kSample = 2000;
  std::vector<dvec3> centres;
  const std::size_t step = std::max<std::size_t>(1, items.size() / kSample);
  for (std::size_t i = 0; i < items.size(); i += step) {
    const core::Aabb box = items.box(i);
    if (box.empty()) continue;
    const dvec3 centre = items.origin + 0.5 * (dvec3(box.min) + dvec3(box.max));
    if (centre == glm::clamp(centre, bounds.min, bounds.max)) centres.push_back(centre);
  }
  std::vector<dvec3> chosen;
  std::vector<double> distances(centres.size(), std::numeric_limits<double>::infinity());
  dvec3 last = bounds.centre();
  while (chosen.size() < std::min(std::size_t(kCandidates), centres.size())) {
    for (std::size_t i = 0; i < centres.size(); ++i)
      distances[i] = std::min(distances[i], glm::length(centres[i] - last));
    const auto farthest = std::max_element(distances.begin(), distances.end()) - distances.begin();
    if (!(distances[std::size_t(farthest)] > 0.0)) break;
    chosen.push_back(last = centres[std::size_t(farthest)]);
  }
  return chosen;
}

/// Keys of a path whose cameras are turned until each sees enough.
class Turning {
 public:
  Turning(const raytrace::Tracer& tracer, const core::CameraPath& path, double aspect, const core::AabbD& bounds)
      : tracer_(tracer),
        path_(path),
        aspect_(aspect),
        size_(glm::length(bounds.size())),
        candidates_(spread_centres(tracer.snapshot().bounds(), bounds)) {
    for (int i = 0; i <= kSteps; ++i) {
      const double time = path.time_of(i, kSteps + 1);
      const core::CameraSample at = path.sample(time);
      keys_.push_back({time, at.pose, at.fovy});
    }
    turned_.resize(keys_.size());
  }

  core::Expected<core::CameraPath> run() {
    const auto first = share(keys_.front());
    if (!first) return tl::unexpected(first.error());
    constexpr double kLeast = 0.002, kMost = 0.05;  // some five rays; a twentieth of the image
    wanted_ = std::clamp(0.5 * *first, kLeast, kMost);
    if (candidates_.empty()) return path_;
    for (int round = 0; round < kRounds; ++round) {
      const auto turned = turn();
      if (!turned) return tl::unexpected(turned.error());
      if (*turned == 0) break;
      if (round + 1 < kRounds) smooth();
    }
    auto path = core::CameraPath::create(std::move(keys_));
    if (path) path->near = path_.near, path->far = path_.far;
    return path;
  }

 private:
  core::Expected<double> share(const core::CameraKey& key) const {
    const auto view = core::View::perspective(key.pose, key.fovy, aspect_, path_.near, path_.far);
    if (!view) return tl::unexpected(view.error());
    return covered_share(tracer_, *view, aspect_);
  }

  /// Turns the cameras that see too little, and returns how many.
  core::Expected<int> turn() {
    int count = 0;
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      const auto seen = share(keys_[i]);
      if (!seen) return tl::unexpected(seen.error());
      if (*seen >= wanted_) continue;
      constexpr std::array kLifts{0.0, 0.02, 0.05, 0.1, 0.2};  // of the model's size
      bool better = false;
      double best = *seen;
      const core::CameraKey before = keys_[i];
      for (const double lift : kLifts) {
        core::CameraKey key = before;
        key.pose.eye.z += lift * size_;
        better |= turn_to_candidate(key, best, keys_[i]);
        if (best >= wanted_) break;
      }
      turned_[i] = turned_[i] || better;
      count += better;
    }
    return count;
  }

  /// Tries the candidates, from the last one on that was chosen, until one will do; takes the best of them over into
  /// `chosen` if it shows more than `best`.
  bool turn_to_candidate(core::CameraKey key, double& best, core::CameraKey& chosen) {
    bool better = false;
    const std::size_t first = last_candidate_;
    for (std::size_t k = 0; k < candidates_.size() && best < wanted_; ++k) {
      const std::size_t candidate = (first + k) % candidates_.size();
      key.pose.target = candidates_[candidate];
      const auto found = share(key);  // fails where the eye is at the target
      if (!found || *found <= best) continue;
      best = *found, chosen = key, last_candidate_ = candidate;
      better = true;
    }
    return better;
  }

  /// Means of the poses around each key that was turned or is near to one.
  void smooth() {
    const std::vector<core::CameraKey> before = keys_;
    const auto index = [&](std::ptrdiff_t i) {
      return std::size_t(std::clamp<std::ptrdiff_t>(i, 0, std::ptrdiff_t(keys_.size()) - 1));
    };
    for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(keys_.size()); ++i) {
      bool near = false;
      dvec3 eye(0.0), target(0.0);
      for (std::ptrdiff_t k = -kEase; k <= kEase; ++k) {
        near |= turned_[index(i + k)];
        eye += before[index(i + k)].pose.eye;
        target += before[index(i + k)].pose.target;
      }
      constexpr double kKeys = 2.0 * kEase + 1.0;
      core::Pose& pose = keys_[std::size_t(i)].pose;
      if (near && eye != target) pose.eye = eye / kKeys, pose.target = target / kKeys;
    }
  }

  const raytrace::Tracer& tracer_;
  const core::CameraPath& path_;
  double aspect_, size_, wanted_ = 0.0;
  std::vector<dvec3> candidates_;
  std::size_t last_candidate_ = 0;
  std::vector<core::CameraKey> keys_;
  std::vector<bool> turned_;
};

}  // namespace

core::Expected<double> covered_share(const raytrace::Tracer& tracer, const core::View& view, double aspect) {
  constexpr int kHeight = 36;
  const int width = std::clamp(int(std::lround(kHeight * aspect)), 1, 8 * kHeight);
  const auto rays = core::ImageRays::create(view, width, kHeight);
  if (!rays) return tl::unexpected(rays.error());
  std::vector<core::Ray> all;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < width; ++x) all.push_back(rays->through(x + 0.5, y + 0.5));
  std::vector<raytrace::FirstHit> hits(all.size());
  if (auto done = tracer.nearest(all, hits, raytrace::filter_of(view)); !done) return tl::unexpected(done.error());
  std::unordered_map<core::Slot, int> counts;
  for (const raytrace::FirstHit& hit : hits)
    if (hit.slot != core::kNone) ++counts[hit.slot];
  int all_items = 0, largest = 0;
  for (const auto& [slot, count] : counts) all_items += count, largest = std::max(largest, count);
  constexpr double kMostOfOne = 0.9;
  const double pixels = double(hits.size());
  return largest > kMostOfOne * pixels ? 0.0 : all_items / pixels;
}

core::Expected<core::CameraPath> tour_in_sight(const raytrace::Tracer& tracer, const core::FittedBounds& fitted,
                                               double aspect) {
  const core::ItemBounds& items = tracer.snapshot().bounds();
  const core::CameraPath path = engine::make_tour(items, fitted);
  return Turning(tracer, path, aspect, fitted.bounds).run();
}

}  // namespace sightline::apps
