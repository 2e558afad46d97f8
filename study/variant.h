// What can be combined.
#pragma once

#include <cstdint>
#include <string>

namespace sightline::study {

enum class TreeKind : std::uint8_t { kNone, kMean, kMedian, kSah };
/// kStack: nodes with pointers and a stack on the heap. kStackless: the same nodes by escape index. kCompact: nodes of
/// 48 bytes without pointers, by escape index.
enum class Traversal : std::uint8_t { kStack, kStackless, kCompact };
enum class Test : std::uint8_t { kCorners, kVertices, kSplit, kRadar, kRadarTwoAnswers, kRadarByLimit, kSphere };
/// kPerTest: one register packed for each distance (for kSplit: four planes at a time). kOverBoxes: four boxes at a
/// time from a structure of arrays.
enum class Simd : std::uint8_t { kNone, kPerTest, kOverBoxes };
/// kStatic: subtrees of one level handed out in advance. kTasks: OpenMP tasks. kRing: lock-free ring buffers between
/// the threads.
enum class Threads : std::uint8_t { kOne, kStatic, kTasks, kRing };

struct Variant {
  TreeKind tree = TreeKind::kNone;
  Traversal traversal = Traversal::kCompact;
  Test test = Test::kVertices;
  Simd simd = Simd::kNone;
  bool plane_coherency = false;    ///< the plane that rejected a box last time comes first
  bool octant = false;             ///< small boxes meet only the three planes next to their centre
  bool masking = false;            ///< planes that a node lies inside of are not tested below it
  bool motion = false;             ///< translation/rotation coherency: still outside if the camera moved little
  bool pre_test = false;           ///< box of the frustum first
  bool test_items = true;          ///< items of a leaf on their own; otherwise a leaf is visible as a whole
  std::uint32_t max_depth = 0xff;  ///< levels below which everything counts as visible
  Threads threads = Threads::kOne;
  int thread_count = 1;
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
