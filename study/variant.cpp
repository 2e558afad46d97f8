#include "sightline/study/variant.h"

#include <array>

namespace sightline::study {
namespace {

constexpr std::array<const char*, 4> kTrees{"no tree", "mean", "median", "SAH"};
constexpr std::array<const char*, 3> kTraversals{"stack", "stackless", "compact"};
constexpr std::array<const char*, 7> kTests{"corners",           "vertices",       "split", "radar",
                                            "radar-two-answers", "radar-by-limit", "sphere"};
constexpr std::array<const char*, 4> kThreads{"", " static", " tasks", " ring"};

bool is_radar(Test t) {
  return t == Test::kRadar || t == Test::kRadarTwoAnswers || t == Test::kRadarByLimit;
}

}  // namespace

bool valid(const Variant& v) {
  const bool any_flag = v.plane_coherency || v.octant || v.masking || v.motion || v.pre_test;
  if (v.thread_count < 1 || (v.threads == Threads::kOne && v.thread_count != 1)) return false;
  if (v.threads != Threads::kOne && (v.tree == TreeKind::kNone || v.traversal != Traversal::kCompact)) return false;
  if (v.tree == TreeKind::kNone &&
      (v.masking || !v.test_items || v.max_depth != 0xff || v.traversal != Traversal::kCompact))
    return false;
  if (v.test == Test::kRadarTwoAnswers && v.tree != TreeKind::kNone) return false;
  if (is_radar(v.test) && (v.plane_coherency || v.octant || v.masking || v.motion || v.simd != Simd::kNone))
    return false;
  if (v.test == Test::kSplit && (v.plane_coherency || v.octant)) return false;
  if (v.test == Test::kSphere && v.simd != Simd::kNone) return false;
  if (v.simd == Simd::kOverBoxes && (v.tree != TreeKind::kNone || v.test != Test::kVertices || any_flag)) return false;
  return true;
}

Promise promise(const Variant& v) {
  if (v.test == Test::kRadar || v.test == Test::kRadarTwoAnswers) return Promise::kErrs;
  if (v.pre_test) return Promise::kTighter;
  if (v.test == Test::kSphere || v.octant || !v.test_items || v.max_depth != 0xff) return Promise::kConservative;
  return Promise::kSame;
}

const char* name(Promise p) {
  constexpr std::array<const char*, 4> kNames{"same", "conservative", "tighter", "errs"};
  return kNames[std::size_t(p)];
}

std::string name(const Variant& v) {
  std::string s = kTrees[std::size_t(v.tree)];
  if (v.tree != TreeKind::kNone) s += std::string(" ") + kTraversals[std::size_t(v.traversal)];
  s += std::string(" ") + kTests[std::size_t(v.test)];
  if (v.simd == Simd::kPerTest) s += " simd-per-test";
  if (v.simd == Simd::kOverBoxes) s += " simd-over-boxes";
  if (v.plane_coherency) s += " +coherency";
  if (v.octant) s += " +octant";
  if (v.masking) s += " +masking";
  if (v.motion) s += " +motion";
  if (v.pre_test) s += " +pre-test";
  if (!v.test_items) s += " whole-leaves";
  if (v.max_depth != 0xff) s += " depth<=" + std::to_string(v.max_depth);
  s += kThreads[std::size_t(v.threads)];
  if (v.threads != Threads::kOne) s += " x" + std::to_string(v.thread_count);
  return s;
}

}  // namespace sightline::study
