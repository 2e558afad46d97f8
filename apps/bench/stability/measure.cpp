#include "sightline/apps/bench/stability/measure.h"

#include <algorithm>
#include <cmath>

#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::bench {
namespace {

using core::dvec3;

/// Judges one ray after another.
class ErrorJudge {
 public:
  explicit ErrorJudge(const Limits& limits) { found_.limits = limits; }

  void add(const Sample& sample, const Truth& truth, const Answer& answer) {
    ++found_.rays;
    found_.hits += !truth.crossings.empty();
    if (!is_finite(answer.hits)) {
      ++found_.not_finite;
      return;
    }
    if (!(dot(truth.ray.direction, truth.ray.direction) > 0)) {  // a flattened item may show a plate or nothing
      ++found_.ties;
      return;
    }
    const auto near = [&](double band) { return neighbours(sample.primitive, truth.ray, band * sample.radius); };
    const int expected = answer.first_only ? std::min(1, int(truth.crossings.size())) : int(truth.crossings.size());
    const int found = answer.hits.count;
    if (found != expected) {
      // The search for ties takes long. With many errors it does not change the verdict.
      constexpr int kHopeless = 50;
      const bool hopeless = found_.false_hits + found_.false_misses >= kHopeless;
      const bool tie = !hopeless && (near_tie(truth.crossings, near(found_.limits.band)) ||
                                     differ_by_slivers(sample, truth, answer));
      ++(tie ? found_.ties : found > expected ? found_.false_hits : found_.false_misses);
      return;
    }
    if (answer.first_only && found == 1 && took_another(sample, truth, answer.hits.hit[0])) {
      const bool late = Quad(answer.hits.hit[0].t) > truth.crossings[0].t;
      ++(near_tie(truth.crossings, near(found_.limits.band)) ? found_.ties
         : late                                              ? found_.false_misses
                                                             : found_.false_hits);
      return;
    }
    double t_error = 0.0, normal_error = 0.0;
    for (int i = 0; i < found; ++i) {
      const Crossing& crossing = truth.crossings[std::size_t(i)];
      const gpuprims::Hit& hit = answer.hits.hit[std::size_t(i)];
      t_error = std::max(t_error, radii(sample, truth, Quad(hit.t) - crossing.t));
      normal_error = std::max(normal_error, angle_between(hit.normal, crossing.normal));
    }
    if (t_error > found_.limits.t || normal_error > found_.limits.normal) {
      // Without a band that excuses wrong results, a rim still has two normals.
      constexpr double kRim = 0x1p-21;
      const bool rim = found_.limits.band == 0.0 && t_error <= found_.limits.t;
      const Neighbours beside = near(rim ? kRim : found_.limits.band);
      if (near_tie(truth.crossings, beside)) {
        ++found_.ties;
        return;
      }
      constexpr double kUnseen = 1.1;  // sixteen neighbours leave gaps
      normal_error = std::max(0.0, normal_error - kUnseen * normal_spread(truth.crossings, beside));
    }
    if (found > 0) errors_.push_back(t_error);
    found_.max_normal = std::max(found_.max_normal, normal_error);
  }

  CaseErrors finish() {
    if (!errors_.empty()) {
      std::sort(errors_.begin(), errors_.end());
      found_.max_t = errors_.back();
      found_.p999_t = errors_[std::size_t(std::ceil(0.999 * double(errors_.size()))) - 1];
    }
    return found_;
  }

 private:
  static bool is_finite(const gpuprims::Hits& hits) {
    return std::all_of(hits.hit.begin(), hits.hit.begin() + hits.count,
                       [](const gpuprims::Hit& hit) { return std::isfinite(hit.t) && core::is_finite(hit.normal); });
  }
  static double radii(const Sample& sample, const Truth& truth, Quad t) {
    return double(fabsq(t) * sqrtq(dot(truth.ray.direction, truth.ray.direction))) / sample.radius;
  }
  /// Whether the answer skipped the nearest crossing, or found something in front of it.
  bool took_another(const Sample& sample, const Truth& truth, const gpuprims::Hit& hit) const {
    const auto off = [&](const Crossing& c) { return radii(sample, truth, Quad(hit.t) - c.t); };
    constexpr double kApart = 0.1;  // radii; nearer than this it is the same crossing with an error
    if (off(truth.crossings[0]) <= std::max(kApart, found_.limits.t)) return false;
    return Quad(hit.t) < truth.crossings[0].t ||
           std::any_of(truth.crossings.begin() + 1, truth.crossings.end(),
                       [&](const Crossing& c) { return off(c) <= found_.limits.t; });
  }
  /// Whether the answers are equal except for pairs of crossings that lie closer together than the band.
  bool differ_by_slivers(const Sample& sample, const Truth& truth, const Answer& answer) const {
    if (answer.first_only) return false;
    const auto count = [&](std::size_t crossings, const auto& t_of) {
      int left = 0;
      for (std::size_t i = 0; i < crossings; ++i, ++left)
        if (i + 1 < crossings && radii(sample, truth, t_of(i + 1) - t_of(i)) <= found_.limits.band) ++i, --left;
      return left;
    };
    return count(truth.crossings.size(), [&](std::size_t i) { return truth.crossings[i].t; }) ==
           count(std::size_t(answer.hits.count), [&](std::size_t i) { return Quad(answer.hits.hit[i].t); });
  }

  CaseErrors found_;
  std::vector<double> errors_;
};

}  // namespace

std::string_view path_name(Path path) {
  constexpr std::string_view kNames[kPathCount] = {"double", "glsl"};
  return kNames[int(path)];
}

bool CaseErrors::ok() const {
  // The share is estimated from a sample: allow three standard deviations of the count.
  const double expected = limits.wrong * rays, allowed = expected + 3.0 * std::sqrt(expected);
  return not_finite == 0 && max_t <= limits.t && max_normal <= limits.normal && false_hits + false_misses <= allowed;
}

std::vector<Sample> make_samples(const Case& c, int rays, std::uint64_t seed) {
  Random random(seed);
  std::vector<Sample> samples;
  samples.reserve(std::size_t(rays));
  for (int i = 0; i < rays; ++i) samples.push_back(c.sample(random));
  return samples;
}

Truth find_truth(const Sample& sample) {
  Truth truth;
  truth.ray = in_item_frame(sample.world_from_item, sample.ray);
  truth.crossings = reference_crossings(sample.primitive, truth.ray);
  return truth;
}

Answer intersect_on_cpu(const Sample& sample) {
  const core::dmat3 item_from_world = glm::inverse(sample.world_from_item.linear);
  const core::Ray ray{item_from_world * (sample.ray.origin - sample.world_from_item.origin),
                      item_from_world * sample.ray.direction};
  Answer answer;
  answer.hits = gpuprims::intersect(sample.primitive, ray);
  return answer;
}

CaseErrors judge(std::span<const Sample> samples, std::span<const Truth> truths, std::span<const Answer> answers,
                 const Limits& limits) {
  ErrorJudge judge(limits);
  for (std::size_t i = 0; i < samples.size(); ++i) judge.add(samples[i], truths[i], answers[i]);
  return judge.finish();
}

}  // namespace sightline::bench
