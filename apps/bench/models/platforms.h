// The five models of the 2009 dissertation (E. T. Carlos, "Frustum Culling Híbrido Utilizando CPU e GPU"), tables 3.1
// and 3.2, as far as numbers go.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sightline/core/primitive.h"

namespace sightline::bench {

/// Places of Platform::counts.
enum Mix : std::uint8_t { kCylinders, kCones, kTori, kMeshes };
/// kMeshes: any other kind.
Mix mix_of(core::Kind kind);

struct Platform {
  const char* name;
  std::array<std::uint64_t, 4> counts;  ///< cylinders, cones, torus slices (table 3.1), meshes (3.2)
  std::uint64_t printed;                ///< the number of objects that table 3.2 has
  double seconds;                       ///< of its path (figure 3.17)
  constexpr std::uint64_t primitives() const { return counts[kCylinders] + counts[kCones] + counts[kTori]; }
  constexpr std::uint64_t objects() const { return primitives() + counts[kMeshes]; }
};

/// P-43: 280,123 objects are printed, the number of its cylinders.
inline constexpr Platform kPlatforms[] = {{"P-38", {81374, 3917, 0, 53578}, 138869, 80},
                                          {"P-40", {221933, 3814, 39586, 82}, 265415, 87},
                                          {"P-43", {280123, 13212, 0, 699521}, 280123, 72},
                                          {"P-50", {336591, 14192, 341168, 21484}, 713435, 92}};
inline constexpr double kAircraftSeconds = 73;

/// The number of items that a share of a model has: at least 1000.
std::uint64_t scaled(std::uint64_t objects, double scale);

/// Changes as few kinds (of type Mix) as it takes to have them in the platform's proportions, to
/// the item; those to be changed are spread evenly over the sequence. A box keeps its place and size: an elbow that is
/// given as a mesh lies where the elbow would.
void mix_kinds(const Platform& platform, std::vector<std::uint8_t>& kinds);

}  // namespace sightline::bench
