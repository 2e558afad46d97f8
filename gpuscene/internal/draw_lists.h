// The visible set on the GPU: indirect commands and record ids that say which records each batch draws.
//
// Ray-cast batches draw points without attributes. gl_VertexID names the record, and one command draws a range of
// records: its base vertex is the first of them. Vertex ids beyond the batch's records name places in the list of
// single records, which shaders read through a buffer texture. Lines do the same with two vertices per record, and so
// do ray-cast batches with eight where no geometry stage is to be used (record_commands.h). Meshes get their record as
// an attribute with divisor 1, offset by the command's base instance.
//
// Two sources can fill the lists: update() from a visible set of the CPU, or a culler on the GPU. The GPU culler writes
// record ids (whole commands for meshes) to target() between begin_gpu_update() and end_gpu_update(), and nothing of
// that returns to the CPU. The renderer draws both in the same way, since commands and record ids have the same form.
// Only the GPU then knows how many commands of a section are in use. With ARB_indirect_parameters the draw reads the
// number from counts(); without it the unused commands draw nothing.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/visible_set.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/shader_source.h"
#include "sightline/gl/internal/transform_feedback.h"
#include "sightline/gl/internal/vertex_array.h"
#include "sightline/gpuscene/internal/gpu_scene.h"
#include "sightline/gpuscene/internal/ring_buffer.h"
#include "sightline/gpuscene/internal/visible_records.h"

namespace sightline::gpuscene {

/// The caller's choice of what is drawn of a visible set's meshes, each in runs one behind another. Borrowed during
/// DrawLists::update().
struct MeshDraws {
  template <class T>
  using Runs = std::span<const std::span<const T>>;
  Runs<ElementsCommand> fronts = {};      ///< of these, only front faces are drawn
  Runs<ElementsCommand> both_faces = {};  ///< these come after them
  Runs<std::uint32_t> indices = {};       ///< that commands count in, uploaded for this image; none: the scene's
};

class DrawLists {
 public:
  /// Where the commands (ElementsCommand) of a batch lie in commands().
  struct Section {
    std::size_t offset = 0;  ///< bytes
    int count = 0;           ///< commands, used or not; 0: nothing to draw
    bool counted = false;    ///< counts() holds the number in use, at command_count_offset()
    int front_only = 0;      ///< meshes: number of first commands that show front faces only
  };
  /// Where a culler on the GPU writes its result for a batch, from the start and without gaps.
  struct Target {
    GLuint buffer = 0;
    std::size_t offset = 0, size = 0;  ///< bytes; room for all records: uint32 ids, or commands for meshes
  };

  /// Who counts what a culler on the GPU writes.
  enum class Counting : std::uint8_t {
    kSearch,  ///< end_gpu_update() searches for the end of each list
    kCuller,  ///< the culler, which also writes counts() and the index counts of commands(), see gpu_sections()
  };

  static core::Expected<DrawLists> create(const gl::Context& context, const GpuScene& scene);

  /// Uploads what draws the records, and the meshes as given. Fails when the GPU has not enough memory; then the lists
  /// are empty.
  core::Expected<void> update(const GpuScene& scene, const VisibleRecords& records, const MeshDraws& meshes);
  /// Does so for a visible set of `snapshot`, the one that `scene` was made from, with all triangles of its meshes.
  core::Expected<void> update(const core::Snapshot& snapshot, const GpuScene& scene, const core::VisibleSet& visible);

  /// Marks all places of the targets as unused. With Counting::kCuller it marks only those that draws would read:
  /// commands of meshes without ARB_indirect_parameters. The first call allocates room for all of `scene`, and the
  /// first with Counting::kSearch compiles programs. `parts`: the target of meshes has room for so many commands
  /// besides one per record; it must not become less. Fails when the GPU has not enough memory; then the lists are
  /// empty.
  core::Expected<void> begin_gpu_update(const GpuScene& scene, Counting counting = Counting::kSearch,
                                        std::size_t parts = 0);
  Target target(BatchKind kind) const;  ///< of a batch that `scene` has
  /// Makes draw commands from what was written, on the GPU. With Counting::kSearch a complete framebuffer must be
  /// bound, and the call changes: program, vertex array, transform feedback, texture units 0 and 1.
  void end_gpu_update(const GpuScene& scene);

