#include "sightline/apps/bench/stability/fuzz.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace sightline::bench {
namespace {

using core::dvec3;
using core::Kind;
using core::Primitive;

constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();

/// Values that files should not contain, but do.
float hostile(Random& random) {
  switch (random.below(10)) {
    case 0:
      return 0.0f;
    case 1:
      return std::numeric_limits<float>::quiet_NaN();
    case 2:
      return float(random.sign()) * kFloatInfinity;
    case 3:
      return float(random.sign() * random.uniform(1.0, 1e6) * double(std::numeric_limits<float>::denorm_min()));
    case 4:
      return float(random.sign() * random.log_uniform(20.0, 38.0));
    case 5:
      return float(random.sign() * random.log_uniform(-37.0, -10.0));
    default:
      return float(random.sign() * random.log_uniform(-6.0, 6.0));
  }
}

/// Whether a parameter is an angle: of a sweep, or of a snout's slant.
bool is_angle(Kind kind, int parameter) {
  if (kind == Kind::kCircularTorus) return parameter == 2;
  if (kind == Kind::kRectangularTorus) return parameter == 3;
  return kind == Kind::kSnout && parameter >= 5;
}

float angle(Kind kind, Random& random) {
  if (kind == Kind::kSnout) return random.below(2) ? 0.0f : float(random.uniform(-1.0, 1.0));
  return random.below(4) ? float(random.uniform(0.0, 7.0)) : float(random.log_uniform(-4.0, 1.0));
}

Primitive random_primitive(Kind kind, Random& random) {
  const int mood = random.below(10), count = core::parameter_count(kind);
  const double common = random.uniform(-4.0, 4.0);
  float values[9] = {};
  for (int i = 0; i < count; ++i) {
    if (mood >= 8 && random.below(3) == 0) {
      values[i] = hostile(random);
    } else if (is_angle(kind, i)) {
      values[i] = angle(kind, random);
    } else {
      values[i] = float(mood < 6 ? random.log_uniform(common - 1.0, common + 1.0) : random.log_uniform(-6.0, 6.0));
      if (random.below(16) == 0) values[i] = random.below(2) ? 0.0f : -values[i];
    }
  }
  return core::make_primitive(kind, {values, std::size_t(count)});
}

bool all(const Primitive& primitive, bool (*holds)(float)) {
  const auto values = core::parameters(primitive);
  return std::all_of(values.begin(), values.end(), holds);
}
bool is_finite(float v) {
  return std::isfinite(v);
}
/// Whether agreement is required for this value.
bool is_sane(float v) {
  return v == 0.0f || (std::fabs(v) >= 1e-6f && std::fabs(v) <= 1e6f);
}

bool is_thin(const Primitive& primitive) {
  const auto values = core::parameters(primitive);
  const Kind kind = core::kind_of(primitive);
  // Offsets are no thickness, and cones and pyramids may come to a point.
  const auto length = [&](int i) {
    const bool offset = (kind == Kind::kSnout && i >= 3) || (kind == Kind::kPyramid && (i == 4 || i == 5));
    return is_angle(kind, i) || offset ? -1.0f : std::fabs(values[std::size_t(i)]);
  };
  double largest = 0.0, least = HUGE_VAL;
  for (int i = 0; i < int(values.size()); ++i) {
    largest = std::max(largest, double(std::fabs(values[std::size_t(i)])));
    if (length(i) >= 0.0f) least = std::min(least, double(length(i)));
  }
  return least < kFuzzThin * largest;
}

/// Largest distance of the bounds from the local origin; 1 without bounds.
double size_of(const core::AabbD& box) {
  const dvec3 far = glm::max(glm::abs(box.min), glm::abs(box.max));
  const double size = std::max({far.x, far.y, far.z});
  return size > 0.0 && size < 1e30 ? size : 1.0;
}

/// A ray aimed at a point of the surface or of the bounds.
Sample random_sample(Kind kind, Random& random) {
  Sample sample{random_primitive(kind, random), {}, {}, 1.0};
  const core::AabbD box = core::bounds(sample.primitive, {});
  const double size = size_of(box);
  dvec3 target = glm::mix(box.min, box.max, dvec3(random.unit(), random.unit(), random.unit()));
  if (random.below(2) && all(sample.primitive, is_finite)) target = surface_point(sample.primitive, random).point;
  if (!(glm::length(target) <= 2.0 * size)) target = size * random.uniform(-1.0, 1.0) * random.direction();
  const double distance = size * random.log_uniform(-1.0, 3.0);
  const dvec3 direction = random.direction();
  sample.ray = {target - distance * direction, random.log_uniform(-1.0, 1.0) * direction};
  sample.radius = size;
  return sample;
}

std::string describe(const char* what, const Sample& sample) {
  std::string text = what;
  char number[40];
  for (const float v : core::parameters(sample.primitive)) {
    std::snprintf(number, sizeof(number), " %.9g", double(v));
    text += number;
  }
  text += ";";
  for (const dvec3& v : {sample.ray.origin, sample.ray.direction}) {
    std::snprintf(number, sizeof(number), " %.17g", v.x);
    text += number;
    std::snprintf(number, sizeof(number), " %.17g", v.y);
    text += number;
    std::snprintf(number, sizeof(number), " %.17g", v.z);
    text += number;
  }
  return text;
}

class Fuzz {
 public:
  explicit Fuzz(Kind kind) { counts_.kind = kind; }

