// What a commit changed in a scene, and how several consumers of one scene each receive all of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/conventions.h"

namespace sightline::core {

/// What a commit touched, each item and material at most once and in rising order: `changed` items were moved, hidden,
/// shown, re-layered or given another material or mesh. Removals come first: an item that is removed and inserted is
/// another one with the id of the former (Scene::reuse_ids).
struct SIGHTLINE_API SceneDelta {
  std::vector<ItemId> inserted, changed, removed;
  std::vector<std::uint32_t> materials;  ///< indices of those added, updated or removed
  std::size_t size() const { return inserted.size() + changed.size() + removed.size() + materials.size(); }
  bool empty() const { return size() == 0; }
  /// Merges `later` into this delta. An item that was inserted here and is removed in `later` appears nowhere.
  void append(const SceneDelta& later);
};

/// Receives what all commits of a scene publish, for one of several consumers, no matter who commits. Move-only. May
/// outlive the scene; then nothing more arrives.
class SIGHTLINE_API SceneSubscription {
 public:
  SceneSubscription() = default;  ///< to nothing
  SceneSubscription(SceneSubscription&&) = default;
  SceneSubscription& operator=(SceneSubscription&&) = default;

  /// Everything published since the last call, as one delta. Read the items before the scene is edited again. Tells the
  /// scene that what the last call returned is followed.
  SceneDelta take();

 private:
  friend class Scene;
  /// Deltas not yet taken, oldest first. Each is more than twice as large as the next. So the backlog of a consumer
  /// that never calls take() stays within a few words per item, and the cost per edit grows with the logarithm of the
  /// backlog.
  struct Inbox {
    explicit Inbox(std::uint64_t commit) : newest(commit), taken(commit), followed(commit) {}
    std::vector<SceneDelta> deltas;
    std::uint64_t newest, taken, followed;  // commits that were published, taken, and surely read
    void merge_last();
    void push(const SceneDelta& delta, std::uint64_t commit);
  };
  std::shared_ptr<Inbox> inbox_;
};

}  // namespace sightline::core
