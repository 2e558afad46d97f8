#include "sightline/apps/study/rays/traversals.h"

#include <ctime>

#include "sightline/apps/study/rays/kd_traversals.h"

namespace sightline::study::rays {
namespace {

struct Answer {
  Hit hit;
  Counters counters;
};

template <class Walk, auto member, Find find, bool counting>
Answer search(const Structures& structures, const Ray& ray) {
  const UnitRay unit(structures.triangles.space(), ray);
  if (unit.misses()) return {};
  Query<find, counting> query(structures.triangles, ray, unit);
  Walk::walk(structures.*member, unit, query);
  return {query.hit(), query.counters()};
}

template <class Walk, auto member>
constexpr Traversal traversal(const char* name, Structure structure) {
  return {name, structure,
          [](const Structures& s, const Ray& ray) { return search<Walk, member, Find::kNearest, false>(s, ray).hit; },
          [](const Structures& s, const Ray& ray) { return bool(search<Walk, member, Find::kAny, false>(s, ray).hit); },
          [](const Structures& s, const Ray& ray, Counters& counters) {
            const Answer answer = search<Walk, member, Find::kNearest, true>(s, ray);
            counters.nodes += answer.counters.nodes;
            counters.triangles += answer.counters.triangles;
            return answer.hit;
          }};
}

constexpr std::array kTraversals = {
    traversal<OctreeRevelles, &Structures::octree>("octree", Structure::kOctree),
    traversal<GridDda, &Structures::grid>("grid 3D-DDA", Structure::kGrid),
    traversal<KdSequential, &Structures::kd_ropes>("kd sequential", Structure::kKdTreeWithRopes),
    traversal<KdStandard<false>, &Structures::kd>("kd standard", Structure::kKdTree),
    traversal<KdHavran, &Structures::kd>("kd Havran", Structure::kKdTree),
    traversal<KdRestart, &Structures::kd>("kd restart", Structure::kKdTree),
    traversal<KdBacktrack, &Structures::kd_parents>("kd backtrack", Structure::kKdTreeWithParents),
    traversal<KdPushDown, &Structures::kd>("kd push-down", Structure::kKdTree),
    traversal<KdShortStack<false>, &Structures::kd>("kd short-stack", Structure::kKdTree),
    traversal<KdShortStack<true>, &Structures::kd>("kd PD & SS", Structure::kKdTree),
    traversal<KdRopes<true>, &Structures::kd_ropes>("kd ropes", Structure::kKdTreeWithRopes),
    traversal<KdRopes<false>, &Structures::kd_ropes>("kd ropes++", Structure::kKdTreeWithRopes),
    traversal<KdStandard<true>, &Structures::kd>("kd 8-byte standard", Structure::kKdTree),
    traversal<BvhStack, &Structures::bvh>("BVH", Structure::kBvh),
    traversal<BihStack, &Structures::bih>("BIH", Structure::kBih),
    traversal<SbgWalk, &Structures::sbg>("SBG", Structure::kSbg),
};

/// Builders need some bounds; no ray meets an empty set.
core::Aabb bounds_or_unit_cube(const core::Aabb& bounds) {
  return bounds.empty() ? core::Aabb{core::vec3(0.0f), core::vec3(1.0f)} : bounds;
}

}  // namespace

const char* name_of(Structure structure) {
  constexpr std::array<const char*, kStructures> kNames = {
      "octree", "grid", "kd-tree", "kd-tree with parents", "kd-tree with ropes", "BVH", "BIH", "SBG"};
  return kNames[std::size_t(structure)];
}

template <class Build>
auto Structures::timed(Structure structure, const Build& build) {
  const std::clock_t start = std::clock();
  auto made = build();
  build_seconds[std::size_t(structure)] = double(std::clock() - start) / CLOCKS_PER_SEC;
  return made;
}

Structures::Structures(const TriangleSet& set)
    : Structures(set, set.boxes(), bounds_or_unit_cube(set.space().bounds)) {}

Structures::Structures(const TriangleSet& set, const std::vector<core::Aabb>& boxes, const core::Aabb& bounds)
    : triangles(set),
      octree(timed(Structure::kOctree, [&] { return build_octree(boxes, bounds); })),
      grid(timed(Structure::kGrid, [&] { return build_grid(boxes, bounds, automatic_resolution(boxes, bounds)); })),
      kd(timed(Structure::kKdTree, [&] { return build_kd_tree(boxes, bounds); })),
      kd_parents(timed(Structure::kKdTreeWithParents, [&] { return KdTreeWithParents(kd); })),
      kd_ropes(timed(Structure::kKdTreeWithRopes, [&] { return KdTreeWithRopes(kd); })),
      bvh(timed(Structure::kBvh, [&] { return build_bvh(boxes); })),
      bih(timed(Structure::kBih, [&] { return build_bih(boxes, bounds); })),
      sbg(timed(Structure::kSbg, [&] { return build_sbg(boxes, bounds); })) {
  const double bare = build_seconds[std::size_t(Structure::kKdTree)];
  build_seconds[std::size_t(Structure::kKdTreeWithParents)] += bare;
  build_seconds[std::size_t(Structure::kKdTreeWithRopes)] += bare;
}

std::size_t Structures::bytes(Structure structure) const {
  const std::array<std::size_t, kStructures> bytes_of{octree.bytes(),   grid.bytes(), kd.bytes(),  kd_parents.bytes(),
                                                      kd_ropes.bytes(), bvh.bytes(),  bih.bytes(), sbg.bytes()};
  return bytes_of[std::size_t(structure)];
}

std::span<const Traversal> traversals() {
  return kTraversals;
}

}  // namespace sightline::study::rays
