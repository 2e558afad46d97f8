#include "sightline/render/internal/renderer.h"

#include <algorithm>
#include <utility>

#include "sightline/core/internal/store.h"
#include "sightline/gl/internal/pipeline_state.h"
#include "sightline/gpuprims/internal/shaders.h"
#include "sightline/gpuprims/internal/studio_black.h"
#include "sightline/gpuprims/internal/view_block.h"
#include "sightline/gpuscene/internal/record_commands.h"
#include "sightline/render/internal/shaders.h"

namespace sightline::render {
namespace {

using gpuscene::BatchKind;

enum TextureUnit : GLuint { kPayloadUnit, kChunkUnit, kMaterialUnit, kSinglesUnit };
enum VertexUniform : GLint { kRecordCountUniform, kBatchKindUniform, kTexelsPerRecordUniform };
constexpr GLint kBlendRangeUniform = 64;  // in the fragment stage
enum VertexBinding : GLuint { kInstanceBinding, kMeshBinding };
enum VertexAttribute : GLuint { kInstanceAttribute, kVertexAttribute };

/// Describes the stages before the fragments' that all ray-cast batches share.
gl::ProgramDescription describe_proxies(const TargetFormat& format, bool geometry_stage) {
  gl::ProgramDescription description;
  description.name = "proxies";
  description.stages = {{GL_VERTEX_SHADER, {"primitive.vert"}}};
  if (geometry_stage) description.stages.push_back({GL_GEOMETRY_SHADER, {"primitive.geom"}});
  if (!geometry_stage) description.shaders.defines.emplace_back("PROXY_CORNERS");
  description.separable = true;
  description.shaders.tables = {shaders(), gpuprims::shaders()};
  if (format.samples > 1) description.shaders.defines.push_back("SAMPLES " + std::to_string(format.samples));
  for (std::string& define : gpuscene::batch_kind_defines()) description.shaders.defines.push_back(std::move(define));
  return description;
}

void describe_mesh(const gl::Functions& gl, GLuint array) {
  gl.EnableVertexArrayAttrib(array, kInstanceAttribute);
  gl.VertexArrayAttribIFormat(array, kInstanceAttribute, 1, GL_UNSIGNED_INT, 0);
  gl.VertexArrayAttribBinding(array, kInstanceAttribute, kInstanceBinding);
  gl.VertexArrayBindingDivisor(array, kInstanceBinding, 1);
  gl.EnableVertexArrayAttrib(array, kVertexAttribute);
  gl.VertexArrayAttribIFormat(array, kVertexAttribute, 4, GL_UNSIGNED_INT, 0);  // one fetch for the whole vertex
  gl.VertexArrayAttribBinding(array, kVertexAttribute, kMeshBinding);
}

}  // namespace

/// Context of all shaders for targets of a format.
gl::ShaderContext Renderer::shader_context(const TargetFormat& format, Cut cut, Surface surface) {
  gl::ShaderContext context;
  context.tables = {shaders(), gpuprims::shaders()};
  if (format.normals) context.defines.emplace_back("NORMALS");
  if (format.samples > 1) context.defines.push_back("SAMPLES " + std::to_string(format.samples));
  if (cut != Cut::kNone) context.defines.emplace_back("SECTIONS");
  if (cut == Cut::kHatched) context.defines.emplace_back("HATCHING");
  if (surface == Surface::kGhost) context.defines.emplace_back("GHOST");
  if (surface == Surface::kBlended) context.defines.emplace_back("BLENDED");
  return context;
}

gl::ProgramDescription Renderer::describe_batch(BatchKind kind, const TargetFormat& format, Cut cut, Surface surface) {
  gl::ProgramDescription description;
  description.name = gpuscene::name_of(kind);
  description.shaders = shader_context(format, cut, surface);
  for (std::string& define : gpuscene::batch_defines(kind)) description.shaders.defines.push_back(std::move(define));
  if (gpuscene::is_ray_cast(kind)) {
    description.stages = {{GL_FRAGMENT_SHADER, {"primitive.frag"}}};
    description.separable = true;
  } else {
    const char* vertex = kind == BatchKind::kMesh ? "mesh.vert" : "line.vert";
    description.stages = {{GL_VERTEX_SHADER, {vertex}}, {GL_FRAGMENT_SHADER, {"surface.frag"}}};
  }
  return description;
}

std::vector<gl::PipelineDescription> Renderer::all_programs() {
  std::vector<gl::PipelineDescription> all;
  const auto add = [&](const TargetFormat& format, Cut cut, Surface surface) {
    for (int i = 0; i < gpuscene::kBatchKindCount; ++i) {
      const gl::ProgramDescription batch = describe_batch(BatchKind(i), format, cut, surface);
      all.push_back({batch});
      if (!gpuscene::is_ray_cast(BatchKind(i))) continue;
      all.back().push_back(describe_proxies(format, true));
      // Both forms give fragments the same, so that one kind of surface stands for all.
      if (cut == Cut::kNone && surface == Surface::kSolid) all.push_back({batch, describe_proxies(format, false)});
    }
    if (cut == Cut::kNone) return;
    for (const auto& caps : SectionCaps::describe(shader_context(format, cut, surface))) all.push_back({caps});
  };
  for (const int samples : kSampleCounts)
    for (const bool normals : {false, true})
      for (std::size_t cut = 0; cut < kCuts; ++cut)
        for (std::size_t surface = 0; surface < kSurfaces; ++surface)
          add({.normals = normals, .samples = samples}, Cut(cut), Surface(surface));
  return all;
}

core::Expected<Renderer> Renderer::create(const gl::Context& context, const gpuscene::GpuScene& scene,
                                          const TargetFormat& format) {
  auto renderer = begin(context);
  if (!renderer) return renderer;
  if (auto done = renderer->advance(scene, format, core::kNoDeadline); !done) return tl::unexpected(done.error());
  return renderer;
}

core::Expected<Renderer> Renderer::create(const gl::Context& context, std::span<const BatchKind> kinds,
                                          const TargetFormat& format) {
  auto renderer = begin(context);
  if (!renderer) return renderer;
  renderer->kinds_.assign(kinds.begin(), kinds.end());
  renderer->compiled_ = kinds.size();
  BatchPrograms& plain = renderer->programs_[std::size_t(Surface::kSolid)].plain.emplace();
  if (auto done = renderer->make_programs(kinds, format, Cut::kNone, Surface::kSolid, plain); !done)
    return tl::unexpected(done.error());
  return renderer;
}

core::Expected<Renderer> Renderer::begin(const gl::Context& context) {
  const gl::Functions& gl = context.functions();
  Renderer renderer;
  renderer.gl_ = &gl;
  renderer.background_pass_.emplace(gl);
  renderer.record_array_ = gl::VertexArray(gl);
  renderer.mesh_array_ = gl::VertexArray(gl);
  auto made = gl::check_names(gl, {renderer.record_array_.id(), renderer.mesh_array_.id()}, "vertex arrays");
  if (!made) return tl::unexpected(made.error());
  describe_mesh(gl, renderer.mesh_array_.id());
  auto block = gl::Buffer::create(gl, sizeof(gpuprims::ViewBlock), nullptr, GL_DYNAMIC_STORAGE_BIT, "view block");
  return core::store(std::move(block), renderer.view_block_).map([&] { return std::move(renderer); });
}

bool Renderer::has_cached(const gl::Functions& gl, BatchKind kind, const TargetFormat& format) {
  return gl::Program::is_cached(gl, describe_batch(kind, format, Cut::kNone, Surface::kSolid));
}

core::Expected<bool> Renderer::advance(const gpuscene::GpuScene& scene, const TargetFormat& format,
                                       core::Deadline deadline) {
  std::optional<BatchPrograms>& plain = programs_[std::size_t(Surface::kSolid)].plain;
  if (!plain) {
    plain.emplace();
    for (const gpuscene::Batch& batch : scene.batches()) kinds_.push_back(batch.kind);
  }
  const std::span<const BatchKind> kinds = kinds_;
  while (compiled_ < kinds.size()) {
    const std::size_t count = deadline == core::kNoDeadline ? kinds.size() - compiled_ : 1;
    auto done = make_programs(kinds.subspan(compiled_, count), format, Cut::kNone, Surface::kSolid, *plain);
    if (!done) return tl::unexpected(done.error());
    compiled_ += count;
    if (core::over(deadline)) break;
  }
  return compiled_ == kinds.size();
}

core::Expected<void> Renderer::follow(const gpuscene::GpuScene& scene, const TargetFormat& format) {
  const std::size_t before = kinds_.size();
  for (const gpuscene::Batch& batch : scene.batches())
    if (std::find(kinds_.begin(), kinds_.end(), batch.kind) == kinds_.end()) kinds_.push_back(batch.kind);
  if (kinds_.size() == before && compiled_ == before) return {};
  std::optional<BatchPrograms> plain = std::move(programs_[std::size_t(Surface::kSolid)].plain);
  programs_ = {};  // the others are made for all kinds when they are next used
  programs_[std::size_t(Surface::kSolid)].plain = std::move(plain);
  return advance(scene, format, core::kNoDeadline).map([](bool) {});
}

/// Makes the programs of batches, and the program that ray-cast batches share unless there is one.
core::Expected<void> Renderer::make_programs(std::span<const BatchKind> kinds, const TargetFormat& format, Cut cut,
                                             Surface surface, BatchPrograms& made) {
  std::vector<gl::ProgramDescription> descriptions;
  for (const BatchKind kind : kinds) descriptions.push_back(describe_batch(kind, format, cut, surface));
  const bool proxies = proxy_program_.id() == 0 && std::any_of(kinds.begin(), kinds.end(), gpuscene::is_ray_cast);
  const bool geometry_stage = !gl_->workarounds[gl::Workaround::kNoGeometryStage];
  if (proxies) descriptions.push_back(describe_proxies(format, geometry_stage));
  auto programs = gl::Program::create_all(*gl_, descriptions);
  if (!programs) return tl::unexpected(programs.error());
  if (proxies) proxy_program_ = std::move(programs->back());
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    BatchProgram& one = made[std::size_t(kinds[i])];
    one.program = std::move((*programs)[i]);
    if (!gpuscene::is_ray_cast(kinds[i])) continue;
    one.pipeline = gl::ProgramPipeline(*gl_);
    if (auto done = gl::check_names(*gl_, {one.pipeline.id()}, "program pipeline"); !done) return done;
    one.pipeline.set_stages(GL_VERTEX_SHADER_BIT | (geometry_stage ? GL_GEOMETRY_SHADER_BIT : 0), proxy_program_);
    one.pipeline.set_stages(GL_FRAGMENT_SHADER_BIT, one.program);
  }
  return {};
}

