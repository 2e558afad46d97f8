// Figures of one case on one path: what a way of computing crossings answers, judged by the reference.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "sightline/bench/stability/cases.h"
#include "sightline/bench/stability/reference.h"

namespace sightline::bench {

/// Ways of computing. The first two are gpuprims::intersect, the third the shaders.
enum class Path { kDouble, kFloat, kGlsl };
inline constexpr int kPathCount = 3;
std::string_view path_name(Path path);

/// What a path found on one ray.
struct Answer {
  gpuprims::Hits hits;      ///< t of the world's ray, normals in the item's frame
  bool first_only = false;  ///< a shader tells the nearest crossing alone
};

struct Figures {
  int rays = 0, hits = 0;                ///< hits: rays that the reference has crossings on
  int false_hits = 0, false_misses = 0;  ///< crossings too many, too few, on rays outside the band
  int ties = 0;                          ///< rays within the band whose answer was not taken amiss
  int not_finite = 0;                    ///< answers with a t or a normal that is no number
  double max_t = 0.0, p999_t = 0.0;      ///< error of t in radii: largest, 99.9th percentile
  double max_normal = 0.0;               ///< radians
  Limits limits;

  /// Within the limits.
  bool ok() const;
};

struct Result {
  core::Kind kind = core::Kind::kCylinder;
  std::string family, name;  ///< see Case
  double magnitude = 0.0;
  Path path = Path::kDouble;
  Figures figures;
};

/// The samples of a case, the same for the same seed.
std::vector<Sample> make_samples(const Case& c, int rays, std::uint64_t seed);

/// What the reference says of a sample.
struct Truth {
  QuadRay ray;  ///< in the item's frame
  std::vector<Crossing> crossings;
};
Truth find_truth(const Sample& sample);

/// gpuprims::intersect on the ray moved into the item's frame in double; Path::kDouble or kFloat.
Answer intersect_on_cpu(const Sample& sample, Path path);

/// Compares answers with the truth, one of each per sample.
Figures judge(std::span<const Sample> samples, std::span<const Truth> truths, std::span<const Answer> answers,
              const Limits& limits);

}  // namespace sightline::bench
