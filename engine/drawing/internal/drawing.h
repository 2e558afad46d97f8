// The backend of an engine with GL: makes images of a DrawnScene, and directs what draws them. Only in builds with GL.
// Internal to engine.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sightline/engine/drawing/internal/drawn_scene.h"
#include "sightline/engine/drawing/internal/frame_queue.h"
#include "sightline/engine/drawing/internal/opaque_items.h"

namespace sightline::engine {

class Drawing : public DrawnScene {
 public:
  /// See make_backend().
  static core::Expected<std::unique_ptr<Drawing>> create(const EngineConfig& config, const Overrides& overrides);
  ~Drawing() override;

  bool ready() const override { return true; }
  Drawing* drawing() override { return make_current() ? this : nullptr; }

  void configure(const EngineConfig& config) override;
  /// Changes EngineConfig::losses alone.
  void set_losses(const LossConfig& losses);
  core::Expected<void> resize(int width, int height) override;
  core::Expected<void> use_image(std::uint32_t number, int width, int height) override;
  void forget_image(std::uint32_t number) override;

  bool has_overlays() const override { return overlays_.needs_visible(context_); }
  bool blends() const override { return context_.config.draw && !overlays_.items().empty(); }
  glm::vec2 blend_range(const core::View& view, const core::Snapshot& snapshot,
                        const core::VisibleSet& visible) override {
    return overlays_.blend_range(view, snapshot, visible);
  }
  core::Expected<void> cull(const Frame& frame) override;
  core::Expected<DrawResult> draw(const Frame& frame, const core::VisibleSet& visible, bool on_gpu = false) override;
  /// Draws an outline of visible items over a framebuffer: Engine::draw_outline(). The image stays.
  core::Expected<void> put_outline(const Frame& frame, const core::VisibleSet& items, const gl::ExternalTarget& over) {
    return overlays_.put_outline(context_, frame, items, over);
  }
  std::optional<DrawnFrame> take_drawn() override { return queue_.take_drawn(); }
  std::optional<LateReport> take_late_report() override;
  void finish() override;

  core::Expected<LeftOut> left_out(const Frame& frame, const core::VisibleSet& visible) override;
  core::Expected<LossReport> loss(const Frame& frame, const core::VisibleSet& visible) override;
  core::Expected<image::Image> read_colour() override;
  core::Expected<image::IdImage> read_ids() override;
  core::Expected<image::DepthImage> read_depth(const core::View* view) override;
  BackendReport report() const override;
  bool software() const override { return context_.software(); }
  std::vector<std::string> take_gl_errors() override;

  // For tests and benchmarks, and for what reads the image.
  const gl::Context& context() const { return context_.context; }
  const culling::GpuCuller* gpu_culler() const { return culling_.culler(); }
  const gpuscene::GpuScene& scene() const { return *context_.scene; }
  const render::RenderTarget& target() const { return context_.target(); }

 private:
  using DrawnScene::DrawnScene;
  core::Expected<DrawCounts> draw_culled(const Frame& frame);
  core::Expected<DrawCounts> draw_with_unseen(const Frame& frame, const core::VisibleSet& opaque);

  FrameQueue queue_{context_.gl()};
  OpaqueItems opaque_;
};

}  // namespace sightline::engine
