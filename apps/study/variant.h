// The techniques of CPU culling that can be combined, and the promise of each combination.
#pragma once

#include <cstdint>
#include <string>

namespace sightline::study {

enum class TreeKind : std::uint8_t { kNone, kMean, kMedian };
/// kStack: nodes with pointers and a stack on the heap. kStackless: the same nodes by escape index. kCompact: nodes of
/// 48 bytes without pointers, by escape index.
enum class Traversal : std::uint8_t { kStack, kStackless, kCompact };
enum class Test : std::uint8_t { kCorners, kVertices, kSplit, kRadar, kRadarTwoAnswers };
/// kStatic: subtrees of one level handed out in advance. kTasks: OpenMP tasks. kRing: lock-free ring buffers between
/// the threads.
enum class Threads : std::uint8_t { kOne, kStatic, kTasks, kRing };

/// Bits of Variant::flags: the dissertation's five optimisations.
enum Flag : unsigned {
  kPlaneCoherency = 1,  ///< the plane that rejected a box last time comes first
  kOctant = 2,          ///< small boxes meet only the three planes next to their centre
  kMasking = 4,         ///< planes that a node lies inside of are not tested below it
  kMotion = 8,          ///< translation/rotation coherency: still outside if the camera moved little
  kPreTest = 16,        ///< box of the frustum first
};
inline constexpr unsigned kAllFlags = 31;

struct Variant {
  TreeKind tree = TreeKind::kNone;
  Traversal traversal = Traversal::kCompact;
  Test test = Test::kVertices;
  bool simd = false;  ///< one register packed for each distance; for Test::kSplit four planes at a time
  unsigned flags = 0;
  bool test_items = true;  ///< items of a leaf on their own; otherwise a leaf is visible as a whole
  Threads threads = Threads::kOne;
  int thread_count = 1;

  bool has(Flag flag) const { return (flags & flag) != 0; }
  friend bool operator==(const Variant&, const Variant&) = default;
};

/// How the answer relates to the boxes whose p-vertex no plane rejects in exact arithmetic.
enum class Promise : std::uint8_t {
  kSame,          ///< that set, plus boxes within rounding errors (some 1e-6 of the largest coordinate) of a plane
  kConservative,  ///< a superset
  kTighter,       ///< contains every box that meets the frustum, but not every box of that set
  kErrs,          ///< loses visible boxes, too
};

/// False for combinations without meaning: flags that a test cannot use, threads without a compact tree, and so on.
bool valid(const Variant& v);
Promise promise(const Variant& v);
const char* name(Promise p);
/// Short and unique, such as "mean compact vertices +coherency +octant".
std::string name(const Variant& v);

}  // namespace sightline::study
