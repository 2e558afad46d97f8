// The backend of an engine with GL: owns context, GPU scene, GPU culler, renderer and images, and directs what draws
// with them. Only in builds with GL. Internal to engine.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/engine/drawing/internal/frame_queue.h"
#include "sightline/engine/drawing/internal/gpu_upload.h"
#include "sightline/engine/drawing/internal/image_overlays.h"
#include "sightline/engine/drawing/internal/opaque_items.h"
#include "sightline/engine/drawing/internal/unseen_items.h"
#include "sightline/engine/internal/backend.h"

namespace sightline::engine {

class Drawing : public Backend {
 public:
  /// See make_backend().
  static core::Expected<std::unique_ptr<Drawing>> create(const EngineConfig& config, const Overrides& overrides);
  ~Drawing() override;

  bool ready() const override { return true; }
  bool lost() const override;
  std::unique_ptr<KeptState> keep_state() const override;
  Drawing* drawing() override { return make_current() ? this : nullptr; }

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

  void configure(const EngineConfig& config) override;
  /// Changes EngineConfig::losses alone.
  void set_losses(const LossConfig& losses);
  core::Expected<void> resize(int width, int height) override;
  core::Expected<void> use_image(std::uint32_t number, int width, int height) override;
  void forget_image(std::uint32_t number) override;

  bool has_overlays() const override { return overlays_.any(context_); }
  bool blends() const override { return context_.config.draw && !overlays_.items().empty(); }
  glm::vec2 blend_range(const core::View& view, const core::Snapshot& snapshot,
                        const core::VisibleSet& visible) override {
    return overlays_.blend_range(view, snapshot, visible);
  }
  core::Expected<void> cull(const core::View& cull_view, const core::View& view, const core::Snapshot& snapshot,
                            std::uint64_t frame) override;
  core::Expected<DrawResult> draw(const DrawRequest& request) override;
  /// Draws an outline of the visible items of `items` over a framebuffer: Engine::draw_outline(). The image stays.
  core::Expected<void> put_outline(const Culled& items, const gl::ExternalTarget& over) {
    return overlays_.put_outline(context_, items, over);
  }
  std::optional<DrawnFrame> take_drawn() override { return queue_.take_drawn(); }
  std::optional<LateReport> take_late_report() override;
  void finish() override;
  core::Expected<void> finish_levels() override;

  core::Expected<LeftOut> left_out(const Culled& culled) override;
  core::Expected<LossReport> loss(const Culled& culled) override;
  std::size_t memory_bytes() const override;
  std::size_t levels_bytes() const override { return context_.mesh_details.memory_bytes(); }
  std::string platform() const override { return context_.context.platform(); }
  std::string renderer() const override { return context_.context.renderer(); }
  bool software() const override { return context_.software(); }
  std::vector<std::string> take_gl_errors() override;
  std::optional<culling::GpuVariant> gpu_variant() const override;
  std::string why_gpu_variant() const override { return culling_.why_variant(); }

  // For tests and benchmarks, and for what reads the image.
  const gl::Context& context() const { return context_.context; }
  const culling::GpuCuller* gpu_culler() const { return culling_.culler(); }
  const gpuscene::GpuScene& scene() const { return *context_.scene; }
  const render::RenderTarget& target() const { return context_.target(); }

 private:
  Drawing(std::optional<gl::Context> own, gl::Context shared, const EngineConfig& config, const Overrides& overrides);
  core::Expected<void> make_current() const { return context_.context.make_current(); }
  core::Expected<bool> advance_upload(const core::Snapshot& snapshot, const gpuprims::Joints& joints, bool gpu_culls,
                                      core::Deadline deadline) {
    return upload_.advance(context_, culling_, snapshot, joints, gpu_culls, deadline);
  }
  core::Expected<void> take_upload(const core::Snapshot& snapshot);
  core::Expected<bool> warm_up(const core::Snapshot& snapshot, core::Deadline deadline);
  core::Expected<void> draw_one(const core::Snapshot& snapshot, const gpuscene::Batch& batch);
  core::Expected<void> follow_batches(const core::Snapshot& snapshot);
  core::Expected<void> follow_edit(Edit edit, const core::Snapshot& snapshot, std::span<const core::Slot> touched,
                                   std::span<const std::uint32_t> materials);
  core::Expected<render::RenderTarget> make_target(int width, int height) const;
  bool wants_levels() const { return context_.config.losses.lod_error > 0.0; }
  void follow_meshes();
  core::Expected<void> follow_levels(core::Deadline deadline);
  void image_changed();
  void images_changed();
  /// Items that are drawn over the image, which the GPU culler does not find.
  culling::SlotBits overlaid() const { return context_.config.draw ? overlays_.items() : culling::SlotBits(); }
  DrawInput input_of(const DrawRequest& request, const Culled& candidates, bool all_visible) const;
  core::Expected<DrawCounts> draw_opaque(const DrawRequest& request, bool aside);
  core::Expected<DrawCounts> draw_with_unseen(const DrawRequest& request);

  DrawContext context_;                     // shared: all other members are made with it and destroyed before it
  std::optional<gl::Context> own_context_;  // none when the context is the application's
  FrameQueue queue_;
  GpuUpload upload_;           // of the first order, or of another one beside the one that is drawn
  int packs_ = 0;              // MeshPool::packs() that draw lists follow
  std::size_t warmed_up_ = 0;  // batches of which advance() has drawn an item
  GpuCulling culling_;
  OpaqueItems opaque_;
  UnseenItems unseen_;
  ImageOverlays overlays_;
};

}  // namespace sightline::engine
