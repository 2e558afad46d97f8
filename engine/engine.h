// engine: the conductor an application embeds. Takes a committed scene, plans what it needs, and per view culls and
// draws it.
//
//   core::Scene scene = …;
//   auto engine = engine::Engine::create(scene, {.draw = true, .width = 1280, .height = 720});
//   auto report = engine->frame(view);
//   image::write_png(*engine->read_colour(), "out.png");
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/controller.h"
#include "sightline/culling/gpu/gpu_culler_config.h"
#include "sightline/engine/plan.h"

namespace sightline::gl {
class Context;
}
namespace sightline::image {
struct DepthImage;
struct IdImage;
struct Image;
}  // namespace sightline::image

namespace sightline::engine {

class Drawing;

struct EngineConfig {
  CullerChoice culler = CullerChoice::kAutomatic;
  bool draw = false;  ///< false: no GL at all, unless the culler needs it
  int width = 1280, height = 720;
  bool ids = false;       ///< item-id image beside colour and depth
  int samples = 1;        ///< per pixel; from 2 on edges are smooth, and ids and depth are those of one sample
  bool gl_debug = false;  ///< collect driver messages; slower
  /// A current context to draw with, owned by the application, see use_context(). When it is destroyed before the
  /// engine, it is lost. Its state may be any when the engine is called, but for what gl::reset_pipeline_state names,
  /// and is another afterwards. Null: one is made offscreen; calls that need it make it current on the calling thread
  /// and leave it so.
  gl::Context* context = nullptr;
  /// Where linked programs are kept from run to run, so that drivers need not compile them again; processes may share
  /// it. None: the user's cache folder, gl::ProgramCache::default_folder(). An empty path: nowhere.
  std::optional<std::filesystem::path> program_cache = {};
  /// Edits leave slots behind. When this share of them was appended or given up, a new order is made in the background;
  /// 0: never. Items that move far count twice: 1 % of them cost up to a tenth of culling speed until it lands.
  double rebuild_share = 0.03;
  culling::GpuCullerConfig gpu_culler = {};  ///< its form is measured once, unless named here
  /// Of the hybrid. Whether frames or cull times count follows from `draw`; on a software rasteriser 10 % is presumed
  /// as FrameCostConfig::presumed_gpu_excess, unless another share is named here.
  culling::ControllerConfig controller = {};
};

/// Times in milliseconds of wall clock.
struct FrameReport {
  std::uint64_t frame = 0;                             ///< calls of frame() before this one
  CullerChoice culler = CullerChoice::kCpu;            ///< that culled it: kLinear, kCpu or kGpu
  std::optional<culling::ControllerState> state = {};  ///< of the hybrid; none without one
  double cull_ms = 0.0;                                ///< the culler alone; of the GPU culler what submitting takes
  double draw_ms = 0.0;   ///< waiting, then making and submitting the draw lists; 0 without GL
  double wait_ms = 0.0;   ///< of draw_ms: until the frame before the last was drawn
  double frame_ms = 0.0;  ///< since the last frame began, at most two frames being in flight; 0 for the first frame
  bool drawn = false;     ///< false without drawing, and while the context is lost
  std::int64_t visible = 0, tested = 0;  ///< items; hierarchy and item boxes. -1: known to the GPU alone
};

/// What the GPU culler found in an earlier frame.
struct LateReport {
  std::uint64_t frame = 0;  ///< FrameReport::frame
  std::int64_t visible = 0;
  double gpu_cull_ms = -1.0;  ///< on the GPU's clock; -1 where that means nothing
};

struct MemoryReport {
  std::size_t scene = 0, snapshot = 0, bvh = 0, gpu = 0;  ///< bytes
};

class Engine {
 public:
  /// Commits the scene's pending edits and builds everything the plan names. The scene must outlive the engine. Fails
  /// with the scene's error, or GL's when drawing was asked for (also when this build has no GL).
  static core::Expected<Engine> create(core::Scene& scene, const EngineConfig& config = {});

  Engine(Engine&&) noexcept;
  Engine& operator=(Engine&&) noexcept;
  ~Engine();

