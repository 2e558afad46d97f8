// The half of an engine that draws, and culls on the GPU. Needs no GL header, so that the other half is the same in
// builds without GL. Internal to engine.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/internal/deadline.h"
#include "sightline/engine/drawing/internal/frame.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/internal/overrides.h"

namespace sightline::engine {

/// While it lives, what the application has may change. With a context of the engine's own that is which context is
/// current, and in the application's context its state (EngineConfig::context.gl_state). Its destructor brings that
/// back.
struct KeptState {
  virtual ~KeptState() = default;
};

struct DrawResult {
  DrawCounts counts;     ///< 0 where the GPU has culled
  double wait_ms = 0.0;  ///< until the frame before the last was drawn
};

/// Describes a backend.
struct BackendReport {
  std::string platform = {}, renderer = {};             ///< as gl::Context has them
  const gl::Context* application = nullptr;             ///< the application's context, if it draws there
  std::optional<culling::GpuVariant> gpu_variant = {};  ///< of the GPU culler
  std::string why_gpu_variant = {}, why_rays = {};
  std::size_t gpu_bytes = 0;
  std::size_t levels_bytes = 0, points_bytes = 0;  ///< of main memory: clusters and levels of detail; moving images
};

/// A frame that is drawn, with the time that the GPU spent on it alone. That time runs from the end of the frame
/// before, or from the submission of this one if that is later, until its end. It is measured by waiting for the end;
/// 0: there was no wait.
struct DrawnFrame {
  std::uint64_t frame = 0;
  double gpu_ms = 0.0;
};

/// This class is the null object, which draws nothing and succeeds: for engines that need no GL, and while the context
/// is lost. Drawing overrides all of it. Functions that need the context make it current on the calling thread, unless
/// it was adopted, and leave it current: KeptState is for their callers.
class Backend {
 public:
  virtual ~Backend() = default;

  /// Whether there is a context to draw in.
  virtual bool ready() const { return false; }
  /// Whether that context is lost, see gl::Context::lost().
  virtual bool lost() const { return false; }
  virtual std::unique_ptr<KeptState> keep_state() const { return nullptr; }
  /// The implementation with GL, whose context is then current. Null where that fails.
  virtual Drawing* drawing() { return nullptr; }

  // --- the order of the items ---
  // `gpu_culls`: with a GPU culler.

  /// Uploads what the engine draws, in portions: call it until it returns true. Each call does at least a little, and
  /// ends a few milliseconds after the deadline, but for single programs and the GPU culler. It also draws an
  /// item of each batch, since some drivers compile when a program first draws. Meanwhile resize(), configure(),
  /// follow_later() and lost() may be called. It is of no use after a failure.
  virtual core::Expected<bool> advance(const core::Snapshot&, const gpuprims::Joints&, bool /*gpu_culls*/,
                                       core::Deadline) {
    return true;
  }
  /// Uploads another order of the items in portions, as advance(), while frames show the present one. Once it has
  /// returned true, take_version() shows the other one. abandon_version() drops it.
  virtual core::Expected<bool> advance_version(const core::Snapshot&, const gpuprims::Joints&, bool /*gpu_culls*/,
                                               core::Deadline) {
    return true;
  }
  virtual core::Expected<void> take_version(const core::Snapshot& /*former*/, const core::Snapshot&,
                                            const gpuprims::Joints&, bool /*gpu_culls*/) {
    return {};
  }
  virtual void abandon_version() {}
  /// Uploads everything anew from another snapshot, at once.
  virtual core::Expected<void> rebuild(const core::Snapshot&, const gpuprims::Joints&, bool /*gpu_culls*/) {
    return {};
  }
  /// Makes the GPU culler unless there is one. The snapshot must be that of the last update() or rebuild().
  virtual core::Expected<void> add_culler(const core::Snapshot&) { return {}; }

  // --- edits ---

  enum class Edit {
    kItems,   ///< placements and shapes may have changed, and slots were appended
    kStyles,  ///< only styles and whether items are drawn
  };
  /// Follows an edit of touched slots (Snapshot::apply) and of materials (SceneDelta::materials). After the deadline
  /// meshes are left to upload_meshes().
  virtual core::Expected<void> update(Edit, const core::Snapshot&, const gpuprims::Joints&,
                                      std::span<const core::Slot> /*touched*/,
                                      std::span<const std::uint32_t> /*materials*/, core::Deadline) {
    return {};
  }
  /// Uploads meshes that update() has left, which are drawn from then on. Whether all are.
  virtual core::Expected<bool> upload_meshes(core::Deadline) { return true; }
  /// Notes an edit of the snapshot that advance() or advance_version() works on.
  virtual void follow_later(std::span<const core::Slot> /*touched*/, std::span<const std::uint32_t> /*materials*/) {}

