// Variants along a path: times, counts and errors.
#pragma once

#include <string>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/view.h"
#include "sightline/study/culler.h"
#include "sightline/study/exact.h"
#include "sightline/study/tree.h"
#include "sightline/study/variant.h"

namespace sightline::study {

/// A scene, its trees, a path, and the exact sets of some of its frames.
struct Model {
  std::string name;
  std::vector<core::Aabb> boxes;
  std::vector<std::uint8_t> kinds;  ///< may be empty
  std::vector<core::View> views;
  double seconds = 60.0;  ///< that the path takes

  Tree mean, median, sah;
  double mean_seconds = 0.0, median_seconds = 0.0, sah_seconds = 0.0;  ///< to build them
  std::vector<std::size_t> sampled;                                    ///< frames that errors are counted on
  std::vector<ExactSets> exact;                                        ///< of those

  /// Builds trees and exact sets of `samples` frames.
  void prepare(std::size_t samples);
  const Tree& tree(TreeKind kind) const;
};

struct Run {
  std::string variant;
  Promise promise = Promise::kSame;
  bool has_promise = true;
  std::vector<double> ms;  ///< per frame, median of the passes
  std::vector<std::uint64_t> visible;
  double mean_ms = 0.0, median_ms = 0.0, min_ms = 0.0, max_ms = 0.0;
  double fastest_ms = 0.0;  ///< mean over the frames of the fastest pass: what other programs disturb least
  double mean_visible = 0.0, mean_nodes = 0.0, mean_boxes = 0.0;
  Errors errors;  ///< sums over the sampled frames
  std::size_t samples = 0, memory_bytes = 0;
};

/// Flies the path `passes` times (>= 1). Errors are those of the first pass.
Run measure(const Model& model, const Variant& variant, int passes);
/// The same for the brute-force baseline.
Run measure_brute_force(const Model& model, int passes);

double median_of(std::vector<double> values);

}  // namespace sightline::study
