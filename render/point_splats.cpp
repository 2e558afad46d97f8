#include "sightline/render/internal/point_splats.h"

#include <bit>
#include <cstddef>

#include "sightline/core/internal/store.h"
#include "sightline/gpuprims/internal/shaders.h"
#include "sightline/gpuprims/internal/view_block.h"
#include "sightline/render/internal/shaders.h"

namespace sightline::render {
namespace {

constexpr GLuint kSplatMaterialUnit = 2;
constexpr GLint kSplatOffsetsUniform = 1;
enum SplatAttribute : GLuint { kSplatPlace, kSplatItem };
constexpr float kMargin = 0.25f;  // as in point_splat.vert

static_assert(sizeof(PointSplat) == 24 && offsetof(PointSplat, side) == 12 && offsetof(PointSplat, item) == 16);

gl::ProgramDescription describe(const TargetFormat& format) {
  gl::ProgramDescription description;
  description.name = "point splats";
  description.stages = {{GL_VERTEX_SHADER, {"point_splat.vert"}}, {GL_FRAGMENT_SHADER, {"point_splat.frag"}}};
  description.shaders.tables = {shaders(), gpuprims::shaders()};
  description.shaders.defines.emplace_back("SECTIONS");
  if (format.normals) description.shaders.defines.emplace_back("NORMALS");
  if (format.samples > 1) description.shaders.defines.push_back("SAMPLES " + std::to_string(format.samples));
  return description;
}

}  // namespace

std::vector<gl::PipelineDescription> PointSplats::all_programs() {
  std::vector<gl::PipelineDescription> all;
  for (const int samples : kSampleCounts)
    for (const bool normals : {false, true}) all.push_back({describe({.normals = normals, .samples = samples})});
  return all;
}

core::Expected<PointSplats> PointSplats::create(const gl::Context& context, const TargetFormat& format) {
  const gl::Functions& gl = context.functions();
  PointSplats splats;
  splats.gl_ = &gl;
  auto block = gl::Buffer::create(gl, sizeof(gpuprims::ViewBlock), nullptr, GL_DYNAMIC_STORAGE_BIT, "view block");
  auto done = core::store(std::move(block), splats.view_block_);
  if (done) done = core::store(gl::Program::create(gl, describe(format)), splats.program_);
  if (!done) return tl::unexpected(done.error());
  splats.array_ = gl::VertexArray(gl);
  const GLuint array = splats.array_.id();
  if (auto made = gl::check_names(gl, {array}, "vertex array of splats"); !made) return tl::unexpected(made.error());
  gl.EnableVertexArrayAttrib(array, kSplatPlace);
  gl.VertexArrayAttribFormat(array, kSplatPlace, 4, GL_FLOAT, GL_FALSE, 0);
  gl.VertexArrayAttribBinding(array, kSplatPlace, 0);
  gl.EnableVertexArrayAttrib(array, kSplatItem);
  gl.VertexArrayAttribIFormat(array, kSplatItem, 2, GL_UNSIGNED_INT, offsetof(PointSplat, item));
  gl.VertexArrayAttribBinding(array, kSplatItem, 0);
  GLfloat range[2] = {1.0f, 1.0f};
  gl.GetFloatv(GL_POINT_SIZE_RANGE, range);
  splats.largest_side_ = range[1] - kMargin;
  return splats;
}

core::Expected<void> PointSplats::upload(const core::View& view, std::span<const PointSplat> splats,
                                         const RenderTarget& target) {
  const auto block = gpuprims::make_view_block(view, target.width(), target.height());
  if (!block) return tl::unexpected(block.error());
  view_block_.write(0, sizeof(*block), &*block);
  if (splats.size_bytes() > vertices_.size()) {
    const std::size_t bytes = std::bit_ceil(splats.size()) * sizeof(PointSplat);
    auto made = gl::Buffer::create(*gl_, bytes, nullptr, GL_DYNAMIC_STORAGE_BIT, "point splats");
    if (auto done = core::store(std::move(made), vertices_); !done) return done;
  }
  vertices_.write(0, splats.size_bytes(), splats.data());
  return {};
}

core::Expected<void> PointSplats::draw(const core::View& view, std::span<const PointSplat> splats,
                                       const gpuscene::GpuScene& scene, const RenderTarget& target) {
  if (splats.empty()) return {};
  if (auto done = upload(view, splats, target); !done) return done;
  const gl::Functions& gl = *gl_;
  target.begin_drawing();
  gl.Enable(GL_PROGRAM_POINT_SIZE);
  gl.BindBufferBase(GL_UNIFORM_BUFFER, 0, view_block_.id());
  gl.BindTextureUnit(kSplatMaterialUnit, scene.materials().id());
  if (target.format().samples > 1)
    gl.ProgramUniform2fv(program_.id(), kSplatOffsetsUniform, target.format().samples, &target.sample_offsets()[0].x);
  gl.BindProgramPipeline(0);
  program_.use();
  gl.VertexArrayVertexBuffer(array_.id(), 0, vertices_.id(), 0, sizeof(PointSplat));
  array_.bind();
  gl.DrawArrays(GL_POINTS, 0, GLsizei(splats.size()));
  gl.UseProgram(0);
  return {};
}

}  // namespace sightline::render
