// Which variants are run on a model, and what came of it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sightline/study/measure.h"
#include "sightline/study/variant.h"

namespace sightline::study {

/// On a binary tree as S2 has it, a leaf being visible as a whole.
Variant on_tree(TreeKind tree, Traversal traversal = Traversal::kCompact);
/// Bits: plane-coherency, octant, masking, motion, pre-test.
Variant with_flags(Variant v, unsigned flags);

struct Results {
  const Model* model = nullptr;
  std::vector<Run> runs;                 ///< production second to last, brute force last
  TreeKind best_tree = TreeKind::kMean;  ///< the faster of mean and median
  std::string best_flags;                ///< fastest of all combinations of flags on it
  double production_seconds = 0.0;       ///< to build

  const Run* find(const std::string& variant) const;  ///< null when it was not run
  const Run* find(const Variant& v) const { return find(name(v)); }
  const Run& brute_force() const { return runs.back(); }
};

/// All that the tables and figures of S2 need, and more: tests without and with trees, three trees and walks, every
/// combination of flags, limited depths, threads, production and brute force. Borrows the prepared model. `progress` is
/// told the name of each variant before it runs.
Results run_everything(const Model& model, int passes, const std::function<void(const std::string&)>& progress);

}  // namespace sightline::study