  /// Per batch kind: first command (in commands(), where those of meshes come last), first place of single records,
  /// number of places (0: no such batch), indices per record (0 for meshes). With Counting::kCuller the culler must
  /// write, between begin and end: both numbers in counts() for every kind, and the index count of every command of
  /// record batches. The index count is the command's first word, 0 for commands not in use. shaders/draw_commands.glsl
  /// computes these.
  using GpuSections = std::array<std::array<std::uint32_t, 4>, kBatchKindCount>;
  const GpuSections& gpu_sections() const { return gpu_.sections; }
  /// Number of commands of all record batches.
  std::size_t record_command_count() const { return gpu_.record_commands; }
  /// The files of gpuscene/shaders, with the defines that the shaders of draw lists need.
  static gl::ShaderContext shader_context();
  static std::vector<gl::PipelineDescription> all_programs();
  /// Makes the lists of the CPU empty and frees their memory: where a scene has become much smaller.
  void trim();
  /// Makes the lists empty.
  void clear() { sections_ = {}; }

  const Section& section(BatchKind kind) const { return sections_[std::size_t(kind)]; }
  const gl::Buffer& commands() const { return from_gpu_ ? gpu_.commands : commands_.buffer(); }
  /// Single records, R32UI. Record number batch.count + i names place i.
  const gl::TextureBuffer& singles() const { return from_gpu_ ? gpu_.single_texels : single_texels_; }
  /// Pairs of uint32 per batch kind, written by the GPU: commands in use, records found.
  const gl::Buffer& counts() const { return gpu_.counts; }
  static std::size_t command_count_offset(BatchKind kind) { return 2 * std::size_t(kind) * sizeof(std::uint32_t); }
  static std::size_t record_count_offset(BatchKind kind) { return command_count_offset(kind) + sizeof(std::uint32_t); }
  /// Triangle indices, uint32: those of the scene, or the ones that were picked for the image.
  const gl::Buffer& mesh_indices(const GpuScene& scene) const {
    return picks_ && !from_gpu_ ? picked_indices_.buffer() : scene.meshes().indices();
  }
  /// In 16 bits: the indices of all batches except meshes. Empty when there are none.
  const gl::Buffer& record_indices() const { return record_indices_; }
  /// 0, 1, 2, … up to the mesh batch's capacity: the instance attribute of meshes.
  const gl::Buffer& mesh_instances() const { return mesh_instances_; }
  std::size_t memory_bytes() const;
  /// The part of these bytes that the first update() makes at least.
  static constexpr std::size_t first_update_bytes() {
    return RingBuffer<ElementsCommand>::bytes(kLeastCommands) + RingBuffer<std::uint32_t>::bytes(kLeastSingles);
  }

 private:
  void list_records(const Batch& batch, const VisibleRecords::OfBatch& found, std::size_t single);
  core::Expected<void> list_meshes(const MeshDraws& meshes);
  void append_records(BatchKind kind, std::uint32_t first, std::uint32_t count);
  core::Expected<void> upload();
  core::Expected<void> reserve_singles(std::size_t count);
  core::Expected<void> make_gpu_lists(const GpuScene& scene, std::size_t parts);
  core::Expected<void> make_search();
  core::Expected<void> make_search_programs();
  void search();
  void write_gpu_templates(const GpuScene& scene);

  const gl::Functions* gl_ = nullptr;
  gl::Buffer record_indices_, mesh_instances_;
  static constexpr std::size_t kLeastCommands = 256, kLeastSingles = 1024;
  RingBuffer<ElementsCommand> commands_{"draw commands", kLeastCommands,
                                        4};  // levels of detail need more from view to view
  RingBuffer<std::uint32_t> singles_{"visible records", kLeastSingles, 3};
  gl::TextureBuffer single_texels_;
  std::array<Section, kBatchKindCount> sections_;
  std::vector<ElementsCommand> command_list_;
  bool picks_ = false;  // meshes are drawn by picked_indices_
  RingBuffer<std::uint32_t> picked_indices_{"triangles that show", 0, 3};

  /// Buffers that the GPU fills. One copy is enough: the GPU works in order.
  struct GpuLists {
    gl::Buffer commands, singles, counts;  // commands of all record batches, then those of meshes
    gl::TextureBuffer single_texels;
    // For Counting::kSearch:
    gl::TextureBuffer command_texels;
    gl::Program write_commands, count_records;
    gl::TransformFeedback command_feedback, count_feedback;
    gl::VertexArray array;  // without attributes
    GpuSections sections{};
    std::array<std::size_t, kBatchKindCount> command_count{};
    std::array<std::uint32_t, kBatchKindCount> records{};  // Batch::count at the time the templates were written
    std::size_t record_commands = 0, parts = 0;
  };
  GpuLists gpu_;  // empty until begin_gpu_update()
  bool from_gpu_ = false;
  Counting counting_ = Counting::kSearch;
};

}  // namespace sightline::gpuscene
