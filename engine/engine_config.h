// Settings of engines. internal/settings.inc lists all of them with their names elsewhere, their ranges, and whether
// Engine::configure() may change them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "sightline/core/conventions.h"
#include "sightline/culling/gpu/gpu_culler_config.h"
#include "sightline/culling/hybrid/controller.h"
#include "sightline/engine/looks.h"
#include "sightline/engine/plan.h"

namespace sightline::core {
class JobRunner;
}

namespace sightline::gl {
class Context;
enum class ContextPlatform : std::uint8_t;
}  // namespace sightline::gl

namespace sightline::engine {

/// What a call leaves of what the application has in GL: the state of its context, where the engine draws in that. With
/// a context of the engine's own: which context is current on the calling thread.
enum class GlState : std::uint8_t {
  /// After each call it is as before, but for pending GL errors, which are dropped. What GL can neither tell nor reset
  /// must not be active: conditional rendering, transform feedback that is not paused, a query of
  /// GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN or, for stream 1, of GL_PRIMITIVES_GENERATED. Costs some 400 short GL
  /// calls a frame.
  ///
  /// With a context of the engine's own, the thread has current again what it had: a context of EGL, GLX or OSMesa with
  /// its surfaces, or none. So the engine needs no care beside windows, and calls may come from any thread, one at a
  /// time. Costs two changes of contexts a call: 0.3 ms with Mesa's rasteriser.
  kRestore,
  /// It is left as the engine's last draw needed it, and the same must not be active. Bindings of framebuffers,
  /// programs, program pipelines, vertex
  /// arrays, transform feedback, textures and samplers of units 0 to 5, indexed uniform buffers 0 to 3 and storage
  /// buffers 0 to 5, indirect, parameter and query buffers may be others. So may viewports, scissor, depth, colour
  /// mask, blending, clip control, face culling, GL_UNPACK_SKIP_PIXELS and _ROWS. Multisampling is on. As in a new
  /// context are rasteriser discard, primitive restart, clip distances, depth clamp, smooth lines and polygons, polygon
  /// offsets, polygon mode, line width, alpha to coverage and to one, sample coverage, mask and shading, logic
  /// operations, depth range, front face, provoking vertex and the hint for derivatives; dithering is off. The rest
  /// stays.
  ///
  /// A context of the engine's own stays current on the thread that calls: for programs in which no other context is
  /// and that thread makes all calls.
  kLeave,
};

constexpr std::string_view name_of(GlState state) {
  return state == GlState::kRestore ? "restore" : "leave";
}

/// Makers of images.
enum class Renderer : std::uint8_t {
  kGl,  ///< OpenGL; where there is none, create() fails
  /// Rays on the processor, without OpenGL. Images are the same but for pixels where a rasteriser rounds: see
  /// docs/reference/accuracy.md. They have all items, whatever LossConfig lets them lack. Without hatching, blended
  /// transparency, DrawingConfig::culled_colour, a culler on the GPU, and all that is the application's in GL: create()
  /// fails where these are asked for.
  kRays,
  /// Rays where no context can be made, and until there is one (ContextConfig::later). Frames draw nothing while
  /// Engine::prepare_picks() makes what these need.
  kAutomatic,
};

constexpr std::string_view name_of(Renderer renderer) {
  return renderer == Renderer::kGl ? "gl" : renderer == Renderer::kRays ? "rays" : "auto";
}

/// Settings of culling: which items are found visible, and by which means.
struct CullingConfig {
  CullerChoice culler = CullerChoice::kAutomatic;
  /// Leave out of drawing what covers no sample of the image (culling/occlusion/sample_test.h): nothing is lost. On a
  /// software rasteriser also the triangles of meshes that cover none, or show their back alone.
  bool sample_test = true;
  /// Leave out of drawing what other items hide (culling/occlusion/occlusion_test.h): nothing is lost. With one sample
  /// per pixel only.
  OcclusionChoice occlusion = OcclusionChoice::kAutomatic;
  /// Draws, culls and finds this part of the scene alone, so that several engines, in several processes, share an
  /// image. A pixel is as in an image of the whole where this part shows there. Of other parts no meshes are in GPU
  /// memory; main memory has the whole scene. commit() makes everything anew where there were edits. Functions that
  /// take items know those of the part alone.
  ScenePart part = {};
  /// Edits append slots and leave vacant ones behind. When such slots exceed this share of all, the engine makes a new
  /// scene version in the background; 0: never. An item that moves far counts twice. Until the new scene version lands,
  /// 1 % of moved items cost up to a tenth of the culling speed.
  double rebuild_share = 0.03;
  std::optional<culling::GpuVariant> gpu_variant = {};  ///< none: measured once for each context
  /// For CullerChoice::kHybrid. ControllerConfig::rendering follows EngineConfig::draw. On a software rasteriser
  /// ControllerConfig::presumed_gpu_excess is 10 % unless it is set here.
  culling::ControllerConfig controller = {};
};

/// Settings of the image: its contents and its looks.
struct DrawingConfig {
  Renderer renderer = Renderer::kGl;
  bool ids = false;  ///< item-id image beside colour and depth
  int samples = 1;   ///< per pixel, 32 at most; from 2 on edges are smooth, and ids and depth are those of one sample
  Transparency transparency = Transparency::kDither;
  core::vec3 outline_colour{1.0f, 0.5f, 0.0f};  ///< sRGB, of ItemStyle::outline
  /// Colour (sRGB) in which frames with a FrameInput::cull_view draw the items that the sample test and the occlusion
  /// test leave out of the image of cull_view; then these frames are culled on the CPU. None: such items look like
  /// all others.
  std::optional<core::vec3> culled_colour = {};
  Looks looks = {};
};

/// Settings that let an image lack items, so that it costs less. All of them are off by default.
struct LossConfig {
  /// Leave out of drawing items that cover fewer pixels than this: culling/occlusion/contribution.h, with the mean area
  /// over all directions; hysteresis; lines are exempt. 0: nothing is lost. The CPU must cull: create() and
  /// set_culler() fail with kGpu, and kHybrid is then as kAutomatic; both also with a budget.
  float min_projected_area = 0.0f;
  /// How these items are drawn. With a budget also what its time does not suffice for; kStochastic is then as
  /// kPoints.
  ContributionMode contribution_mode = ContributionMode::kDrop;
  /// Milliseconds that a call of frame() may take; 0: any. While the view moves, an engine on a software rasteriser
  /// shows everything: drawn, if it is known to take no longer; else traced by rays, as many as there is time for, with
  /// one sample per pixel, beside the points that earlier frames have found (FrameReport::earlier). Rays need a tracer,
  /// which is made in the background; until then, and in builds without one, the image has fewer pixels, down to a
  /// quarter along either axis (FrameReport::coarseness); if that takes longer, so does the frame. A GPU draws the
  /// largest items first, and what the time does not suffice for is left out (FrameReport::pending), or a splat each:
  /// contribution_mode. While view and scene stay the same, each frame draws more of the image with all pixels, until
  /// it is complete; then frames draw nothing. Such a frame draws for at least four times as long as it takes beside
  /// that (reading depth back, copying), however small the budget is: else large images would hardly go on. Depth
  /// shading waits until the image is complete, and until the view stays once it was incomplete. The CPU must cull, as
  /// above. Every frame is waited for. With lod_error, moving images of a GPU first get coarser levels of detail, up to
  /// 2 pixels, before more is left out.
  double budget_ms = 0.0;
  /// Draw meshes by coarser levels of detail (lod/mesh_levels.h), whose surface lies within so many pixels of the
  /// original one in the image; 0: by their own triangles. Levels are built in the background; until a mesh's are ready
  /// its own triangles are drawn. Meshes that a section plane cuts are drawn in full there.
  double lod_error = 0.0;
};

/// The GL context that an engine draws in.
struct ContextConfig {
  /// The application's context to draw with; it must be current in all calls. See use_context(). The engine treats it
  /// as lost once it is destroyed. The engine accepts any GL state in it, but for what GlState::kRestore names. Null:
  /// the engine makes an offscreen context.
  gl::Context* application = nullptr;
  /// The engine is as while its context is lost, until use_context(), which may work in portions: so it can be made by
  /// another thread than the one that draws. Renderer::kAutomatic draws by rays meanwhile. Not with an `application`'s
  /// context.
  bool later = false;
  GlState gl_state = GlState::kRestore;
  gl::ContextPlatform platform = {};  ///< of the offscreen context (gl/context.h); ContextOptions' default
  /// Folder that keeps linked programs from run to run, so that drivers need not compile them again. Processes may
  /// share it. None: the user's cache folder, gl::ProgramCache::default_folder(). An empty path: no cache.
  std::optional<std::filesystem::path> program_cache = {};
  bool gl_debug = false;  ///< collect driver messages; slower
};

/// Settings of an engine. internal/settings.inc lists all of them, with whether Engine::configure() may change them.
struct EngineConfig {
  bool draw = false;               ///< false: no GL at all, unless the culler needs it
  int width = 1280, height = 720;  ///< of the image, in pixels
  /// That prepare and trace a frame, the calling one included; 0: one per processor, at most ThreadPool::kUsual. What
  /// a frame shows does not depend on it. Scenes, levels and tracers are made by OpenMP's threads.
  int threads = 0;
  core::JobRunner* runner = nullptr;  ///< the application's threads in their place; must outlive the engine
  CullingConfig culling = {};
  DrawingConfig drawing = {};
  LossConfig losses = {};
  ContextConfig context = {};
};

}  // namespace sightline::engine
