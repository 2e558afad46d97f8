// Copies items of a scene into another one, with the nodes above them.
#pragma once

#include <functional>
#include <span>
#include <unordered_map>
#include <vector>

#include "sightline/core/scene.h"

namespace sightline::apps {

/// Each node, mesh and material is copied once, when it is first needed, so that the copies have the order of the
/// calls. Both scenes must outlive the copier.
class ItemCopier {
 public:
  enum class Materials { kNone, kKept };

  /// Copies of what lies below `top` come to lie below `copy_of_top`.
  ItemCopier(const core::Scene& from, core::NodeId top, core::Scene& to, core::NodeId copy_of_top, Materials materials)
      : from_(from), to_(to), materials_kept_(materials == Materials::kKept), nodes_{{top.index, copy_of_top}} {}

  /// Copies an item below the top. Fails as Scene::add_mesh() does.
  core::Expected<core::ItemId> copy(core::ItemId item);
  /// Without its items.
  core::NodeId copy(core::NodeId node);
  core::Expected<core::MeshId> copy(core::MeshId mesh);
  core::MaterialId copy(core::MaterialId material);
  /// Gives a node all that another one has but its name, children and items.
  void copy_state(core::NodeId from, core::NodeId to);
  std::vector<core::MeshId> meshes() const;  ///< the copies

 private:
  const core::Scene& from_;
  core::Scene& to_;
  bool materials_kept_;
  std::unordered_map<std::uint32_t, core::NodeId> nodes_;  // by index of the original
  std::unordered_map<std::uint32_t, core::MeshId> meshes_;
  std::unordered_map<std::uint32_t, core::MaterialId> materials_;
};

/// A scene that has of another one what lies below some children of its root: all of it, or with `items` (by ItemId)
/// these and the nodes above them. Roots are moved alike. Fails where no item is wanted, and with
/// importers::kCancelled once `progress` has returned false.
core::Expected<core::Scene> copy_of_part(const core::Scene& from, std::span<const core::NodeId> tops,
                                         const std::vector<bool>* items, const std::function<bool(double)>& progress);

}  // namespace sightline::apps
