// The GPU form of a visible set: which records each batch draws, as indirect commands and record ids.
//
// Ray-cast batches draw points without attributes: gl_VertexID names the record, and a range of records is a command
// whose base vertex is the range's first. Vertex ids beyond the batch's records name places in the list of single
// records, read through a buffer texture. Lines do the same with two vertices a record. Meshes bring their record as an
// attribute with divisor 1, offset by the command's base instance.
//
// Either of two fills the lists: update() from a visible set of the CPU, or a culler on the GPU, which writes record
// ids (of meshes whole commands) to target() between begin_gpu_update() and end_gpu_update(); nothing of that comes
// back to the CPU. The renderer draws both alike: commands and record ids have one form. How many commands of a section
// are in use is then known on the GPU alone: where the context has ARB_indirect_parameters the number is read from
// counts(), and elsewhere the unused ones draw nothing.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/shader_source.h"
#include "sightline/gl/internal/transform_feedback.h"
#include "sightline/gl/internal/vertex_array.h"
#include "sightline/gpuscene/internal/gpu_scene.h"
#include "sightline/gpuscene/internal/visible_records.h"

namespace sightline::gpuscene {

/// What lists will be drawn with.
struct DrawnView {
  const core::View& view;
  int width, height;  ///< of the target, pixels
  int samples = 1;    ///< per pixel
};

class DrawLists {
 public:
  /// Where a batch's commands lie in commands(), ElementsCommand each. Lines draw with indices too, 0, 1, 2, …
  struct Section {
    std::size_t offset = 0;  ///< bytes
    int count = 0;           ///< commands, used or not; 0: nothing to draw
    bool counted = false;    ///< the number in use lies in counts(), at command_count_offset()
    int front_only = 0;      ///< of meshes: so many of the first commands show front faces alone, see update()
  };
  /// Where a culler on the GPU writes what it finds of a batch, without gaps from the start.
  struct Target {
    GLuint buffer = 0;
    std::size_t offset = 0, size = 0;  ///< bytes; room for all records: ids, uint32, or of meshes commands
  };

  /// Who counts what a culler on the GPU writes.
  enum class Counting : std::uint8_t {
    kSearch,  ///< end_gpu_update() looks where each list ends
    kCuller,  ///< the culler itself, which also writes counts() and the index counts of commands(), see gpu_sections()
  };

  static core::Expected<DrawLists> create(const gl::Context& context, const GpuScene& scene);

  /// Translates and uploads a visible set of `snapshot`, from which `scene` was made. With `drawn`, what will be drawn
  /// with the lists, meshes are left out that cover no pixel's centre, and Section::front_only is known. Fails when the
  /// GPU has not the memory; then the lists are empty.
  core::Expected<void> update(const core::Snapshot& snapshot, const GpuScene& scene, const core::VisibleSet& visible,
                              const DrawnView* drawn = nullptr);

  /// Marks all places of the targets unused; of a culler that counts only where draws would meet them (commands of
  /// meshes without ARB_indirect_parameters). The first call makes room for all of `scene`, and the first to search
  /// compiles programs. Fails when the GPU has not the memory, then the lists are empty.
  core::Expected<void> begin_gpu_update(const GpuScene& scene, Counting counting = Counting::kSearch);
  Target target(BatchKind kind) const;  ///< of a batch that `scene` has
  /// Makes draw commands of what was written, on the GPU. When it has to search, a complete framebuffer must be bound,
  /// and it leaves changed: program, vertex array, transform feedback, texture units 0 and 1.
  void end_gpu_update(const GpuScene& scene);

  /// Per batch kind: first command (in commands(), whose members of meshes come last), first place of single records,
  /// places (0: no such batch), indices per record (0 of meshes). With Counting::kCuller, the culler writes between
  /// begin and end: for every kind both numbers of counts(); for every command of record batches the index count,
  /// its first word, which is 0 of those not in use. shaders/draw_commands.glsl says how they follow.
  using GpuSections = std::array<std::array<std::uint32_t, 4>, kBatchKindCount>;
  const GpuSections& gpu_sections() const { return gpu_.sections; }
  /// Commands of all record batches.
  std::size_t record_command_count() const { return gpu_.record_commands; }
  /// The files of gpuscene/shaders, with the defines that these of draw lists need.
  static gl::ShaderContext shader_context();
  /// Nothing to draw.
  void clear() { sections_ = {}; }

  const Section& section(BatchKind kind) const { return sections_[std::size_t(kind)]; }
  const gl::Buffer& commands() const { return from_gpu_ ? gpu_.commands : commands_; }
  /// Single records, R32UI; place i is named by record number batch.count + i.
  const gl::TextureBuffer& singles() const { return from_gpu_ ? gpu_.single_texels : single_texels_; }
  /// Pairs of uint32 per batch kind, written by the GPU: commands in use and records found.
  const gl::Buffer& counts() const { return gpu_.counts; }
  static std::size_t command_count_offset(BatchKind kind) { return 2 * std::size_t(kind) * sizeof(std::uint32_t); }
  static std::size_t record_count_offset(BatchKind kind) { return command_count_offset(kind) + sizeof(std::uint32_t); }
  /// 0, 1, 2, … in 16 bits: the indices of all batches but meshes; empty when there are none.
  const gl::Buffer& record_indices() const { return record_indices_; }
  /// 0, 1, 2, … up to the mesh batch's capacity: the instance attribute of meshes.
  const gl::Buffer& mesh_instances() const { return mesh_instances_; }
  std::size_t memory_bytes() const;

 private:
  void list_records(const Batch& batch);
  void list_meshes(const core::Snapshot& snapshot, const MeshPool& pool, const DrawnView* drawn);
  void append_records(BatchKind kind, std::uint32_t first, std::uint32_t count);
  void append(const ElementsCommand* commands, std::size_t count);
  core::Expected<void> upload();
  core::Expected<void> grow_singles(std::size_t capacity);
  core::Expected<void> make_gpu_lists(const GpuScene& scene);
  core::Expected<void> make_search();
  void search();
  void write_gpu_templates(const GpuScene& scene);

  static constexpr int kFramesInFlight = 3;  // so that no upload waits for the GPU to finish reading

  const gl::Functions* gl_ = nullptr;
  gl::Buffer commands_, singles_, record_indices_, mesh_instances_;
  gl::TextureBuffer single_texels_;
  std::size_t command_capacity_ = 0, single_capacity_ = 0;  // commands and ids per frame in flight
  int frame_ = 0;
  std::array<Section, kBatchKindCount> sections_;
  VisibleRecords visible_;
  std::vector<ElementsCommand> command_list_, both_faces_;
  std::vector<std::uint32_t> single_list_;

  /// What the GPU fills. One copy: the GPU does its work in order.
  struct GpuLists {
    gl::Buffer commands, singles, counts;  // commands of all record batches, then those of meshes
    gl::TextureBuffer single_texels;
    // To search:
    gl::TextureBuffer command_texels;
    gl::Program write_commands, count_records;
    gl::TransformFeedback command_feedback, count_feedback;
    gl::VertexArray array;  // without attributes
    GpuSections sections{};
    std::array<std::size_t, kBatchKindCount> command_count{};
    std::array<std::uint32_t, kBatchKindCount> records{};  // Batch::count that the templates were written for
    std::size_t record_commands = 0;
  };
  GpuLists gpu_;  // empty until begin_gpu_update()
  bool from_gpu_ = false;
  Counting counting_ = Counting::kSearch;
};

}  // namespace sightline::gpuscene