  // --- settings ---

  /// Uses what Engine::configure() may change, from the next frame on.
  virtual void configure(const EngineConfig&) {}
  /// See Engine::resize().
  virtual core::Expected<void> resize(int /*width*/, int /*height*/) { return {}; }
  /// Uses another image from now on: Engine::use_image(). It is created unless there is one of that size.
  virtual core::Expected<void> use_image(std::uint32_t /*number*/, int /*width*/, int /*height*/) { return {}; }
  virtual void forget_image(std::uint32_t /*number*/) {}

  // --- frames ---

  /// Whether any items are drawn over the image; the CPU must find those that are visible, also where the GPU culls.
  virtual bool has_overlays() const { return false; }
  /// Whether some of them may be blended.
  virtual bool blends() const { return false; }
  /// Eye depths between which the blended items of a set lie.
  virtual glm::vec2 blend_range(const core::View&, const core::Snapshot&, const core::VisibleSet&) { return {}; }
  /// Culls on the GPU; draw() draws the result. Needs the GPU culler. take_late_report() tells more.
  virtual core::Expected<void> cull(const Frame&) { return {}; }
  /// Submits a frame with the visible items of its culling view, or, if `on_gpu`, with those that cull() has found, and
  /// of `visible` what is drawn over the image. Waits first until at most one earlier frame is still being drawn.
  /// Leaves out items that cover no sample of the image, or that others occlude, as configured.
  virtual core::Expected<DrawResult> draw(const Frame&, const core::VisibleSet& /*visible*/, bool /*on_gpu*/ = false) {
    return DrawResult();
  }
  /// The oldest drawn frame that was not yet taken.
  virtual std::optional<DrawnFrame> take_drawn() { return std::nullopt; }
  /// The oldest result of the GPU culler that was not yet taken.
  virtual std::optional<LateReport> take_late_report() { return std::nullopt; }
  virtual void finish() {}
  /// Waits for clusters and levels of detail of all meshes, and uploads them.
  virtual core::Expected<void> finish_levels() { return {}; }

#if SIGHTLINE_HAS_GL
  // --- the last frame's image: Engine's functions of these names ---

  virtual core::Expected<image::Image> read_colour();
  virtual core::Expected<image::IdImage> read_ids();
  /// `view`: null: reversed depths, as they are stored, 0 where nothing was drawn.
  virtual core::Expected<image::DepthImage> read_depth(const core::View* view);
#endif

  // --- queries ---

  /// What an image of the view would leave out of the visible items. The last image is then gone.
  virtual core::Expected<LeftOut> left_out(const Frame&, const core::VisibleSet& /*visible*/) {
    return LeftOut();
  }
  /// Error of the last draw() by EngineConfig::losses; it must have drawn `visible`.
  virtual core::Expected<LossReport> loss(const Frame&, const core::VisibleSet& /*visible*/) {
    return LossReport();
  }
  virtual BackendReport report() const {
    return {};
  }
  virtual bool software() const {
    return false;
  }
  /// Whether it traces images, and so needs the tracer of each frame's snapshot.
  virtual bool traces() const {
    return false;
  }
  virtual std::vector<std::string> take_gl_errors() {
    return {};
  }
};

// Builds without GL have their own version of each of these (no_gl.cpp).

/// A backend that draws nothing before advance() or rebuild(): with GL, or by rays. `overrides` are borrowed. Fails in
/// builds without GL.
core::Expected<std::unique_ptr<Backend>> make_backend(const EngineConfig& config, const Overrides& overrides);
/// Keeps which context is current on this thread, for the time in which a backend is made.
std::unique_ptr<KeptState> keep_current_context();
/// Sets the plan's entry for the program of each batch kind. `why_not`: where GL does not draw.
void plan_programs(Plan& plan, const core::Snapshot& snapshot, bool draw, const char* why_not);

}  // namespace sightline::engine
