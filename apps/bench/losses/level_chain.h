// The peer of levels of detail with a proven error: each mesh whole, by one of a chain of halvings, as most engines
// have them. Each halving simplifies the one before with meshoptimizer, and its error is the sum of meshoptimizer's
// estimates so far. Internal to sightline-bench contribution and lod.
#pragma once

#include <vector>

#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/lod/internal/cut.h"

namespace sightline::bench {

class LevelChain {
 public:
  /// Builds the chains of all meshes of a scene. About 1 us a triangle. None in builds without meshoptimizer.
  explicit LevelChain(const core::Scene& scene);

  /// The items of the model, and beside each with a mesh one for each level, in the same place. Committed.
  core::Scene& scene() { return scene_; }
  /// The model alone, to be culled.
  const core::Snapshot& model() const { return model_; }
  /// By id of scene(): the model's item.
  const std::vector<core::ItemId>& originals() const { return originals_; }

  /// Replaces `chosen` by slots of `drawn`, a snapshot of scene(): of each item of `visible`, slots of model(), the
  /// coarsest level whose estimated error the image may show, wherever in the mesh's box it lies. Sorted.
  void choose(const lod::ImageError& image, const core::VisibleSet& visible, const core::Snapshot& drawn,
              core::VisibleSet& chosen) const;

 private:
  struct Level {
    core::MeshId mesh;
    float error;  // metres of the mesh's own coordinates
  };
  struct Chain {
    core::Aabb box;
    std::vector<Level> levels;  // from fine to coarse, without the mesh itself
  };
  Chain make_chain(const core::Mesh& mesh);

  core::Scene scene_;
  core::Snapshot model_;
  std::vector<Chain> chains_;              // by mesh index of the model
  std::vector<std::uint32_t> chain_of_;    // by item of the model; kNone: none
  std::vector<core::ItemId> first_level_;  // by item of the model: its first level's item, which the others follow
  std::vector<core::ItemId> originals_;
};

}  // namespace sightline::bench
