// Which variants are run on a model, and what came of it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sightline/study/measure.h"
#include "sightline/study/variant.h"

namespace sightline::study {

/// On a binary tree as E. T. Carlos has it ("Frustum Culling Híbrido Utilizando CPU e GPU", 2009),
/// a leaf being visible as a whole.
Variant on_tree(TreeKind tree, Traversal traversal = Traversal::kCompact);
/// Bits: plane-coherency, octant, masking, motion, pre-test.
Variant with_flags(Variant v, unsigned flags);

struct Results {
  const Model* model = nullptr;
  const Path* path = nullptr;
  std::vector<Variant> variants;         ///< of the first runs, in order
  std::vector<Run> runs;                 ///< variants, production's forms, peers, brute force last
  TreeKind best_tree = TreeKind::kMean;  ///< the faster of mean and median
  std::string best_flags;                ///< fastest of all combinations of flags on it

  const Run* find(const std::string& variant) const;  ///< null when it was not run
  const Run* find(const Variant& v) const { return find(name(v)); }
  const Run* production() const { return find("production"); }
  const Run& brute_force() const { return runs.back(); }
  /// The fastest variant of the study, on one thread, that keeps every box that meets the frustum and no box that the
  /// p-vertex test drops but for rounding; null when none was run.
  const Run* fastest_exact() const;
};

struct SessionOptions {
  int passes = 3;
  std::vector<std::string> variants;                                             ///< these alone, by name; empty: all
  std::function<void(const std::string&)> progress = [](const std::string&) {};  ///< told each name before it runs
};

/// On the model's first path, all that the tables and figures of the 2009 dissertation need, and more: tests without
/// and with trees, three trees and walks, every combination of flags, limited depths, threads, production, peers and
/// brute force. Borrows the prepared model.
Results run_everything(const Model& model, const SessionOptions& options);
/// On another path: the `count` fastest exact variants of `first`, production, peers and brute force.
Results run_contenders(const Results& first, const Path& path, std::size_t count, const SessionOptions& options);

}  // namespace sightline::study
