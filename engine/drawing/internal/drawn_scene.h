// The half of a backend with GL that follows the scene: uploads its versions in portions, and its edits. Internal to
// engine.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sightline/engine/drawing/internal/gpu_upload.h"
#include "sightline/engine/drawing/internal/image_overlays.h"
#include "sightline/engine/drawing/internal/unseen_items.h"
#include "sightline/engine/internal/backend.h"

namespace sightline::engine {

/// Owns the context, and what of the scene is in it. Drawing makes images of that.
class DrawnScene : public Backend {
 public:
  /// `own`: null where the context is the application's.
  DrawnScene(std::optional<gl::Context> own, gl::Context shared, const EngineConfig& config,
             const Overrides& overrides);
  bool lost() const override;
  std::unique_ptr<KeptState> keep_state() const override;

  core::Expected<bool> advance(const core::Snapshot& snapshot, const gpuprims::Joints& joints, bool gpu_culls,
                               core::Deadline deadline) override;
  core::Expected<bool> advance_version(const core::Snapshot& snapshot, const gpuprims::Joints& joints, bool gpu_culls,
                                       core::Deadline deadline) override;
  core::Expected<void> take_version(const core::Snapshot& former, const core::Snapshot& snapshot,
                                    const gpuprims::Joints& joints, bool gpu_culls) override;
  void abandon_version() override { upload_.abandon(); }
  core::Expected<void> rebuild(const core::Snapshot& snapshot, const gpuprims::Joints& joints, bool gpu_culls) override;
  core::Expected<void> add_culler(const core::Snapshot& snapshot) override;

  core::Expected<void> update(Edit edit, const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                              std::span<const core::Slot> touched, std::span<const std::uint32_t> materials,
                              core::Deadline deadline) override;
  core::Expected<bool> upload_meshes(core::Deadline deadline) override;
  void follow_later(std::span<const core::Slot> touched, std::span<const std::uint32_t> materials) override {
    upload_.follow_later(touched, materials);
  }
  core::Expected<void> finish_levels() override;

 protected:
  core::Expected<void> make_current() const { return context_.context.make_current(); }
  core::Expected<render::RenderTarget> make_target(int width, int height) const;
  bool wants_levels() const { return context_.config.losses.lod_error > 0.0; }
  core::Expected<void> follow_levels(core::Deadline deadline);
  void image_changed();
  void images_changed();

  DrawContext context_;                     // shared: all other members are made with it and destroyed before it
  std::optional<gl::Context> own_context_;  // none when the context is the application's
  GpuCulling culling_;
  UnseenItems unseen_;
  ImageOverlays overlays_;
  GpuUpload upload_;  // of the first order, or of another one beside the one that is drawn

 private:
  core::Expected<void> take_upload(const core::Snapshot& snapshot);
  core::Expected<bool> warm_up(const core::Snapshot& snapshot, core::Deadline deadline);
  core::Expected<void> draw_one(const core::Snapshot& snapshot, const gpuscene::Batch& batch);
  core::Expected<void> follow_batches(const core::Snapshot& snapshot);
  core::Expected<void> follow_edit(Edit edit, const core::Snapshot& snapshot, std::span<const core::Slot> touched,
                                   std::span<const std::uint32_t> materials);
  void follow_meshes();
  /// Items that are drawn over the image, which the GPU culler does not find.
  culling::SlotBits overlaid() const { return context_.config.draw ? overlays_.items() : culling::SlotBits(); }

  int packs_ = 0;              // MeshPool::packs() that draw lists follow
  std::size_t warmed_up_ = 0;  // batches of which advance() has drawn an item
};

}  // namespace sightline::engine
