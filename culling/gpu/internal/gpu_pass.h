// What both variants of the GPU culler share, and the interface that hides their differences. Internal to culling/gpu.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/culling/gpu/gpu_culler_config.h"
#include "sightline/culling/gpu/internal/gpu_bounds.h"
#include "sightline/culling/gpu/internal/mesh_parts.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/timer.h"
#include "sightline/gpuscene/internal/draw_lists.h"

namespace sightline::culling {

/// What culling needs of a gpuscene::Batch: the boxes to test, for meshes the draw commands, and what was found open.
struct CullBatch {
  gpuscene::BatchKind kind;
  GpuBounds bounds;
  gl::TexelArray commands;                         ///< of all meshes; none of other batches
  std::vector<gpuscene::ElementsCommand> written;  ///< by record: what `commands` follow, as long as these
  gl::Buffer unoccluded_frames;                    ///< see occlusion_test.glsl; made with the first test of occlusion
  /// Parts of meshes that have levels; null where none has. Commands of records that are drawn by parts have no
  /// indices.
  std::unique_ptr<MeshParts> parts;

  bool meshes() const { return kind == gpuscene::BatchKind::kMesh; }
  std::size_t memory_bytes() const {
    return bounds.memory_bytes() + commands.buffer.size() + unoccluded_frames.size() +
           (parts ? parts->memory_bytes() : 0);
  }
};

/// Records of a batch, or the parts of their meshes: what a pass tests at a time.
struct CullList {
  const CullBatch& batch;
  bool parts;

  std::uint32_t cluster_count() const { return parts ? batch.parts->cluster_count() : batch.bounds.cluster_count(); }
};

/// Which items of the view volume a pass writes.
enum class Selection : std::uint8_t {
  kAll,
  kSampled,           ///< those that may cover a sample of the image, and lines
  kUnoccludedBefore,  ///< of these, those that kUnoccludedNow has found unoccluded in the frame before, and lines
  kUnoccludedNow,     ///< finds all that the pyramid does not hide, and writes those that kUnoccludedBefore has not
                      ///< written
};
inline constexpr std::size_t kSelectionCount = 4;
constexpr bool tests_occlusion(Selection selection) {
  return selection == Selection::kUnoccludedBefore || selection == Selection::kUnoccludedNow;
}

/// Whether a pass counts the items of the view volume apart from those that it writes.
constexpr bool counts_in_view(Selection selection) {
  return selection == Selection::kSampled || selection == Selection::kUnoccludedBefore;
}

/// Numbers of items.
struct Found {
  std::uint64_t in_view = 0;  ///< in the view volume
  std::uint64_t written = 0;  ///< of these, selected
};

/// Number of culls whose results may wait to be taken, and one more whose result nobody reads, for when these are full.
inline constexpr std::size_t kTakenProbes = gl::GpuTimer::kSlots, kProbes = kTakenProbes + 1;

/// One variant, made for batches of certain kinds and capacities.
class GpuPass {
 public:
  virtual ~GpuPass() = default;

  virtual GpuVariant variant() const = 0;
  virtual gpuscene::DrawLists::Counting counting() const = 0;
  /// Makes the programs of a selection, unless they are made, and room for all parts of meshes.
  virtual core::Expected<void> prepare(std::span<const CullBatch> batches, Selection selection) = 0;
  /// Fills the lists between their begin_gpu_update() and end_gpu_update(). The selection is prepared; the blocks with
  /// planes and image are bound, and the pyramid. kUnoccludedNow goes on with the probe of kUnoccludedBefore.
  virtual void run(std::span<const CullBatch> batches, const gpuscene::DrawLists& lists, Selection selection,
                   std::size_t probe) = 0;
  /// What the last run with this probe found, or the last two; nothing until the GPU is done with it. Never waits.
  virtual std::optional<Found> found(std::size_t probe) = 0;
  virtual std::size_t memory_bytes() const = 0;
};

/// Each fails when the context cannot do it, with the reason.
core::Expected<std::unique_ptr<GpuPass>> make_geometry_pass(const gl::Context& context,
                                                            std::span<const CullBatch> batches);
core::Expected<std::unique_ptr<GpuPass>> make_compute_pass(const gl::Context& context,
                                                           std::span<const CullBatch> batches);

/// The programs of each for all batches and selections.
std::vector<gl::PipelineDescription> geometry_programs();
std::vector<gl::PipelineDescription> compute_programs();

inline core::Expected<std::unique_ptr<GpuPass>> make_pass(GpuVariant variant, const gl::Context& context,
                                                          std::span<const CullBatch> batches) {
  return variant == GpuVariant::kCompute ? make_compute_pass(context, batches) : make_geometry_pass(context, batches);
}

/// Programs of batches are made for one of these.
enum class ProgramKind : std::uint8_t { kRecords, kMeshes, kParts };
inline constexpr std::size_t kProgramKinds = 3;
inline ProgramKind program_kind(const CullBatch& batch) {
  return batch.parts ? ProgramKind::kParts : batch.meshes() ? ProgramKind::kMeshes : ProgramKind::kRecords;
}

/// The program of meshes some of which are drawn by parts, that of other meshes, and the one of all other batches. Each
/// is made only once there are such batches.
class BatchPrograms {
 public:
  core::Expected<void> make(const gl::Functions& gl, std::span<const CullBatch> batches,
                            const std::function<gl::ProgramDescription(ProgramKind)>& describe);
  const gl::Program& of(const CullBatch& batch) const { return programs_[std::size_t(program_kind(batch))]; }

 private:
  std::array<gl::Program, kProgramKinds> programs_;
};

/// A program of one stage or more from the files of culling/gpu and gpuscene, with the defines of the draw lists and of
/// a selection.
gl::ProgramDescription describe_pass(std::string name, std::vector<gl::StageDescription> stages, ProgramKind kind,
                                     Selection selection = Selection::kAll);
/// Binds what a program that tests a list needs for a selection (selection.glsl).
void bind_selection(const gl::Functions& gl, const gl::Program& program, const CullList& list, Selection selection);

/// Texture units where shaders find a batch's data.
enum CullTextureUnit : GLuint {
  kClusterBoxUnit,
  kClusterLayerUnit,
  kItemBoxUnit,
  kItemLayerUnit,
  kCommandUnit,
  kPyramidUnit,
  kPartClusterUnit = kClusterLayerUnit,  // parts have no layers of their own, and commands in their details
  kPartDetailUnit = kCommandUnit,
};
/// Binds a list for a program of its batch.
void bind_list(const gl::Functions& gl, const gl::Program& program, const CullList& list);

}  // namespace sightline::culling
