#include "sightline/study/rays/gpu/grid_builder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <string>
#include <utility>

#include "sightline/study/rays/gpu/shaders.h"

namespace sightline::study::rays {
namespace {

constexpr std::uint32_t kGroupSize = 256;               // of invocation.glsl
constexpr std::uint32_t kSumBlock = 8 * kGroupSize;     // of prefix_sum.comp
constexpr std::uint32_t kPairRun = 64, kDigitBits = 4;  // of digits.glsl
constexpr std::uint32_t kMostGroups = 65535;            // of one dimension of a dispatch, in any context
constexpr std::uint32_t kDigits = std::uint32_t(1) << kDigitBits;

}  // namespace

UniformGrid GridBuilder::Grid::read() const {
  UniformGrid grid;
  grid.lines = lines;
  grid.begins.resize(lines.count() + 1);
  grid.triangles.resize(references);
  structure.arrays[1].read(0, grid.begins.size() * sizeof(std::uint32_t), grid.begins.data());
  if (references > 0) structure.arrays[0].read(0, grid.triangles.size() * sizeof(std::uint32_t), grid.triangles.data());
  return grid;
}

std::vector<gl::ProgramDescription> GridBuilder::describe() {
  constexpr std::array<const char*, kSteps> kFiles = {"count_cells.comp", "write_references.comp", "prefix_sum.comp",
                                                      "add_sums.comp",    "count_digits.comp",     "move_pairs.comp",
                                                      "write_grid.comp"};
  std::vector<gl::ProgramDescription> descriptions;
  for (const char* file : kFiles) {
    descriptions.emplace_back();
    descriptions.back().name = std::string("grid: ") + file;
    descriptions.back().stages = {{GL_COMPUTE_SHADER, {file}}};
    descriptions.back().shaders.tables = {shaders()};
  }
  return descriptions;
}

std::vector<gl::PipelineDescription> GridBuilder::all_programs() {
  std::vector<gl::PipelineDescription> all;
  for (const gl::ProgramDescription& step : describe()) all.push_back({step});
  return all;
}

core::Expected<GridBuilder> GridBuilder::create(const gl::Context& context) {
  auto programs = gl::Program::create_all(context.functions(), describe());
  if (!programs) return tl::unexpected(programs.error());
  GridBuilder builder;
  builder.context_ = &context;
  builder.programs_ = std::move(*programs);
  return builder;
}

core::Expected<gl::Buffer> GridBuilder::upload(std::span<const core::Aabb> boxes) const {
  return make_storage(*context_, boxes.size_bytes(), boxes.data(), "boxes of triangles");
}

void GridBuilder::set(Step step, const char* uniform, std::uint32_t value) const {
  const gl::Program& program = programs_[step];
  context_->functions().ProgramUniform1ui(program.id(), program.uniform(uniform), value);
}

/// `count` of invocations, `per_group` things of a group; buffers by binding.
void GridBuilder::run(Step step, std::uint32_t count, std::uint32_t per_group,
                      std::span<const gl::Buffer* const> buffers) const {
  const gl::Functions& gl = context_->functions();
  const std::uint32_t groups = divided_up(count, per_group);
  if (groups == 0) return;
  set(step, "count", count);
  for (std::size_t i = 0; i < buffers.size(); ++i)
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, GLuint(i), buffers[i]->id());
  programs_[step].use();
  gl.DispatchCompute(std::min(groups, kMostGroups), divided_up(groups, kMostGroups), 1);
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

/// Replaces each value by the sum of those before it.
core::Expected<void> GridBuilder::sum_up(const gl::Buffer& values, std::uint32_t count) const {
  const std::uint32_t blocks = divided_up(count, kSumBlock);
  auto sums = make_storage(*context_, blocks * sizeof(std::uint32_t), nullptr, "sums of a grid");
  if (!sums) return tl::unexpected(sums.error());
  run(kPrefixSum, count, kSumBlock, std::array<const gl::Buffer*, 2>{&values, &*sums});
  if (blocks <= 1) return {};
  if (auto done = sum_up(*sums, blocks); !done) return done;
  set(kAddSums, "block_size", kSumBlock);
  run(kAddSums, count, kGroupSize, std::array<const gl::Buffer*, 2>{&values, &*sums});
  return {};
}

/// Pairs of cell and triangle, by triangle.
core::Expected<gl::Buffer> GridBuilder::write_references(const gl::Buffer& boxes, std::uint32_t count,
                                                         std::uint32_t& references) const {
  const std::vector<std::uint32_t> zeros(std::size_t(count) + 1);  // the last one's place is the sum
  auto places = make_storage(*context_, zeros.size() * sizeof(std::uint32_t), zeros.data(), "cells of boxes");
  if (!places) return tl::unexpected(places.error());
  run(kCountCells, count, kGroupSize, std::array<const gl::Buffer*, 2>{&boxes, &*places});
  if (auto done = sum_up(*places, count + 1); !done) return tl::unexpected(done.error());
  places->read(count * sizeof(std::uint32_t), sizeof references, &references);
  auto pairs = make_storage(*context_, references * (2 * sizeof(std::uint32_t)), nullptr, "references of a grid");
  if (!pairs) return pairs;
  set(kWriteReferences, "box_count", count);
  run(kWriteReferences, references, kGroupSize, std::array<const gl::Buffer*, 3>{&boxes, &*places, &*pairs});
  return pairs;
}

/// By cell, of which `bits` count.
core::Expected<void> GridBuilder::sort(gl::Buffer& pairs, std::uint32_t count, std::uint32_t bits) const {
  const std::uint32_t runs = divided_up(count, kPairRun);
  auto places =
      make_storage(*context_, std::size_t(runs) * kDigits * sizeof(std::uint32_t), nullptr, "digits of cells");
  if (!places) return tl::unexpected(places.error());
  auto sorted = make_storage(*context_, pairs.size(), nullptr, "references of a grid");
  if (!sorted) return tl::unexpected(sorted.error());
  for (std::uint32_t shift = 0; shift < bits; shift += kDigitBits) {
    for (const Step step : {kCountDigits, kMovePairs}) {
      set(step, "pair_count", count);
      set(step, "shift", shift);
    }
    const std::array<const gl::Buffer*, 3> buffers{&pairs, &*places, &*sorted};
    run(kCountDigits, runs, kGroupSize, buffers);
    if (auto done = sum_up(*places, runs * kDigits); !done) return done;
    run(kMovePairs, runs, kGroupSize, buffers);
    std::swap(pairs, *sorted);
  }
  return {};
}

core::Expected<GridBuilder::Grid> GridBuilder::build(const TriangleSet& triangles, const gl::Buffer& boxes,
                                                     const GridLines& lines) const {
  Grid grid;
  grid.lines = lines;
  const std::size_t number = lines.count();
  auto begins = make_storage(*context_, (number + 1) * sizeof(std::uint32_t), nullptr, "cells of a grid");
  if (!begins) return tl::unexpected(begins.error());
  auto space = upload_space(*context_, triangles, lines);
  if (!space) return tl::unexpected(space.error());
  context_->functions().BindBufferBase(GL_UNIFORM_BUFFER, 0, space->id());

  auto pairs = write_references(boxes, triangles.size(), grid.references);
  if (!pairs) return tl::unexpected(pairs.error());
  if (auto done = sort(*pairs, grid.references, std::uint32_t(std::bit_width(number - 1))); !done)
    return tl::unexpected(done.error());
  auto list = make_storage(*context_, grid.references * sizeof(std::uint32_t), nullptr, "triangles of a grid");
  if (!list) return tl::unexpected(list.error());
  const std::uint32_t begin_count = std::uint32_t(number + 1);
  set(kWriteGrid, "pair_count", grid.references);
  set(kWriteGrid, "begin_count", begin_count);
  const std::array<const gl::Buffer*, 3> buffers{&*pairs, &*begins, &*list};
  run(kWriteGrid, std::max(grid.references, begin_count), kGroupSize, buffers);
  grid.structure = {std::move(*space), {std::move(*list), std::move(*begins), {}, {}}};
  return grid;
}

}  // namespace sightline::study::rays
