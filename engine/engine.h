// engine: the conductor an application embeds. Takes a committed scene, plans what it needs, and per view culls and
// draws it.
//
//   core::Scene scene = …;
//   auto engine = engine::Engine::create(scene, {.draw = true, .width = 1280, .height = 720});
//   auto report = engine->frame(view);
//   image::write_png(*engine->read_colour(), "out.png");
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/ray.h"
#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/cull_states.h"
#include "sightline/culling/queries/region_query.h"
#include "sightline/engine/engine_config.h"
#include "sightline/engine/image_tiles.h"
#include "sightline/engine/item_style.h"
#include "sightline/engine/plan.h"

namespace sightline::gl {
class Context;
struct ExternalTarget;
}  // namespace sightline::gl
namespace sightline::gpuprims {
class Joints;
}
namespace sightline::image {
struct DepthImage;
struct IdImage;
struct Image;
}  // namespace sightline::image
namespace sightline::raytrace {
struct RayFilter;
struct VisibleItem;
}  // namespace sightline::raytrace

namespace sightline::engine {

class Drawing;
struct Pick;

/// Between two corners, in pixels from the image's upper left corner.
struct PixelRectangle {
  double x0, y0, x1, y1;
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
  std::int64_t visible = 0,
               tested = 0;  ///< items in the view volume; hierarchy and item boxes. -1: known to the GPU alone
  /// Items in the view volume that may cover a sample of the image (-1 where occlusion was tested, which includes
  /// that); items drawn. Both -1 without drawing, and where the GPU alone knows.
  std::int64_t sampled = -1, items_drawn = -1;
  /// Triangles of the meshes drawn, whether they cover a sample or not: fewer than these have where levels of detail or
  /// clusters (lod/mesh_levels.h) draw them. -1 without drawing, and where the GPU culled.
  std::int64_t triangles = -1;
  /// Items in the view volume that are below EngineConfig::losses.min_projected_area; 0 without it.
  std::int64_t below_min_area = 0;
  /// Drawn and pending items that are drawn as one splat each: EngineConfig::losses.contribution_mode.
  std::int64_t splats = 0;
  /// Items in the view volume for which EngineConfig::losses.budget_ms did not suffice: some of them may be hidden, and
  /// some drawn by coarser levels than lod_error asks for. 0: the image is complete.
  std::int64_t pending = 0;
  /// Pixels of the image along either axis for one that was drawn: above 1 where a moving image within a budget shows
  /// everything, but coarser. Ids and depths are those of a drawn pixel nearby, and colours too, or between several.
  double coarseness = 1.0;
  /// 0 … 1: share of the pixels of a moving image within a budget whose points earlier frames have found. They show
  /// where they are now, though something nearer may have come before them.
  double earlier = 0.0;
};

/// What the GPU culler found in an earlier frame. It is not asked for translucent items (docs/guide/transparency.md).
struct LateReport {
  std::uint64_t frame = 0;        ///< FrameReport::frame
  std::int64_t visible = 0;       ///< items in the view volume
  double gpu_cull_ms = -1.0;      ///< on the GPU's clock; -1 where that means nothing
  std::int64_t items_drawn = -1;  ///< items drawn; -1 without drawing
};

/// What EngineConfig::losses cost an image. Of what is left out an estimate, of levels of detail a proven bound.
struct LossReport {
  std::int64_t items = 0;  ///< left out, that may cover a sample and that nothing in the image is known to hide
  double pixels = 0.0;     ///< that these are expected to cover, at most all: see Engine::loss()
  /// Pixels: each point that is drawn of a mesh lies within so many of a point of the original surface, and the other
  /// way round. Proved; at most EngineConfig::losses.lod_error, or 2 while budget_ms does not suffice. 0: all are drawn
  /// by their own triangles.
  double lod_error = 0.0;
  std::int64_t triangles = 0;       ///< FrameReport::triangles; 0 where the GPU culled
  std::int64_t full_triangles = 0;  ///< of the same items, drawn whole and by their own triangles
  double coarseness = 1.0;          ///< FrameReport::coarseness: then `items` and `pixels` are 0
  double coarser_share = 0.0;       ///< 0 … 1: of the items with a mesh that are drawn, those by coarser levels
};

/// With what a new scene version has that is ready and not shown yet, and without one that is still being made.
struct MemoryReport {
  std::size_t scene = 0, snapshot = 0, bvh = 0, gpu = 0;  ///< bytes
  std::size_t tracer = 0;   ///< with the points of moving images; 0 before the first pick, or frame that is traced
  std::size_t levels = 0;   ///< clusters and levels of detail of meshes, in main memory
  std::size_t scratch = 0;  ///< buffers that all threads of the process keep from call to call: core/memory.h
};

/// The input of a frame: which view it shows, and where. Borrowed for the time of the call.
struct FrameInput {
  const core::View& view;  ///< that the image shows
  /// Culls by this view instead: the image then shows from `view` what lies in the view volume of this one, and with
  /// EngineConfig::drawing.culled_colour what the tests after the culler leave out. So one can look at culling from the
  /// side. Null, or a view that shows the same (core::same_image): culls by `view`.
  const core::View* cull_view = nullptr;
  const gl::ExternalTarget* target = nullptr;  ///< a framebuffer that gets the image, too; null: none
  /// The view is at rest though it differs from the last one, as those shifted views do whose mean has smooth edges.
  /// With EngineConfig::losses.budget_ms the frame then draws what a second frame of the view would, and makes no
  /// image of a moving view first unless that has all pixels.
  bool at_rest = false;
};

struct EngineState;

class SIGHTLINE_API Engine {
 public:
  /// Progress callback with a value from 0 to 1, called now and then by the thread that calls create(). Returning false
  /// before 1 makes that fail.
  using Progress = std::function<bool(double)>;
  /// Commits the scene's pending edits and builds everything the plan names. The scene must outlive the engine. Fails
  /// with the scene's error, or GL's when drawing was asked for (also when this build has no GL).
  static core::Expected<Engine> create(core::Scene& scene, const EngineConfig& config = {},
                                       const Progress& progress = {});