core::Expected<void> Renderer::upload_view(const core::View& view, const core::Snapshot& snapshot,
                                           const RenderTarget& target) {
  auto block = gpuprims::make_view_block(view, target.width(), target.height());
  if (!block) return tl::unexpected(block.error());
  block->hatching = {hatching, std::max(1.0f, hatching.y / 6.0f), 0.0f};
  const auto lights = gpuprims::distant_lights(view, lighting, sun);
  for (std::size_t i = 0; i < lights.size(); ++i)
    block->lights[i] = {glm::normalize(core::dmat3(view.eye_from_world()) * lights[i].towards), lights[i].strength};
  if (lighting == gpuprims::Lighting::kStudio) block->up.w = gpuprims::kStudioBlack;
  view_block_.write(0, sizeof(*block), &*block);

  gpuprims::eye_relative_origins(view, snapshot.chunk_origins(), origin_rows_);
  origin_rows_.resize(std::max<std::size_t>(2, origin_rows_.size()));
  const std::size_t bytes = origin_rows_.size() * sizeof(origin_rows_[0]);
  core::Expected<void> done;
  if (bytes > chunk_rows_.buffer.size())
    done = core::store(gl::TexelArray::create(*gl_, 2 * bytes, nullptr, GL_RGBA32F, "chunk origins"), chunk_rows_);
  if (done) chunk_rows_.buffer.write(0, bytes, origin_rows_.data());
  return done;
}

