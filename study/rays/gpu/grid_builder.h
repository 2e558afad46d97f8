// Builds uniform grids on the GPU, object by object, as G. Ordeix and S. Cioli leave to the future ("Computación
// Gráfica sobre GPUs", 2010, 4.2.3: their builds run on the CPU).
//
// A pair of cell and triangle for each cell that a box overlaps, sorted by cell (J. Kalojanov, P. Slusallek, "A
// Parallel Algorithm for Construction of Uniform Grids", 2009): places come from sums of counts, not from atomic
// counters, so the grid is the same in every run.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/gl/context.h"
#include "sightline/gl/internal/buffer.h"
#include "sightline/gl/internal/program.h"
#include "sightline/study/rays/gpu/structures.h"

namespace sightline::study::rays {

class GridBuilder {
 public:
  /// A UniformGrid in GPU memory.
  struct Grid {
    GridLines lines;
    GpuStructure structure;        ///< for GpuTracer: of Structure::kGrid
    std::uint32_t references = 0;  ///< number of its triangles, counted in each cell

    UniformGrid read() const;  ///< waits for the GPU
  };

  /// Compiles the programs. Borrows the context, which must be current at every call.
  static core::Expected<GridBuilder> create(const gl::Context& context);
  static std::vector<gl::PipelineDescription> all_programs();

  /// Uploads what build() reads: boxes of triangles in unit space, as TriangleSet::boxes() has them.
  core::Expected<gl::Buffer> upload(std::span<const core::Aabb> boxes) const;

  /// The grid that build_grid_per_object() builds of `boxes`, which are those of all `triangles`; with fewer than 2³²
  /// references. Waits for the GPU once, for their number. Fails when the GPU has not the memory, or an array is larger
  /// than the context's storage blocks may be: 8 bytes a reference, 4 a cell.
  core::Expected<Grid> build(const TriangleSet& triangles, const gl::Buffer& boxes, const GridLines& lines) const;

 private:
  enum Step : std::uint8_t {
    kCountCells,
    kWriteReferences,
    kPrefixSum,
    kAddSums,
    kCountDigits,
    kMovePairs,
    kWriteGrid,
    kSteps
  };
  static std::vector<gl::ProgramDescription> describe();  // by Step
  void run(Step step, std::uint32_t count, std::uint32_t per_group, std::span<const gl::Buffer* const> buffers) const;
  void set(Step step, const char* uniform, std::uint32_t value) const;
  core::Expected<void> sum_up(const gl::Buffer& values, std::uint32_t count) const;
  core::Expected<gl::Buffer> write_references(const gl::Buffer& boxes, std::uint32_t count,
                                              std::uint32_t& references) const;
  core::Expected<void> sort(gl::Buffer& pairs, std::uint32_t count, std::uint32_t bits) const;

  const gl::Context* context_ = nullptr;
  std::vector<gl::Program> programs_;  // by Step
};

}  // namespace sightline::study::rays
