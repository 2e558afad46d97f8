// Which parts of a model weigh most in its frames, and what can be done about each.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sightline/core/scene.h"

namespace sightline::apps {

struct HeavyPart {
  core::NodeId node;
  std::vector<core::ItemId> items;  ///< below it that are drawn, in rising order
  std::uint64_t triangles = 0;      ///< of their meshes, each as often as it is shown
  std::uint64_t mesh_bytes = 0;     ///< of their meshes, each once
  double weight = 0.0;              ///< 0 to 1: share of the model's
};

/// The heaviest parts, at most `most`: a part that weighs more than a tenth of the model is given by the parts below
/// it, where it has several. The weight is in triangles: those of meshes, and 12 for a primitive, as many as a box has.
/// O(nodes + items).
std::vector<HeavyPart> heavy_parts(const core::Scene& scene, std::size_t most);

/// One sentence on what would make it lighter. `from_surfaces`: its meshes were made of exact surfaces, whose tolerance
/// can be chosen.
std::string advice_for(const core::Scene& scene, const HeavyPart& part, bool from_surfaces);

}  // namespace sightline::apps