core::Expected<void> Renderer::clear(const RenderTarget& target) {
  const gl::Functions& gl = *gl_;
  gl::reset_pipeline_state(gl);  // masks and the scissor limit what is cleared
  const GLuint framebuffer = target.framebuffer().id();
  const float far_depth = 0.0f;
  const GLuint no_item[4] = {0, 0, 0, 0};
  const float no_normal[4] = {0.0f, 0.0f, 0.0f, 0.0f};
  if (target.has_ids()) gl.ClearNamedFramebufferuiv(framebuffer, GL_COLOR, 1, no_item);
  if (target.has_normals()) gl.ClearNamedFramebufferfv(framebuffer, GL_COLOR, 2, no_normal);
  gl.ClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &far_depth);
  return background_pass_->fill(background, {framebuffer, 0, 0, target.width(), target.height()});
}

/// The programs that a pass is drawn with. They are compiled where it is the first of its kind.
core::Expected<const Renderer::BatchPrograms*> Renderer::programs_of(const DrawPass& pass) {
  const bool sections = !pass.view.sections.empty();
  SurfacePrograms& all = programs_[std::size_t(pass.surface)];
  const Cut cut = !sections ? Cut::kNone : hatching.x > 0.0f ? Cut::kHatched : Cut::kPlain;
  if (sections && std::exchange(all.cut, cut) != cut) {
    all.sections.reset();
    all.caps.reset();
  }
  std::optional<BatchPrograms>& programs = sections ? all.sections : all.plain;
  if (programs) return &*programs;
  BatchPrograms made;
  if (auto done = make_programs(kinds_, pass.target.format(), cut, pass.surface, made); !done)
    return tl::unexpected(done.error());
  return &programs.emplace(std::move(made));
}

