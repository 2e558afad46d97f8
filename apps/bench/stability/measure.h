// CaseErrors of one case on one path: the crossings that the path computes, judged by the reference.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "sightline/apps/bench/stability/cases.h"
#include "sightline/apps/bench/stability/reference.h"

namespace sightline::bench {

/// Ways of computing crossings: gpuprims::intersect, and the shaders.
enum class Path { kDouble, kGlsl };
inline constexpr int kPathCount = 2;
std::string_view path_name(Path path);

/// The result of a path for one ray.
struct Answer {
  gpuprims::Hits hits;      ///< t of the world's ray, normals in the item's frame
  bool first_only = false;  ///< a shader returns only the nearest crossing
};

struct CaseErrors {
  int rays = 0, hits = 0;                ///< hits: rays on which the reference has crossings
  int false_hits = 0, false_misses = 0;  ///< too many or too few crossings, on rays outside the band
  int ties = 0;                          ///< rays within the band whose result is not counted as an error
  int not_finite = 0;                    ///< results with a t or a normal that is not finite
  double max_t = 0.0, p999_t = 0.0;      ///< error of t in radii: largest, 99.9th percentile
  double max_normal = 0.0;               ///< radians
  Limits limits;

  /// True within the limits.
  bool ok() const;
};

struct Result {
  core::Kind kind = core::Kind::kCylinder;
  std::string family, name;  ///< see Case
  double magnitude = 0.0;
  Path path = Path::kDouble;
  CaseErrors errors;
};

/// The samples of a case. The same seed gives the same samples.
std::vector<Sample> make_samples(const Case& c, int rays, std::uint64_t seed);

/// The reference's result for a sample.
struct Truth {
  QuadRay ray;  ///< in the item's frame
  std::vector<Crossing> crossings;
};
Truth find_truth(const Sample& sample);

/// Runs gpuprims::intersect on the ray, moved into the item's frame in double.
Answer intersect_on_cpu(const Sample& sample);

/// Compares answers with the truth, one of each per sample.
CaseErrors judge(std::span<const Sample> samples, std::span<const Truth> truths, std::span<const Answer> answers,
                 const Limits& limits);

}  // namespace sightline::bench
