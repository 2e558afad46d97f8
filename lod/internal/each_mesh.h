// Work on many meshes with all processors. Internal: for what builds levels.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "sightline/lod/mesh_levels.h"

namespace sightline::lod {

/// Calls work(i, threads) for each mesh i, small meshes side by side with one thread each and then each large one with
/// all (0). Returns when all is done.
template <class Work>
void for_each_mesh(std::span<const core::Mesh* const> meshes, const Work& work) {
  std::vector<std::size_t> order(meshes.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto is_small = [&](std::size_t i) { return !is_large(*meshes[i]); };
  const auto small = std::stable_partition(order.begin(), order.end(), is_small) - order.begin();
#pragma omp parallel for schedule(dynamic)
  for (std::ptrdiff_t k = 0; k < small; ++k) work(order[std::size_t(k)], 1);
  for (std::size_t k = std::size_t(small); k < order.size(); ++k) work(order[k], 0);
}

}  // namespace sightline::lod
