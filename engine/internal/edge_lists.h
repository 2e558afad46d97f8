// The edges of a frame's items, for who draws them. Internal to engine.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/thread_pool.h"
#include "sightline/core/view.h"
#include "sightline/engine/looks.h"
#include "sightline/render/internal/edge_lines.h"

namespace sightline::engine {

/// Keeps the edges of all meshes that were ever listed and still exist.
class EdgeLists {
 public:
  /// Lists the lines of items in slots that are not vacant, which are fainter where they would cover most of the item.
  /// `height`: of the image, pixels. The result does not depend on the threads.
  void update(const core::Snapshot& snapshot, std::span<const core::Slot> slots, const core::View& view, int height,
              const Edges& edges, core::ThreadPool& threads);

  /// The segments of all meshes, one behind another. Unless they were begun anew, those of the last call are the first.
  const std::vector<render::EdgeSegment>& segments() const { return segments_; }
  /// Another number once segments() were begun anew.
  std::uint32_t generation() const { return generation_; }
  const std::vector<render::MeshLines>& meshes() const { return meshes_; }
  const std::vector<render::CurvedLine>& curves() const { return curves_; }  ///< sorted by their parts

 private:
  struct OfMesh {
    std::weak_ptr<const core::Mesh> mesh;
    std::uint32_t first = 0, count = 0;  // of the segments
    double length = 0.0;                 // of all of them, in the mesh's coordinates
  };
  class Sizes;
  void forget_gone(EdgeChoice which);
  void add_meshes(const core::Snapshot& snapshot, std::span<const core::Slot> slots, core::ThreadPool& threads);
  void list_mesh(const core::Snapshot& snapshot, core::Slot slot, const Sizes& sizes);
  void list_primitive(const core::Snapshot& snapshot, core::Slot slot, const Sizes& sizes);

  EdgeChoice which_ = EdgeChoice::kOff;  // what known_ has of meshes
  std::uint32_t generation_ = 0;
  std::unordered_map<const core::Mesh*, OfMesh> known_;
  std::vector<render::EdgeSegment> segments_;
  std::vector<render::MeshLines> meshes_;
  std::vector<render::CurvedLine> curves_;
};

}  // namespace sightline::engine
