#include "sightline/lod/internal/loose_parts.h"

#include <algorithm>
#include <limits>

#include "sightline/core/aabb.h"
#include "sightline/core/internal/disjoint_sets.h"

namespace sightline::lod {
namespace {

using core::kNone;
using core::vec3;

constexpr std::size_t kMostParts = 256;  // each is compared with each

struct LoosePart {
  core::Aabb box;
  std::size_t triangles = 0;
  bool stays = false, gone = false;
};

struct LooseParts {
  std::vector<LoosePart> list;
  std::vector<std::uint32_t> of;  // by triangle
};

/// None where all is one part.
LooseParts find_parts(std::span<const vec3> positions, std::span<const std::uint32_t> corners,
                      std::span<const std::uint8_t> locked) {
  core::DisjointSets sets(positions.size());
  for (std::size_t i = 0; i < corners.size(); i += 3)
    sets.merge(corners[i], corners[i + 1]), sets.merge(corners[i], corners[i + 2]);
  LooseParts parts;
  const auto is_first = [&](std::uint32_t corner) { return sets.find(corner) == sets.find(corners[0]); };
  if (std::ranges::all_of(corners, is_first)) return parts;  // as most surfaces are
  std::vector<std::uint32_t> number(positions.size(), kNone);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    std::uint32_t& part = number[sets.find(corners[i])];
    if (part == kNone) part = std::uint32_t(parts.list.size()), parts.list.emplace_back();
    LoosePart& at = parts.list[part];
    at.box.grow({positions[corners[i]], positions[corners[i]]});
    at.stays |= locked[corners[i]] != 0;
    if (i % 3 == 0) parts.of.push_back(part), ++at.triangles;
  }
  return parts;
}

/// How far corners of a box lie from those of another one, at most: about how far the parts in them are apart.
float apart(const core::Aabb& a, const core::Aabb& b) {
  return std::max(glm::length(a.min - b.min), glm::length(a.max - b.max));
}

struct NearPart {
  float distance = std::numeric_limits<float>::infinity();
  std::uint32_t part = kNone;
};

NearPart nearest_left(const std::vector<LoosePart>& parts, std::uint32_t part) {
  NearPart nearest;
  for (std::uint32_t i = 0; i < parts.size(); ++i) {
    if (i == part || parts[i].gone) continue;
    const float distance = apart(parts[i].box, parts[part].box);
    if (distance < nearest.distance) nearest = {distance, i};
  }
  return nearest;
}

}  // namespace

std::vector<std::uint32_t> without_loose_parts(std::span<const vec3> positions, std::span<const std::uint32_t> corners,
                                               std::span<const std::uint8_t> locked, std::size_t target) {
  LooseParts parts = find_parts(positions, corners, locked);
  if (parts.list.size() < 2 || parts.list.size() > kMostParts) return {};
  std::vector<NearPart> loose;  // each part that may go, and how near another one is
  for (std::uint32_t i = 0; i < parts.list.size(); ++i)
    if (!parts.list[i].stays) loose.push_back({nearest_left(parts.list, i).distance, i});
  const std::size_t all = corners.size() / 3;
  std::size_t left = all;
  while (!loose.empty()) {
    std::ranges::sort(loose, [](const NearPart& a, const NearPart& b) {
      return a.distance != b.distance ? a.distance < b.distance : a.part < b.part;
    });
    std::vector<NearPart> later;  // whose nearest part has gone
    for (const NearPart& next : loose) {
      LoosePart& part = parts.list[next.part];
      if (left <= target || part.stays) continue;
      const NearPart nearest = nearest_left(parts.list, next.part);
      if (nearest.distance > next.distance) {
        if (nearest.part != kNone) later.push_back({nearest.distance, next.part});
        continue;
      }
      part.gone = true;
      parts.list[nearest.part].stays = true;
      left -= part.triangles;
    }
    loose = std::move(later);
  }
  std::vector<std::uint32_t> kept;
  if (left == all) return kept;
  for (std::size_t t = 0; t < all; ++t)
    if (!parts.list[parts.of[t]].gone)
      kept.insert(kept.end(), corners.begin() + std::ptrdiff_t(3 * t), corners.begin() + std::ptrdiff_t(3 * t) + 3);
  return kept;
}

}  // namespace sightline::lod
