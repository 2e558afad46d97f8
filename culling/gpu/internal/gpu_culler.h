// culling/gpu: culling on the GPU, in OpenGL 4.5 core. The result stays on the GPU.
//
// Records are tested in clusters of 64 consecutive ones: first the cluster's box, then, unless it is outside, the boxes
// of its records. So cost follows what is visible, except for 1/64 of the records. There are two variants, one in
// vertex and geometry stages and one in compute shaders (GpuVariant). Both give the same answer in the same order. What
// is found, record ids or the draw commands of meshes, goes straight into gpuscene::DrawLists, which make draw commands
// of it on the GPU. Nothing is read back and nothing is waited for. The CPU's work per frame does not depend on the
// number of items.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/culling/frustum/frustum_test.h"
#include "sightline/culling/gpu/gpu_culler_config.h"
#include "sightline/culling/gpu/internal/gpu_bounds.h"
#include "sightline/culling/gpu/internal/gpu_occlusion.h"
#include "sightline/culling/occlusion/sample_test.h"
#include "sightline/gl/internal/timer.h"
#include "sightline/gpuscene/internal/draw_lists.h"
#include "sightline/gpuscene/internal/gpu_scene.h"
#include "sightline/lod/internal/cut.h"

namespace sightline::culling {

class GpuPass;
class MeshParts;
struct CullBatch;

/// Promise: conservative, and nearly the answer of CpuCuller. An item is culled only when the float form of CullPlanes
/// surely rejects it, with twice its band and room for flushed denormals. The reason: GLSL leaves rounding mode and
/// denormals to the driver (The OpenGL Shading Language 4.50, section 4.7.1). So no item of the CPU's set is ever
/// missing. Each further item has a corner within that band of a plane: some 10^-6 of the scene's size.
///
/// GLSL also evaluates the sample test with bands of its own (screen_box.glsl), and by rectangles
/// alone, without the rays of pixels. So it keeps some items that SampleTest leaves out.
///
/// Occlusion is tested in two passes a frame, and nothing pops: cull() finds what the frame before has found open, and
/// once that is drawn, cull_others() tests everything in the view volume against its depth, and finds what is open
/// besides. What was drawn first is tested again, so that the set drawn first follows what is open. The rule is that of
/// OcclusionTest, with the bands of the sample test. What the culler remembers decides only which pass draws an item,
/// so edits, other sizes of the image and frames without the test cannot lose any.
///
/// Meshes that have levels of detail are drawn by parts, clusters of these (mesh_parts.h): those of a cut within the
/// allowed error that lie in the view volume and are selected as items are. Where placements scale unequally, or where
/// float leaves the choice open, it is finer than lod::CutChooser's, never coarser.
///
/// The context must be current in all calls. cull() changes this state and leaves it changed: program, texture units 0
/// to 5, uniform blocks 1 to 3; the geometry variant also vertex array, framebuffer, transform feedback and, with
/// occlusion, shader storage blocks 0 and 5, the compute variant shader storage blocks 0 to 5.
class GpuCuller {
 public:
  /// For `scene`, made from `snapshot`. Fails when the GPU has too little memory, or when the context cannot do the
  /// variant asked for (compute: a storage block's size limits the records of a batch).
  ///
  /// Without a variant in `config`, both are made, measured and compared by
  ///     cost = alone + max(0, blocked - submitted)
  /// in milliseconds of wall clock. The measured cull is one of half of the scene's surroundings. `alone` is its time
  /// from submission until the GPU is done, `submitted` the submission's part of that. `blocked` is the submission's
  /// time while the GPU is still busy with drawing of some milliseconds, for which some drivers wait at a barrier. Each
  /// is the least of a few interleaved repetitions. The measurement waits for the GPU, for about ten culls.
  static core::Expected<GpuCuller> create(const gl::Context& context, const core::Snapshot& snapshot,
                                          const gpuscene::GpuScene& scene, const GpuCullerConfig& config = {});

  GpuCuller(GpuCuller&&) noexcept;
  GpuCuller& operator=(GpuCuller&&) noexcept;
  ~GpuCuller();

  /// Applies an edit of `touched` slots (Snapshot::apply). Call it after GpuScene::append and update; it changes the
  /// same GL state. Slots with a bit in `left_out` are never found; those whose bit has changed must be touched. Fails
  /// when the GPU has too little memory for layers that came into use; then make a new culler.
  core::Expected<void> update(const core::Snapshot& snapshot, const gpuscene::GpuScene& scene,
                              std::span<const core::Slot> touched, SlotBits left_out = {}) {
    return follow(snapshot, scene, touched, left_out, &GpuBounds::update);
  }
  /// Follows edits that move no slot, but make some vacant or left out, or no longer so. Faster.
  core::Expected<void> update_shown(const core::Snapshot& snapshot, const gpuscene::GpuScene& scene,
                                    std::span<const core::Slot> touched, SlotBits left_out) {
    return follow(snapshot, scene, touched, left_out, &GpuBounds::update_shown);
  }

  /// The image that shows what is culled.
  struct Image {
    core::View view;
    ImageSamples samples;
    bool occlusion = false;  ///< only with one sample per pixel, at its centre, and if can_test_occlusion()
  };

  /// Compiles the programs of cull() with an image, or without one, which its first call does otherwise.
  core::Expected<void> prepare(bool for_image, bool occlusion = false);
  /// False where the variant would need storage blocks in vertex stages and the context has none.
  bool can_test_occlusion() const;