  Engine(Engine&&) noexcept;
  Engine& operator=(Engine&&) noexcept;
  ~Engine();

  /// Culls and, when drawing is on, draws into drawing()->target() without waiting for it.
  ///
  /// When the context is lost (gl::Context::lost), the engine drops everything in it. Until the context is replaced,
  /// the CPU culls and nothing is drawn. An engine that made the context itself makes another one and tries that twice
  /// a second; for the application's context call use_context(). visible(), queries and edits work all the time.
  ///
  /// Fails when GL does, such as without memory on the GPU. What is loaded stays, visible() has what the CPU finds, and
  /// the next call goes on, also after edits that could not be uploaded.
  core::Expected<FrameReport> frame(const core::View& view);
  /// Overload for a frame with a culling view or a target, or both: see FrameInput and the next function.
  core::Expected<FrameReport> frame(const FrameInput& input);
  /// As frame(view), and puts the image into a framebuffer of the application's context (gl/external_target.h),
  /// with the depth test, in the order of GL's commands: what the application draws there before and after hides, and
  /// is hidden by, what the scene shows. The image gets the target's size. Several engines, views and framebuffers
  /// may take turns: see use_image(). Items with transparent materials are dithered, so
  /// they show the application's pixels, too. Works on all paths; read_colour() and the like read the engine's own
  /// image.
  ///
  /// Fails without EngineConfig::draw and EngineConfig::context.application, on sizes that the context does not
  /// support, and on framebuffers that GL does not draw to. Then nothing is drawn there. Nothing is drawn while the
  /// context is lost.
  core::Expected<FrameReport> frame(const core::View& view, const gl::ExternalTarget& target);
  /// Draws several views of one moment, such as the two eyes of a headset: view i goes into target i, which may be
  /// a layer of a texture, and has image i of use_image(). EngineConfig::losses.budget_ms is for all of them
  /// together. Needs as many targets as views. Where one fails, those before it are drawn. Which image is in use does
  /// not change.
  core::Expected<std::vector<FrameReport>> frame(std::span<const core::View> views,
                                                 std::span<const gl::ExternalTarget> targets);
  /// Shows another one of the engine's images from now on; each has a number of the application's, at first 0.
  /// Frames, read_colour() and the like, resize(), loss() and draw_outline() are about the image in use. One for each
  /// view keeps what the engine learns from frame to frame: its size, a budget's unfinished image, what was large or
  /// seen in the last frame. A new one has the size of the one before. It takes as much GPU memory as its pixels do.
  /// Fails as resize(); then the image in use stays.
  core::Expected<void> use_image(std::uint32_t number);
  /// Frees what the engine has for an image. Fails for the one in use.
  core::Expected<void> forget_image(std::uint32_t number);
  /// Draws a line around items, as ItemStyle::outline has it, over a framebuffer of the application's context: for what
  /// is under a cursor, where a frame would take too long. `view` and the target's size must be those of the last
  /// frame's image, which the framebuffer should show and which stays as it is. Takes the time of these items and of
  /// two passes over the image. Nothing is tested against the framebuffer's depth. Only builds with GL have it.
  ///
  /// Fails as frame(view, target), on another size, and with an item that is unknown as of the last commit(). Then, and
  /// while the context is lost, nothing is drawn.
  core::Expected<void> draw_outline(const core::View& view, std::span<const core::ItemId> items,
                                    const gl::ExternalTarget& target);
  /// What EngineConfig::losses cost the image of the last frame(), `view` being the one that it drew. What levels of
  /// detail cost is known once the image is drawn.
  ///
  /// With min_projected_area or budget_ms also what these have left out. Splats drawn instead count as left out. The
  /// pixels are the sum of the items' areas as culling/occlusion/contribution.h measures them, so they are too many
  /// where items overlap or hide each other, or reach out of the image. A convex solid may cover twice its measure in
  /// an unlucky direction. Waits for the GPU and takes time in proportion to the items left out: meant for images that
  /// stay.
  core::Expected<LossReport> loss(const core::View& view);
  /// What culling makes of each item in the view (culling/cull_states.h), by the slots of snapshot(): the culler, then
  /// contribution, sample test and occlusion as configured, the latter two with `draw` alone. A budget does not count,
  /// nor hysteresis. Draws an image for that, so that the last frame's is gone. Time is in proportion to all slots.
  core::Expected<culling::CullStates> cull_states(const core::View& view);
  /// Draws a tile of an image of `whole` that may be larger than any framebuffer: the tile has the engine's size, and
  /// read_colour() and the like read it. image_tiles() tells which tiles join without seams.
  ///
  /// A pixel is as frame(whole) has it in one image, but for rounding: corners of triangles move by up to two grains
  /// of the rasteriser (1/256 of a pixel in most), and rays by units in the last place of float. So some pixels at
  /// edges show the other side, and colours may differ in the last bit. `whole` is as wide as part.width / part.height
  /// says. With a budget, a part is complete when FrameReport::pending is 0. Fails on numbers that are not finite, and
  /// unless width and height are above 0.
  core::Expected<FrameReport> frame_tile(const core::View& whole, const ImageTile& tile);
  /// The oldest result of the GPU culler that was not yet taken; results arrive some frames late. Nothing while none
  /// has arrived. Never waits. Keeps the newest 64 results.
  std::optional<LateReport> take_late_report();

