// The sixteen traversals of A. L. dos Santos, "Estruturas de Aceleração para Ray Tracing em Tempo Real: um Estudo
// Comparativo" (2011), behind one interface.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "sightline/apps/study/rays/bih.h"
#include "sightline/apps/study/rays/bvh.h"
#include "sightline/apps/study/rays/kd_tree.h"
#include "sightline/apps/study/rays/octree.h"
#include "sightline/apps/study/rays/query.h"
#include "sightline/apps/study/rays/sparse_box_grid.h"
#include "sightline/apps/study/rays/triangle_set.h"
#include "sightline/apps/study/rays/uniform_grid.h"

namespace sightline::study::rays {

enum class Structure : std::uint8_t { kOctree, kGrid, kKdTree, kKdTreeWithParents, kKdTreeWithRopes, kBvh, kBih, kSbg };
inline constexpr std::size_t kStructures = 8;
const char* name_of(Structure structure);

/// All structures of a set of triangles, which they borrow.
struct Structures {
  explicit Structures(const TriangleSet& set);
  Structures(const Structures&) = delete;  // some structures borrow others
  Structures& operator=(const Structures&) = delete;

  std::size_t bytes(Structure structure) const;  ///< without the triangles

  const TriangleSet& triangles;
  /// Processor time, by structure. Of kd-trees with more than nodes, together with the bare tree.
  std::array<double, kStructures> build_seconds{};
  Octree octree;
  UniformGrid grid;
  KdTree kd;
  KdTreeWithParents kd_parents;
  KdTreeWithRopes kd_ropes;
  Bvh bvh;
  Bih bih;
  SparseBoxGrid sbg;

 private:
  Structures(const TriangleSet& set, const std::vector<core::Aabb>& boxes, const core::Aabb& bounds);
  template <class Build>
  auto timed(Structure structure, const Build& build);
};

/// Any thread may call these at any time. A ray finds the same hit by all of them, and by brute force: the same
/// parameter bit for bit, and of equal parameters the lowest triangle.
struct Traversal {
  const char* name;
  Structure structure;
  Hit (*nearest)(const Structures& structures, const Ray& ray);
  bool (*any)(const Structures& structures, const Ray& ray);
  /// nearest(), and adds to the counters.
  Hit (*count)(const Structures& structures, const Ray& ray, Counters& counters);
};

/// All sixteen, in the dissertation's order.
std::span<const Traversal> traversals();

}  // namespace sightline::study::rays
