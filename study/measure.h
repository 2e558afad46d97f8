// Variants along a path: times, counts and errors.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/view.h"
#include "sightline/study/culler.h"
#include "sightline/study/exact.h"
#include "sightline/study/method.h"
#include "sightline/study/tree.h"
#include "sightline/study/variant.h"

namespace sightline::study {

/// A flight, and the exact sets of some of its frames.
struct Path {
  std::string name;
  std::vector<core::View> views;
  double seconds = 60.0;             ///< that it takes
  std::vector<std::size_t> sampled;  ///< frames that errors are counted on
  std::vector<ExactSets> exact;      ///< of those
};

/// A scene, its trees and its paths, of which the first is flown by everything.
struct Model {
  std::string name;
  std::vector<core::Aabb> boxes;
  std::vector<std::uint8_t> kinds;  ///< may be empty
  std::vector<Path> paths;

  Tree mean, median, sah;
  double mean_seconds = 0.0, median_seconds = 0.0, sah_seconds = 0.0;  ///< to build them

  /// Builds trees, and exact sets of `samples` frames of each path.
  void prepare(std::size_t samples);
  const Tree& tree(TreeKind kind) const;
};

enum class Origin : std::uint8_t { kStudy, kProduction, kPeer, kBaseline };

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

  double false_positives() const { return samples == 0 ? 0.0 : double(errors.false_positives) / double(samples); }
  double false_negatives() const { return samples == 0 ? 0.0 : double(errors.false_negatives) / double(samples); }
};

/// Flies the path `passes` times (>= 1). Errors are those of the first pass. Below valgrind --tool=callgrind with
/// --instr-atstart=no --collect-atstart=no, the instructions of the timed calls alone are counted, and dumped with the
/// variant's name.
Run measure(const Model& model, const Path& path, const Variant& variant, int passes);
using MakeMethod = std::function<std::unique_ptr<Method>(std::span<const core::Aabb>)>;
Run measure(const Model& model, const Path& path, const std::string& name, Origin origin, const MakeMethod& make,
            int passes);

/// A method, made and named.
struct Contestant {
  std::string name;
  Origin origin = Origin::kStudy;
  std::unique_ptr<Method> method;
  double build_seconds = 0.0;
};
/// All of them pass by pass in turn, so that what else the machine does meanwhile falls on all.
std::vector<Run> measure(const Path& path, std::span<const Contestant> contestants, int passes);

double median_of(std::vector<double> values);

}  // namespace sightline::study