  void judge(const Sample& sample, const Answer& shader) {
    ++counts_.sets;
    counts_.hits += shader.hits.count > 0;
    const bool finite = all(sample.primitive, is_finite);
    counts_.finite += finite;
    const Answer exact = intersect_on_cpu(sample);
    if (!numbers(shader.hits) || !numbers(exact.hits)) {
      blame(counts_.not_finite, numbers(shader.hits) ? "not finite in double:" : "not finite:", sample);
      return;
    }
    if (!finite) {
      if (shader.hits.count > 0) blame(counts_.disagree, "hit without finite parameters:", sample);
      return;
    }
    if (!within_bounds(sample, exact.hits) && !within_bounds(sample, true_hits(sample)))
      blame(counts_.outside, "outside bounds:", sample);
    if (all(sample.primitive, is_sane) && (shader.hits.count > 0) != (exact.hits.count > 0)) disagree(sample, shader);
  }

  FuzzCounts finish() { return std::move(counts_); }

 private:
  static bool numbers(const gpuprims::Hits& hits) {
    return std::all_of(hits.hit.begin(), hits.hit.begin() + hits.count,
                       [](const gpuprims::Hit& hit) { return std::isfinite(hit.t) && core::is_finite(hit.normal); });
  }

  static gpuprims::Hits true_hits(const Sample& sample) {
    gpuprims::Hits hits;
    for (const Crossing& c : find_truth(sample).crossings) hits.insert({double(c.t), c.normal, c.face});
    return hits;
  }

  /// Allows for what t loses on its way from the eye.
  static bool within_bounds(const Sample& sample, const gpuprims::Hits& hits) {
    const core::AabbD box = core::bounds(sample.primitive, {});
    const double slack = 1e-12 * (sample.radius + glm::length(sample.ray.origin));
    return std::all_of(hits.hit.begin(), hits.hit.begin() + hits.count, [&](const gpuprims::Hit& hit) {
      const dvec3 p = sample.ray.origin + hit.t * sample.ray.direction;
      return glm::all(glm::greaterThanEqual(p, box.min - slack)) && glm::all(glm::lessThanEqual(p, box.max + slack));
    });
  }

  void disagree(const Sample& sample, const Answer& shader) {
    const Truth truth = find_truth(sample);
    if (truth.crossings.empty() == (shader.hits.count == 0)) return;  // then double was wrong
    if (is_thin(sample.primitive)) {
      ++counts_.thin;
      return;
    }
    double band = kFuzzBand;
    const auto tie = [&] {
      return near_tie(truth.crossings, neighbours(sample.primitive, truth.ray, band * sample.radius));
    };
    if (tie()) {
      ++counts_.in_band;
      return;
    }
    while (!tie() && band < 1.0) band *= 10.0;
    char what[80];
    std::snprintf(what, sizeof(what), "false %s, a tie within %.0e sizes:", truth.crossings.empty() ? "hit" : "miss",
                  band);
    blame(counts_.disagree, what, sample);
  }

  void blame(std::int64_t& count, const char* what, const Sample& sample) {
    constexpr std::size_t kExamples = 10;
    ++count;
    if (counts_.examples.size() < kExamples) counts_.examples.push_back(describe(what, sample));
  }

  FuzzCounts counts_;
};

}  // namespace

core::Expected<FuzzCounts> fuzz(GlslRays& shaders, Kind kind, std::int64_t sets, std::uint64_t seed) {
  constexpr std::int64_t kBatch = 20'000;
  Random random(seed + 1000 * std::uint64_t(kind));
  Fuzz judge(kind);
  for (std::int64_t first = 0; first < sets; first += kBatch) {
    std::vector<Sample> samples;
    for (std::int64_t i = first; i < std::min(sets, first + kBatch); ++i)
      samples.push_back(random_sample(kind, random));
    const auto answers = shaders.trace(kind, samples);
    if (!answers) return tl::unexpected(answers.error());
    for (std::size_t i = 0; i < samples.size(); ++i) judge.judge(samples[i], (*answers)[i]);
  }
  return judge.finish();
}

}  // namespace sightline::bench