  /// Commits the scene's pending edits, and applies all edits that anybody has committed since this engine's last
  /// commit(). Takes time in proportion to their number: see Snapshot::apply. Frames show no edit before that. With
  /// drawing on, only what was edited is uploaded, and the triangles of meshes that no item has any more make room for
  /// others. Memory that is full is enlarged by half, which the GPU copies; the first item of its kind has its program
  /// compiled.
  ///
  /// After many edits the engine makes a new scene version in the background (EngineConfig::culling.rebuild_share). It
  /// works on a copy of the snapshot, so the scene may be edited meanwhile. Once it is ready, commit() and frame()
  /// upload what it needs, a quarter of a frame's time in each and 8 ms at most, but for single steps (making the GPU
  /// culler); then it lands as an exchange of pointers. Slots change with it: visible() names the generation of the
  /// snapshot that its slots belong to.
  core::Expected<void> commit();
  /// Follows edits in portions, for a thread that must not stop: works for about `seconds` and returns whether all
  /// edits are followed. Frames show those that are, and a mesh once it is uploaded as a whole; call it again for the
  /// others, which are then read as the scene has them. Edits are validated piece by piece, too: where one is refused,
  /// those before it are followed. Longer than that take single steps: arrays of a scene that outgrow their headroom, a
  /// node with very many items of its own, removed materials, a tracer for picks, and what a culler on the GPU needs.
  core::Expected<bool> commit(double seconds);
  /// Makes a new scene version at once, the one that a new engine would have. Stops a rebuild in the background.
  core::Expected<void> rebuild();
  /// True while a new scene version is being made or waits to land.
  bool rebuilding() const;

