// Methods along a path: times, counts and errors.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/study/exact.h"
#include "sightline/apps/study/method.h"
#include "sightline/apps/study/tree.h"
#include "sightline/apps/study/variant.h"

namespace sightline::study {

/// A flight, and the exact sets of some of its frames.
struct Path {
  std::vector<core::View> views;
  double seconds = 60.0;             ///< that it takes
  std::vector<std::size_t> sampled;  ///< frames that errors are counted on
  std::vector<ExactSets> exact;      ///< of those
};

/// A scene, its trees and its path.
struct Model {
  std::string name;
  std::vector<core::Aabb> boxes;
  std::vector<std::uint8_t> kinds;  ///< may be empty
  Path path;

  Tree mean, median;
  double mean_seconds = 0.0, median_seconds = 0.0;  ///< to build them

  /// Builds trees, and exact sets of `samples` frames of the path.
  void prepare(std::size_t samples);
  const Tree& tree(TreeKind kind) const { return kind == TreeKind::kMean ? mean : median; }
};

enum class Origin : std::uint8_t { kStudy, kProduction, kBaseline };

struct Run {
  std::string variant;
  Origin origin = Origin::kStudy;
  std::optional<Promise> promise;  ///< nullopt: none is known
  std::vector<double> ms;          ///< per frame, median of the passes
  std::vector<std::uint64_t> visible;
  double mean_ms = 0.0, median_ms = 0.0, min_ms = 0.0, max_ms = 0.0;
  double fastest_ms = 0.0;  ///< mean over the frames of the fastest pass: what other programs disturb least
  double mean_visible = 0.0, mean_nodes = 0.0, mean_boxes = 0.0;
  double build_seconds = 0.0;  ///< all that comes before the first frame; of variants without their tree
  Errors errors;               ///< sums over the sampled frames
  std::size_t samples = 0, memory_bytes = 0;

  double per_sample(std::uint64_t errors_in_all) const {
    return samples == 0 ? 0.0 : double(errors_in_all) / double(samples);
  }
  double false_positives() const { return per_sample(errors.false_positives); }
  double false_negatives() const { return per_sample(errors.false_negatives); }
};

/// A method, made and named.
struct Contestant {
  std::string name;
  Origin origin = Origin::kStudy;
  std::optional<Promise> promise;
  std::unique_ptr<Method> method;
  double build_seconds = 0.0;

  /// Times `make()`, which returns the method or fails.
  template <class Make>
  static core::Expected<Contestant> create(const std::string& name, Origin origin, std::optional<Promise> promise,
                                           const Make& make) {
    const double start = bench::milliseconds();
    core::Expected<std::unique_ptr<Method>> made = make();
    if (!made) return tl::unexpected(made.error());
    return Contestant{name, origin, promise, std::move(*made), 1e-3 * (bench::milliseconds() - start)};
  }
};

/// Flies the path `passes` times (>= 1) with all of them in turn, so that what else the machine does meanwhile falls
/// on all. Errors are those of the first pass.
std::vector<Run> measure(const Path& path, std::span<const Contestant> contestants, int passes);

}  // namespace sightline::study
