#include "sightline/apps/study/variant.h"

#include <array>

namespace sightline::study {
namespace {

constexpr std::array<const char*, 3> kTrees{"no tree", "mean", "median"};
constexpr std::array<const char*, 3> kTraversals{"stack", "stackless", "compact"};
constexpr std::array<const char*, 5> kTests{"corners", "vertices", "split", "radar", "radar-two-answers"};
constexpr std::array<const char*, 5> kFlags{" +coherency", " +octant", " +masking", " +motion", " +pre-test"};
constexpr std::array<const char*, 4> kThreads{"", " static", " tasks", " ring"};

bool is_radar(Test t) {
  return t == Test::kRadar || t == Test::kRadarTwoAnswers;
}

}  // namespace

bool valid(const Variant& v) {
  const bool has_tree = v.tree != TreeKind::kNone;
  if (v.thread_count < 1 || (v.threads == Threads::kOne && v.thread_count != 1)) return false;
  if (v.threads != Threads::kOne && (!has_tree || v.traversal != Traversal::kCompact)) return false;
  if (!has_tree && (v.has(kMasking) || !v.test_items || v.traversal != Traversal::kCompact)) return false;
  if (v.test == Test::kRadarTwoAnswers && has_tree) return false;
  if (is_radar(v.test) && ((v.flags & ~kPreTest) != 0 || v.simd)) return false;
  return v.test != Test::kSplit || !(v.has(kPlaneCoherency) || v.has(kOctant));
}

Promise promise(const Variant& v) {
  if (is_radar(v.test)) return Promise::kErrs;
  if (v.has(kPreTest)) return Promise::kTighter;
  return v.has(kOctant) || !v.test_items ? Promise::kConservative : Promise::kSame;
}

const char* name(Promise p) {
  constexpr std::array<const char*, 4> kNames{"same", "conservative", "tighter", "errs"};
  return kNames[std::size_t(p)];
}

std::string name(const Variant& v) {
  std::string s = kTrees[std::size_t(v.tree)];
  if (v.tree != TreeKind::kNone) s += std::string(" ") + kTraversals[std::size_t(v.traversal)];
  s += std::string(" ") + kTests[std::size_t(v.test)];
  if (v.simd) s += " simd-per-test";
  for (std::size_t i = 0; i < kFlags.size(); ++i)
    if ((v.flags >> i & 1u) != 0) s += kFlags[i];
  if (!v.test_items) s += " whole-leaves";
  s += kThreads[std::size_t(v.threads)];
  if (v.threads != Threads::kOne) s += " x" + std::to_string(v.thread_count);
  return s;
}

}  // namespace sightline::study