core::Expected<void> Renderer::draw(const DrawPass& pass) {
  const auto& [view, snapshot, scene, lists, target, surface, materials, sums, range] = pass;
  if (auto done = upload_view(view, snapshot, target); !done) return done;
  const auto programs = programs_of(pass);
  if (!programs) return tl::unexpected(programs.error());
  const gl::Functions& gl = *gl_;
  sums ? sums->begin_drawing() : target.begin_drawing();
  gl.BindBufferBase(GL_UNIFORM_BUFFER, 0, view_block_.id());
  gl.BindTextureUnit(kChunkUnit, chunk_rows_.texels.id());
  gl.BindTextureUnit(kMaterialUnit, materials ? materials->id() : scene.materials().id());
  gl.BindTextureUnit(kSinglesUnit, lists.singles().id());
  gl.BindBuffer(GL_DRAW_INDIRECT_BUFFER, lists.commands().id());
  for (const gpuscene::Batch& batch : scene.batches()) {
    if (lists.section(batch.kind).count == 0) continue;
    const BatchProgram& program = (**programs)[std::size_t(batch.kind)];
    if (sums) gl.ProgramUniform2f(program.program.id(), kBlendRangeUniform, range.x, range.y);
    draw_batch(pass, batch, program);
  }
  // The order matters: Mesa never frees a pipeline that is unbound while the program that replaced it is in use.
  gl.UseProgram(0);
  gl.BindProgramPipeline(0);
  const gpuscene::Batch* meshes = scene.batch(BatchKind::kMesh);
  const bool caps = meshes && !view.sections.empty() && lists.section(BatchKind::kMesh).count > 0;
  return caps ? draw_section_caps(pass, *meshes) : core::Expected<void>();
}

core::Expected<void> Renderer::draw_section_caps(const DrawPass& pass, const gpuscene::Batch& meshes) {
  const RenderTarget& target = pass.target;
  SurfacePrograms& programs = programs_[std::size_t(pass.surface)];
  std::optional<SectionCaps>& section_caps = programs.caps;
  if (!section_caps) {
    if (auto done = core::store(SectionCaps::create(*gl_, shader_context(target.format(), programs.cut, pass.surface)),
                                section_caps);
        !done)
      return done;
  }
  if (pass.sums) gl_->ProgramUniform2f(section_caps->caps().id(), kBlendRangeUniform, pass.range.x, pass.range.y);
  if (auto done = section_caps->prepare(pass.snapshot, pass.scene, target.width(), target.height()); !done) return done;
  gl_->BindTextureUnit(kPayloadUnit, meshes.texels.id());
  gl_->Disable(GL_CULL_FACE);
  section_caps->draw(pass.sums ? pass.sums->framebuffer() : target.framebuffer(),
                     [&] { submit_batch(pass, meshes, 0, pass.lists.section(BatchKind::kMesh).count); });
  return {};
}

