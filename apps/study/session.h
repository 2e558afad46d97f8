// Which variants are run on a model, and what came of it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sightline/apps/study/measure.h"
#include "sightline/apps/study/variant.h"

namespace sightline::study {

inline constexpr const char *kProduction = "production", *kProductionIds = "production ids";

/// On a binary tree as E. T. Carlos has it ("Frustum Culling Híbrido Utilizando CPU e GPU", 2009),
/// a leaf being visible as a whole.
Variant on_tree(TreeKind tree, unsigned flags = 0, Traversal traversal = Traversal::kCompact);

struct Results {
  const Model* model = nullptr;
  std::vector<Variant> variants;         ///< of the first runs, in order
  std::vector<Run> runs;                 ///< variants, production, brute force last
  TreeKind best_tree = TreeKind::kMean;  ///< the faster of mean and median
  std::string best_flags;                ///< fastest of all combinations of flags on it

  const Run* find(const std::string& variant) const;  ///< null when it was not run
  const Run* find(const Variant& v) const { return find(name(v)); }
  /// The fastest variant of the study, on one thread, that keeps every box that meets the frustum and no box that the
  /// p-vertex test drops but for rounding; null when none was run.
  const Run* fastest_exact() const;
};

struct SessionOptions {
  int passes = 3;
  std::vector<std::string> variants;                                             ///< these alone, by name; empty: all
  std::function<void(const std::string&)> progress = [](const std::string&) {};  ///< told each name before it runs

  bool wants(const std::string& name) const;
};

/// All that the tables and figures of the 2009 dissertation need, and more: tests without and with trees, two trees
/// and three walks, every combination of flags, threads, production and brute force. Borrows the prepared model.
Results run_everything(const Model& model, const SessionOptions& options);

}  // namespace sightline::study