  /// What a cull is for.
  struct For {
    std::uint64_t frame = 0;                 ///< comes back with the feedback
    const Image* image = nullptr;            ///< the image that shows what is culled, if there is one
    const lod::ImageError* error = nullptr;  ///< of the view that is drawn; without one, meshes are drawn in full
  };
  /// Fills `lists` with what `view` can see. With an image it leaves out items that cover none of its samples, except
  /// lines. With Image::occlusion it leaves out what was not found open in the frame before, and cull_others() must
  /// follow. The first call after meshes have got levels takes these in, which does what update() does. Submits the
  /// work and returns. Fails when the GPU has too little memory for the lists.
  core::Expected<void> cull(const core::View& view, const core::Snapshot& snapshot, const gpuscene::GpuScene& scene,
                            gpuscene::DrawLists& lists, const For& what = {0, nullptr, nullptr});

  /// Goes on with the frame of the last cull(), which had the same `image`, once its lists are drawn. Fills `lists`
  /// with the items that are not in them and that `depth` does not hide. `depth`: reverse-Z, of the image's size.
  /// `error`: metres by which its distances may be off, as in orthographic views. Submits the work and returns. Fails
  /// as cull() does.
  core::Expected<void> cull_others(const Image& image, const gpuscene::GpuScene& scene, gpuscene::DrawLists& lists,
                                   const gl::Texture2D& depth, double error);

  /// What became known of an earlier cull(), and of cull_others() after it.
  struct Feedback {
    std::uint64_t frame = 0;        ///< For::frame of cull()
    std::uint64_t visible = 0;      ///< items in the view volume
    std::uint64_t items_drawn = 0;  ///< of these, items in the lists
    std::optional<double> time_ms;  ///< on the GPU; none on software rasterisers, whose timer queries mean nothing
  };
  /// The oldest feedback not yet taken, in order; nothing until the GPU is done with it. Never waits. A few results can
  /// wait to be taken. While these places are full, further calls of cull() give no feedback.
  std::optional<Feedback> take_feedback();

  /// The set that the last cull() put into `lists`, as single slots only; an item that is drawn by parts once for each.
  /// Waits for the GPU: for tests and tools.
  core::VisibleSet read_back(const gpuscene::DrawLists& lists) const;

  GpuVariant variant() const;
  /// False when the variant could not be measured, for example without items: then let the next culler measure again.
  bool variant_settled() const { return variant_settled_; }
  /// "asked for", or what was measured, or why it could not be measured.
  const std::string& why_this_variant() const { return why_this_variant_; }
  std::size_t memory_bytes() const;

 private:
  /// The feedback of one cull() under way.
  struct Probe {
    std::uint64_t frame = 0;
    bool timed = false, others_timed = false, skipped = false;  // skipped: nothing could be visible
    std::optional<double> time_ms, others_time_ms;
  };

  using UpdateBounds = void (GpuBounds::*)(const core::Snapshot&, std::span<const std::uint32_t>,
                                           gpuscene::ElementWriter&, SlotBits);
  GpuCuller();
  core::Expected<void> follow(const core::Snapshot& snapshot, const gpuscene::GpuScene& scene,
                              std::span<const core::Slot> touched, SlotBits left_out, UpdateBounds update_bounds);
  core::Expected<void> make_batches(const core::Snapshot& snapshot, const gpuscene::GpuScene& scene);
  core::Expected<void> add_batch(const core::Snapshot& snapshot, const gpuscene::GpuScene& scene,
                                 const gpuscene::Batch& batch, std::vector<core::Slot> slots);
  core::Expected<void> use_compute_alone(const gl::Context& context, const core::Error& why);
  core::Expected<void> choose_variant(const gl::Context& context, const core::Snapshot& snapshot,
                                      const gpuscene::GpuScene& scene);
  core::Expected<void> follow_levels(const core::Snapshot& snapshot, const gpuscene::GpuScene& scene);
  void write_commands(CullBatch& batch, const gpuscene::MeshPool& pool, std::span<const std::uint32_t> records);
  void upload_planes(const core::View& view, const CullPlanes& planes, const core::ItemBounds& bounds,
                     const lod::ImageError* error) const;
  CullBatch* mesh_batch();
  MeshParts* parts();
  core::Expected<void> prepare_occlusion();
  core::Expected<void> begin_occlusion();
  core::Expected<void> upload_pyramid(const Image& image, const gl::Texture2D& depth, double error);
  core::Expected<void> write_block(gl::Buffer& block, std::size_t bytes, const void* data, GLuint binding) const;
  core::Expected<void> upload_image(const Image& image, const core::ItemBounds& bounds);
  std::size_t next_probe(std::uint64_t frame);

  const gl::Functions* gl_ = nullptr;
  std::vector<CullBatch> batches_;
  gpuscene::ElementWriter writer_;
  core::Slot slot_count_ = 0;
  bool uses_layers_ = false;
  std::uint64_t pool_version_ = 0;      // MeshPool::version() that commands and parts follow
  std::size_t most_mesh_commands_ = 0;  // that shaders can address
  std::unique_ptr<GpuPass> pass_;
  bool variant_settled_ = true;
  std::string why_this_variant_ = "asked for";
  gl::Buffer plane_block_, screen_block_;  // screen_block_: made when first used
  std::vector<Probe> probes_;              // a ring, and one more that nobody reads, for when it is full
  std::size_t first_probe_ = 0, pending_ = 0, last_probe_ = 0;
  std::optional<gl::GpuTimer> timer_, others_timer_;
  bool vertex_storage_ = false;  // vertex stages may have storage blocks
  // State of the occlusion test, made when it is first used:
  std::optional<GpuDepthPyramid> pyramid_;
  gl::Buffer occlusion_block_;
  std::uint32_t occlusion_frame_ = 1;
};

}  // namespace sightline::culling
