// Made-up triangle meshes of any size, where no scanned model is at hand.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sightline/core/conventions.h"

namespace sightline::study::rays {

struct GeneratedMesh {
  std::vector<core::vec3> positions;
  std::vector<std::uint32_t> indices;
};

/// A closed surface like a scan's: a sphere with bumps of many sizes, its triangles of about one size. Their number is
/// the nearest to `triangles` that the construction has, 12 n².
GeneratedMesh make_scan(std::size_t triangles);

/// A hundred scans, the largest thirty times the smallest, scattered over a ground of two triangles: mostly empty space
/// with dense places.
GeneratedMesh make_scattered(std::size_t triangles);

}  // namespace sightline::study::rays
