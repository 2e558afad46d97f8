// The half of an engine that needs GL: context, GPU scene, draw lists, GPU culler, renderer and target. Only in builds
// with GL.
#pragma once

#include <deque>
#include <optional>

#include "sightline/culling/gpu/internal/gpu_culler.h"
#include "sightline/engine/engine.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::engine {

/// Whatever needs the context makes it current on the calling thread, unless it was adopted, and leaves it so.
class Drawing {
 public:
  static core::Expected<std::unique_ptr<Drawing>> create(const core::Snapshot& snapshot, const EngineConfig& config,
                                                         bool gpu_culls);
  ~Drawing();
  /// Adds a row for each program there is.
  static void plan_programs(Plan& plan, const core::Snapshot& snapshot, bool draw);

  /// Submits one frame of a visible set. Before that it waits until at most one earlier frame is still being drawn.
  /// `frame` comes back in take_drawn(). Where there is nothing to render it does nothing.
  core::Expected<void> draw(const core::View& view, const core::Snapshot& snapshot, const core::VisibleSet& visible,
                            std::uint64_t frame);
  /// Culls on the GPU, if the configuration asks for it, and submits a frame of what is found there with draw_culled().
  /// `frame` comes back in take_gpu_feedback(), too.
  core::Expected<void> cull(const core::View& view, const core::Snapshot& snapshot, std::uint64_t frame);
  core::Expected<void> draw_culled(const core::View& view, const core::Snapshot& snapshot, std::uint64_t frame);
  /// What the last of these has waited, milliseconds.
  double waited_ms() const { return waited_ms_; }
  /// A frame that is drawn, and how long the GPU was at it alone: from the end of the frame before, or its submission,
  /// until its end, as somebody sees who waits for that; 0: nobody had to wait. The oldest not yet taken.
  struct Drawn {
    std::uint64_t frame = 0;
    double gpu_ms = 0.0;
  };
  std::optional<Drawn> take_drawn();
  std::optional<culling::GpuCuller::Feedback> take_gpu_feedback();
  /// Follows an edit of `touched` slots (Snapshot::apply) and of materials (SceneDelta::materials): rewrites their
  /// records and adds those of appended slots, or makes everything anew where GpuScene::append has no room.
  core::Expected<void> update(const core::Snapshot& snapshot, std::span<const core::Slot> touched,
                              std::span<const std::uint32_t> materials);
  /// Makes everything of another snapshot, with or without a GPU culler.
  core::Expected<void> rebuild(const core::Snapshot& snapshot, bool gpu_culls);
  /// Makes the GPU culler, for the snapshot of the last update() or rebuild(), unless it is there.
  core::Expected<void> add_culler(const core::Snapshot& snapshot);
  /// See Engine::resize.
  core::Expected<void> resize(int width, int height);
  void finish();

  const gl::Context& context() const { return context_; }
  core::Expected<void> make_current() const { return context_.make_current(); }
  /// Whether the context is, see gl::Context::lost.
  bool lost() const;
  const std::string& renderer() const { return context_.renderer(); }
  bool software() const { return context_.capabilities().software; }
  const culling::GpuCuller* gpu_culler() const { return culler_ ? &*culler_ : nullptr; }
  /// Of the GPU culler; none without one.
  std::optional<culling::GpuForm> gpu_form() const { return culler_ ? std::optional(culler_->form()) : std::nullopt; }
  const std::string& why_gpu_form() const { return why_gpu_form_; }
  const gpuscene::DrawLists& lists() const { return *lists_; }
  std::vector<std::string> take_gl_errors();
  const render::RenderTarget& target() const { return target_; }
  std::size_t memory_bytes() const;

 private:
  Drawing(std::optional<gl::Context> own, gl::Context context)
      : context_(std::move(context)), own_context_(std::move(own)) {}
  core::Expected<culling::GpuCuller> make_culler(const core::Snapshot& snapshot, const gpuscene::GpuScene& scene);
  void wait_for_room();
  void wait_for_oldest();
  core::Expected<void> submit(const core::View& view, const core::Snapshot& snapshot, std::uint64_t frame);

  struct InFlight {
    GLsync fence;
    std::uint64_t frame;
    double submitted;  // seconds on the steady clock
  };

  gl::Context context_;                     // a share: everything below is made with it and must go before it
  std::optional<gl::Context> own_context_;  // none when it is the application's
  bool renders_ = true;
  culling::GpuCullerConfig cull_config_;  // names the form once it is known
  std::string why_gpu_form_;
  std::optional<gpuscene::GpuScene> scene_;
  std::optional<gpuscene::DrawLists> lists_;
  std::optional<culling::GpuCuller> culler_;
  std::optional<render::Renderer> renderer_;  // none when only culling
  render::RenderTarget target_;
  std::deque<InFlight> in_flight_;
  std::deque<Drawn> drawn_;
  double last_drawn_ = 0.0, waited_ms_ = 0.0;  // seconds: when the newest of drawn_ was known to be
};

}  // namespace sightline::engine