void Renderer::draw_batch(const DrawPass& pass, const gpuscene::Batch& batch, const BatchProgram& program) const {
  const gl::Functions& gl = *gl_;
  const bool ray_cast = gpuscene::is_ray_cast(batch.kind);
  if (ray_cast) {
    program.pipeline.use();
    gl.ProgramUniform1ui(proxy_program_.id(), kBatchKindUniform, GLuint(batch.kind));
    gl.ProgramUniform1i(proxy_program_.id(), kTexelsPerRecordUniform, gpuscene::texels_per_record(batch.kind));
  } else {
    program.program.use();
  }
  gl.BindTextureUnit(kPayloadUnit, batch.texels.id());
  // Only the front faces of proxies are drawn. Depth clamping keeps them in front of the near plane: the surface behind
  // them may be beyond it.
  const auto toggle = ray_cast ? gl.Enable : gl.Disable;
  toggle(GL_DEPTH_CLAMP);
  toggle(GL_CULL_FACE);
  const gpuscene::DrawLists::Section& section = pass.lists.section(batch.kind);
  if (batch.kind != BatchKind::kMesh)
    gl.ProgramUniform1ui(ray_cast ? proxy_program_.id() : program.program.id(), kRecordCountUniform, batch.count);
  if (section.front_only > 0) {
    gl.Enable(GL_CULL_FACE);
    submit_batch(pass, batch, 0, section.front_only);
    gl.Disable(GL_CULL_FACE);
  }
  if (section.count > section.front_only)
    submit_batch(pass, batch, section.front_only, section.count - section.front_only);
}

/// Draws `count` commands of a batch from `first` on, with the program in use.
void Renderer::submit_batch(const DrawPass& pass, const gpuscene::Batch& batch, int first, int count) const {
  const gl::Functions& gl = *gl_;
  const gpuscene::GpuScene& scene = pass.scene;
  const gpuscene::DrawLists& lists = pass.lists;
  constexpr GLsizei kStride = sizeof(gpuscene::ElementsCommand);
  const gpuscene::DrawLists::Section& section = lists.section(batch.kind);
  const std::size_t begin = section.offset + std::size_t(first) * kStride;
  const auto* offset = reinterpret_cast<const void*>(begin);  // GL's interface does so
  GLenum mode = GL_TRIANGLES, index_type = GL_UNSIGNED_SHORT;
  if (batch.kind == BatchKind::kMesh) {
    const gl::Buffer& indices = lists.mesh_indices(scene);
    if (indices.id() == 0) return;
    index_type = GL_UNSIGNED_INT;
    const GLuint array = mesh_array_.id();
    gl.VertexArrayVertexBuffer(array, kInstanceBinding, lists.mesh_instances().id(), 0, sizeof(std::uint32_t));
    gl.VertexArrayVertexBuffer(array, kMeshBinding, scene.meshes().vertices().id(), 0,
                               gpuscene::MeshPool::kVertexBytes);
    gl.VertexArrayElementBuffer(array, indices.id());
    mesh_array_.bind();
  } else {
    mode = gpuscene::record_form(batch.kind, gl.workarounds).mode;
    gl.VertexArrayElementBuffer(record_array_.id(), lists.record_indices().id());
    record_array_.bind();
  }
  if (section.counted) {
    gl.BindBuffer(GL_PARAMETER_BUFFER_ARB, lists.counts().id());
    gl.MultiDrawElementsIndirectCountARB(mode, index_type, offset, GLintptr(lists.command_count_offset(batch.kind)),
                                         count, kStride);
    gl.BindBuffer(GL_PARAMETER_BUFFER_ARB, 0);  // on Mesa it also affects plain multi-draws
  } else {
    gl.MultiDrawElementsIndirect(mode, index_type, offset, count, kStride);
  }
}

std::size_t Renderer::memory_bytes() const {
  std::size_t bytes = view_block_.size() + chunk_rows_.buffer.size();
  for (const SurfacePrograms& programs : programs_) bytes += programs.caps ? programs.caps->memory_bytes() : 0;
  return bytes;
}

}  // namespace sightline::render