  /// Culls and, when drawing is on, draws into drawing()->target() without waiting for it.
  ///
  /// A context may be lost (gl::Context::lost). Then what was in it is let go, and frames are culled by the CPU, not
  /// drawn, until all has been made anew from the snapshot: at once or, should that fail, tried again twice a second,
  /// if the engine made the context itself; with use_context() if it is the application's. visible(), queries and edits
  /// work all the time.
  core::Expected<FrameReport> frame(const core::View& view) { return frame(view, view); }
  /// Draws from `view` what `cull_view` can see: shows from aside what a culler keeps.
  core::Expected<FrameReport> frame(const core::View& view, const core::View& cull_view);
  /// The oldest of the GPU culler's results not yet taken, some frames late; nothing while none has arrived. Never
  /// waits. When nobody takes them, the oldest are lost.
  std::optional<LateReport> take_late_report();

  /// Commits the scene's pending edits and takes over all that was published since this engine's last commit(), by
  /// whichever engine or by the application, in time that follows their number: see Snapshot::apply. Until then frames
  /// show what this engine knows. With drawing on, edits that GpuScene::append has no room or shape for upload
  /// everything anew.
  ///
  /// After many edits a new order is made in the background (EngineConfig::rebuild_share), from the snapshot and not
  /// from the scene, which may be edited meanwhile. It lands in the first commit() or frame() after it is ready, as an
  /// exchange of pointers; with drawing on everything is then uploaded anew. Slots change with it: visible() is of the
  /// snapshot whose generation it names.
  core::Expected<void> commit();
  /// The same order as of a new engine, at once. Stops a rebuild in the background.
  core::Expected<void> rebuild();
  /// True while a new order is made or waits to land.
  bool rebuilding() const;

  /// Another culler from the next frame on. Makes what is missing for it and keeps all else, until the next new order
  /// also what the culler before it had, so that changing back costs next to nothing; the hybrid starts from a first
  /// guess. Stops a rebuild in the background; the next commit() begins it again. Fails where create() would; then
  /// nothing has changed.
  core::Expected<void> set_culler(CullerChoice choice);
  /// Another size of the target, in pixels, from the next frame on; the old picture is gone. Fails on sizes that the
  /// context does not have; then nothing has changed.
  core::Expected<void> resize(int width, int height);

  /// Lets go of all that lies in the application's context, which must be current. Frames are then as after a loss.
  /// Not needed before the application destroys its gl::Context, but it frees what an adopted context would keep.
  void drop_context();
  /// Another context of the application's, current, in place of a lost or dropped one: makes everything there anew.
  /// Fails with GL's error; then it is as it was before.
  core::Expected<void> use_context(gl::Context& context);

  /// Time stood still since the last frame (a pause, a dialog, nothing to draw): it is not taken for that frame's. Of a
  /// hybrid the next frame is not measured either.
  void paused();

  /// Waits until everything submitted is drawn.
  void finish();

  const Plan& plan() const;
  const core::Snapshot& snapshot() const;
  const core::VisibleSet& visible() const;  ///< empty when the GPU culls
  /// The last frame's picture (image/image.h). Only builds with GL have these functions. They wait for the GPU. They
  /// fail without EngineConfig::draw, and while the context is lost.
  core::Expected<image::Image> read_colour();
  core::Expected<image::IdImage> read_ids();  ///< fails without EngineConfig::ids, too
  /// Distances along the axis of `view`, which is the one that was drawn.
  core::Expected<image::DepthImage> read_depth(const core::View& view);
  /// Whether any pixel shows anything but the background.
  core::Expected<bool> covered();
  /// GL's name of the framebuffer with the picture, one value per pixel, in the context that the engine draws with.
  core::Expected<std::uint32_t> framebuffer();

  /// As GL names it; empty while there is no context.
  std::string renderer();
  /// What the driver has complained of since the last call: see EngineConfig::gl_debug.
  std::vector<std::string> take_gl_errors();

  /// The half that needs GL, for tests and benchmarks of this library (engine/internal/drawing.h). Null when nothing
  /// needs GL, and while the context is lost. An engine's own context is then current.
  Drawing* drawing();
  MemoryReport memory() const;
  const culling::Controller* controller() const;  ///< of the hybrid; null without one

 private:
  class Impl;
  explicit Engine(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace sightline::engine
