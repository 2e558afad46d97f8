// Uploads an order of the items to the GPU in portions, beside frames that show another one. Internal to engine.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sightline/engine/drawing/internal/gpu_culling.h"

namespace sightline::engine {

/// GPU objects of one order of the items: culler and renderer only where they are needed. One renderer serves all
/// orders.
struct GpuContent {
  std::optional<gpuscene::GpuScene> scene;
  std::optional<gpuscene::DrawLists> lists;  // created once the scene is complete
  std::optional<culling::GpuCuller> culler;
  std::optional<render::Renderer> renderer;

  std::size_t memory_bytes() const;
};

/// Edits that an upload follows: each list in rising order, without repetition.
struct GpuEdits {
  std::vector<core::Slot> touched;
  std::vector<std::uint32_t> materials;
};

class GpuUpload {
 public:
  /// Begins an upload, in place of one that is under way. Edits that follow_later() has noted stay.
  void begin() {
    content_.emplace();
    uploaded_ = false;
    slots_ = 0;
  }
  bool active() const { return content_.has_value(); }
  /// Drops the upload, which is of no use after a failure, and the noted edits.
  void abandon();
  /// Notes an edit of the snapshot for later: touched slots (Snapshot::apply) and materials (SceneDelta::materials).
  void follow_later(std::span<const core::Slot> touched, std::span<const std::uint32_t> materials);
  /// Works until the deadline, but at least a little; true once all is uploaded. Single programs and the GPU culler are
  /// not interrupted.
  core::Expected<bool> advance(const DrawContext& context, GpuCulling& culling, const core::Snapshot& snapshot,
                               const gpuprims::Joints& joints, bool gpu_culls, core::Deadline deadline);
  /// Ends the upload and returns what it has made.
  GpuContent take();
  /// The noted edits that the upload has not followed, which are then no longer noted.
  GpuEdits take_edits();
  std::size_t memory_bytes() const { return content_ ? content_->memory_bytes() : 0; }

 private:
  core::Expected<bool> follow_edits(const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                    core::Deadline deadline);
  core::Expected<void> complete(const DrawContext& context, GpuCulling& culling, const core::Snapshot& snapshot,
                                bool gpu_culls);

  std::optional<GpuContent> content_;
  bool uploaded_ = false;  // the scene is uploaded as it was when the upload began
  core::Slot slots_ = 0;   // of the snapshot, when follow_edits() last looked
  GpuEdits edits_;         // in the order in which they came
  std::size_t came_ = 0;   // touched slots that came since follow_edits() last looked
};

}  // namespace sightline::engine