  /// Uses another culler from the next frame on. Makes what that culler lacks. What the former culler had is kept until
  /// the next new scene version, so that changing back costs next to nothing. A hybrid that comes begins to learn anew.
  /// Stops a rebuild in the background if the plan's culler changes; the next commit() begins it again. Fails where
  /// create() would; then nothing has changed. The same as configure() with that culler.
  core::Expected<void> set_culler(CullerChoice choice);
  const EngineConfig& config() const;
  /// Uses other settings from the next frame on: culler, controller, sample_test, occlusion, min_projected_area,
  /// contribution_mode, budget_ms, lod_error, culled_colour, outline_colour and looks. The others
  /// must be as they are (config()). What that needs is made, as in set_culler(). A rebuild in the background goes on
  /// unless the plan names another culler. A hybrid keeps what it has learnt unless controller, sample_test, occlusion
  /// or the plan's culler change. Fails where create() would, and on other changes; then nothing has changed.
  core::Expected<void> configure(const EngineConfig& config);
  /// Draws in another size, in pixels, from the next frame on. The old image is gone. Fails on sizes that the context
  /// does not support; then nothing has changed.
  core::Expected<void> resize(int width, int height);

  // --- overrides: what this engine alone shows otherwise than the scene says ---------------------------------------
  // Items keep their style and stay hidden whatever is edited, and in every new scene version and context, until they
  // are removed. Items that are inserted later have no style and show. Next frame on; time is in proportion to the
  // items. All fail with an id or handle that is unknown as of the last commit(), naming it; then nothing has changed.
  // For what hangs on nodes ask items_below().

  /// Gives items a style, in place of the one that they have. Fails, too, unless colour and alpha are within 0 … 1.
  core::Expected<void> set_override(std::span<const core::ItemId> items, const ItemStyle& style);
  core::Expected<void> clear_override(std::span<const core::ItemId> items);
  core::Expected<void> clear_overrides();  ///< of all items; hidden ones stay hidden
  /// Hidden items are not drawn, hide nothing, and no query or pick finds them.
  core::Expected<void> hide(std::span<const core::ItemId> items);
  core::Expected<void> show(std::span<const core::ItemId> items);  ///< unless the scene hides them
  /// Hides all items but those below the nodes, and shows these.
  core::Expected<void> isolate(std::span<const core::NodeId> nodes);
  core::Expected<void> show_all();

  /// The style that set_override() gave an item; none where it shows as the scene says.
  std::optional<ItemStyle> override_of(core::ItemId item) const;
  std::vector<core::ItemId> overridden_items() const;  ///< those with one, in rising order
  bool is_hidden(core::ItemId item) const;             ///< by hide() or isolate(), not by the scene
  std::vector<core::ItemId> hidden_items() const;      ///< in rising order

  /// The items that hang on the nodes and on all nodes below them, in rising order: those that are known as of the last
  /// commit(). Reads the scene. Fails with a handle that is stale.
  core::Expected<std::vector<core::ItemId>> items_below(std::span<const core::NodeId> nodes) const;

  /// What the view shows at a point of the image: the item hit first (engine/pick.h). In pixels from the upper
  /// left corner; the middle of the first pixel is at 0.5, 0.5. The image has the size of EngineConfig or resize().
  /// The view's layers and section planes count, transparency does not, and ghosts do on request. Nothing where the ray
  /// hits nothing; lines are never hit. Works with and without drawing. Fails as core::image_ray() does.
  ///
  /// The first pick builds the tracer, about 0.8 s of one processor per million items, unless prepare_picks() has. From
  /// then on commits keep it up, and new scene versions come with theirs. Only builds with SIGHTLINE_RAYTRACE have
  /// these functions.
  core::Expected<std::optional<Pick>> pick(const core::View& view, double x, double y, Ghosts ghosts = Ghosts::kPassed);
  /// What a ray hits first. Without a filter: items of the default layers.
  core::Expected<std::optional<Pick>> pick(const core::Ray& ray);
  core::Expected<std::optional<Pick>> pick(const core::Ray& ray, const raytrace::RayFilter& filter,
                                           Ghosts ghosts = Ghosts::kPassed);

