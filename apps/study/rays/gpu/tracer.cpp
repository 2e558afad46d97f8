#include "sightline/apps/study/rays/gpu/tracer.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "sightline/apps/study/rays/gpu/shaders.h"

namespace sightline::study::rays {
namespace {

struct Form {
  std::string_view traversal;  // Traversal::name
  const char* file;
  const char* define = nullptr;
};

constexpr std::array kForms = {
    Form{"octree", "octree.glsl"},
    Form{"grid 3D-DDA", "grid_dda.glsl"},
    Form{"kd sequential", "kd_ropes.glsl", "FROM_ROOT"},
    Form{"kd standard", "kd_standard.glsl"},
    Form{"kd Havran", "kd_havran.glsl"},
    Form{"kd restart", "kd_restart.glsl"},
    Form{"kd backtrack", "kd_backtrack.glsl"},
    Form{"kd push-down", "kd_restart.glsl", "PUSH_DOWN"},
    Form{"kd short-stack", "kd_short_stack.glsl"},
    Form{"kd PD & SS", "kd_short_stack.glsl", "PUSH_DOWN"},
    Form{"kd ropes", "kd_ropes.glsl", "SIX_PLANES"},
    Form{"kd ropes++", "kd_ropes.glsl"},
    Form{"kd 8-byte standard", "kd_standard.glsl", "EIGHT_BYTES"},
    Form{"BVH", "bvh.glsl"},
    Form{"BIH", "bih.glsl"},
    Form{"SBG", "sbg.glsl"},
};

const Form* form_of(const Traversal& traversal) {
  for (const Form& form : kForms)
    if (form.traversal == traversal.name) return &form;
  return nullptr;
}

gl::ProgramDescription describe_trace(const Form& form, Ask ask, bool persistent) {
  gl::ProgramDescription description;
  description.name = form.traversal;
  description.stages = {{GL_COMPUTE_SHADER, {form.file, "trace.comp"}}};
  description.shaders.tables = {shaders()};
  const auto define = [&](bool wanted, const char* what) {
    if (wanted) description.shaders.defines.emplace_back(what);
  };
  define(form.define != nullptr, form.define);
  define(ask == Ask::kAny, "ANY");
  define(ask == Ask::kCount, "COUNTING");
  define(persistent, "PERSISTENT");
  return description;
}

}  // namespace

std::vector<gl::PipelineDescription> GpuTracer::all_programs() {
  std::vector<gl::PipelineDescription> all;
  for (const Form& form : kForms)
    for (std::size_t ask = 0; ask < kAsks; ++ask)
      for (const bool persistent : {false, true}) all.push_back({describe_trace(form, Ask(ask), persistent)});
  return all;
}

core::Expected<const GpuTracer::Program*> GpuTracer::program_of(const Traversal& traversal, Ask ask, bool persistent) {
  const auto key = std::tuple(traversal.name, ask, persistent);
  if (const auto found = programs_.find(key); found != programs_.end()) return &found->second;
  const Form* form = form_of(traversal);
  if (form == nullptr) return core::fail(std::string("no shader has the traversal ") + traversal.name);
  auto made = gl::Program::create(context_->functions(), describe_trace(*form, ask, persistent));
  if (!made) return tl::unexpected(made.error());
  Program program{std::move(*made), -1, -1, -1, -1};
  program.image = program.program.uniform("image");
  program.tile = program.program.uniform("tile");
  program.ray_count = program.program.uniform("ray_count");
  program.most_tiles = program.program.uniform("most_tiles");
  return &programs_.emplace(key, std::move(program)).first->second;
}

core::Expected<void> GpuTracer::trace(const Traversal& traversal, Ask ask, const GpuTriangles& triangles,
                                      const GpuStructure& structure, const RayBatch& batch, const Launch& launch) {
  const bool persistent = launch.persistent_groups > 0;
  const auto found = program_of(traversal, ask, persistent);
  if (!found) return tl::unexpected(found.error());
  const Program& program = **found;
  if (persistent && next_tile_.id() == 0) {
    auto made = make_storage(*context_, sizeof(std::uint32_t), nullptr, "number of the next tile");
    if (!made) return tl::unexpected(made.error());
    next_tile_ = std::move(*made);
  }
  const gl::Functions& gl = context_->functions();
  const auto bind = [&](Binding binding, std::size_t offset, const gl::Buffer& buffer) {
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, GLuint(binding) + GLuint(offset), buffer.id());
  };
  gl.BindBufferBase(GL_UNIFORM_BUFFER, 0, structure.space.id());
  bind(Binding::kCorners, 0, triangles.corners);
  for (std::size_t i = 0; i < structure.arrays.size(); ++i) bind(Binding::kTriangles, i, structure.arrays[i]);
  const GLuint id = program.program.id(), tile_width = launch.tiles ? 8 : 32, tile_height = 32 / tile_width;
  const std::uint32_t most_tiles = context_->capabilities().software ? 16 : 0xffffffffu;
  program.program.use();
  gl.ProgramUniform2ui(id, program.tile, tile_width, tile_height);
  for (const RayBatch::Part& part : batch.parts()) {
    const std::uint32_t across = divided_up(batch.width(), tile_width);
    const std::uint32_t down = divided_up(divided_up(part.count, batch.width()), tile_height);
    bind(Binding::kRays, 0, part.rays);
    bind(Binding::kAnswers, 0, part.answers);
    gl.ProgramUniform3ui(id, program.image, across, down, batch.width());
    gl.ProgramUniform1ui(id, program.ray_count, part.count);
    if (persistent) {
      next_tile_.fill(0, next_tile_.size(), 0);
      bind(Binding::kNextTile, 0, next_tile_);
      gl.ProgramUniform1ui(id, program.most_tiles, most_tiles);
      gl.DispatchCompute(std::max(launch.persistent_groups, divided_up(across * down, most_tiles)), 1, 1);
      gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    } else {
      gl.DispatchCompute(across, down, 1);
    }
  }
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  return {};
}

}  // namespace sightline::study::rays
