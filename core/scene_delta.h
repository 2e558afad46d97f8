// What a commit changed in a scene, and how several consumers of one scene each receive all of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "sightline/core/conventions.h"

namespace sightline::core {

/// What a commit touched, each item and material at most once and in rising order: `changed` items were moved, hidden,
/// shown, re-layered or given another material; removed ids are gone for good.
struct SceneDelta {
  std::vector<ItemId> inserted, changed, removed;
  std::vector<std::uint32_t> materials;  ///< indices of those added, updated or removed
  std::size_t size() const { return inserted.size() + changed.size() + removed.size() + materials.size(); }
  bool empty() const { return size() == 0; }
  /// Makes this one delta of both. What was inserted here and is removed in `later` never was.
  void append(const SceneDelta& later);
};

/// What commits publish, for one consumer among others, whoever commits. Move-only; may outlive the scene, and then
/// nothing more comes.
class SceneSubscription {
 public:
  SceneSubscription() = default;  ///< to nothing
  SceneSubscription(SceneSubscription&&) = default;
  SceneSubscription& operator=(SceneSubscription&&) = default;

  /// All that was published since the last call, as one delta. Read the items before the scene is edited again.
  SceneDelta take();

 private:
  friend class Scene;
  /// Deltas not yet taken, oldest first, each more than twice as large as the next: what waits for a consumer that
  /// never asks stays within a few words for each item, at a cost for each edit that grows with its logarithm.
  struct Inbox {
    std::vector<SceneDelta> deltas;
    void merge_last();
    void push(const SceneDelta& delta);
  };
  std::shared_ptr<Inbox> inbox_;
};

}  // namespace sightline::core