  /// Begins to build the tracer on another thread, unless there is one. Until it is there, picks wait for it; frames do
  /// not. Commits and overrides stop it, which takes some milliseconds, and begin it anew; after the eighth time they
  /// wait for it. The engine's end stops it, too.
  void prepare_picks();
  /// Whether that is going on, so that a pick would wait.
  bool preparing_picks() const;

  /// Items in a rectangle of the image, in rising order, hidden behind others or not: those with any part in it, or
  /// those wholly in it, as culling/queries/region_query.h promises. The view's layers and section planes count. Needs
  /// no tracer. Fails as culling::rectangle_view() does.
  core::Expected<std::vector<core::ItemId>> items_in(const core::View& view, const PixelRectangle& rectangle,
                                                     culling::RegionRule rule) const;
  /// Items of `layers` in what all planes keep, at most core::kMaxSectionPlanes; else fails.
  core::Expected<std::vector<core::ItemId>> items_in(std::vector<core::Plane> planes, culling::RegionRule rule,
                                                     std::uint32_t layers = core::kDefaultLayerMask) const;
  /// Items that a rectangle of the image shows, rounded outwards to whole pixels, with their samples, in rising
  /// order: raytrace::ExactVisibility on `samples` a pixel. Never ghosts. As pick() otherwise.
  core::Expected<std::vector<raytrace::VisibleItem>> visible_items_in(const core::View& view,
                                                                      const PixelRectangle& rectangle, int samples = 1);

  /// Frees everything that the engine has in the application's context, which must be current. Frames are then as after
  /// a loss. An application that destroys its gl::Context need not call this; one whose GL context lives on should.
  void drop_context();
  /// Makes everything anew in another context of the application's, in place of a lost or dropped one. It must be
  /// current. Fails with GL's error; then nothing has changed.
  core::Expected<void> use_context(gl::Context& context);
  /// Moves to a context in portions, for a thread that must not stop: works for about `seconds` and returns whether
  /// everything is made. While it is not, call it again with the same context, with frames of other engines or the
  /// application's own in between; until then this engine is as it was, and everything may be asked of it. Longer than
  /// that take single steps: compiling a program, the corners of one mesh, making the GPU culler. The first frame is
  /// then no slower than others, even where drivers compile late.
  ///
  /// Edits in between are followed. A new scene version makes it begin anew. Fails as above, and when the context is
  /// lost meanwhile; the next call then begins anew.
  core::Expected<bool> use_context(gl::Context& context, double seconds);

  /// Tells that the application drew nothing for a while (a pause, a dialog): the next frame_ms does not count that
  /// time, and a hybrid does not learn from the next frame.
  void paused();

  /// Waits until everything submitted is drawn.
  void finish();
  /// Waits until the levels of detail that EngineConfig::losses.lod_error asks for are built, about 3 us a triangle on
  /// one core, and uploaded: then frames need not begin with whole meshes. Fails when the GPU has not enough memory.
  core::Expected<void> finish_levels();

  const Plan& plan() const;
  const core::Snapshot& snapshot() const;
  const core::VisibleSet& visible() const;  ///< empty when the GPU culls
  /// The last frame's image (render/image/image.h). Only builds with GL have these functions. They wait for the GPU.
  /// They fail without EngineConfig::draw, and while the context is lost.
  core::Expected<image::Image> read_colour();
  core::Expected<image::IdImage> read_ids();  ///< fails without EngineConfig::drawing.ids, too
  /// Distances along the axis of `view`, which is the one that was drawn.
  core::Expected<image::DepthImage> read_depth(const core::View& view);
  /// Whether any pixel shows anything but the background.
  core::Expected<bool> covered();
  /// GL's name of the framebuffer with the image, one value per pixel, in the context that the engine draws with.
  core::Expected<std::uint32_t> framebuffer();

  /// As GL names it; empty while there is no context.
  std::string renderer();
  /// What the driver has complained of since the last call: see EngineConfig::context.gl_debug.
  std::vector<std::string> take_gl_errors();

  MemoryReport memory() const;
  const culling::Controller* controller() const;  ///< of the hybrid; null without one

 private:
  friend class EngineParts;
  explicit Engine(std::unique_ptr<EngineState> state);

  std::unique_ptr<EngineState> state_;
};

}  // namespace sightline::engine
