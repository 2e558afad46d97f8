#include "sightline/render/internal/section_caps.h"

#include <unordered_map>

#include "sightline/core/internal/store.h"

namespace sightline::render {
namespace {

constexpr GLuint kEnclosureUnit = 4;
enum StorageBinding : GLuint { kCellBinding = 1, kNodeBinding };
constexpr GLint kWidthUniform = 1;
constexpr std::size_t kCellBytes = 12, kNodeBytes = 8, kNodeHeaderBytes = 8;

gl::ProgramDescription describe_cap_pass(const gl::ShaderContext& shaders, const char* name, const char* vertex,
                                         const char* fragment, const char* define) {
  gl::ProgramDescription description;
  description.name = name;
  description.stages = {{GL_VERTEX_SHADER, {vertex}}, {GL_FRAGMENT_SHADER, {fragment}}};
  description.shaders = shaders;
  description.shaders.defines.emplace_back(define);
  return description;
}

/// Finds what the mesh of each record of the mesh batch encloses, in slot order.
std::vector<std::uint8_t> enclosures(const core::Snapshot& snapshot) {
  std::unordered_map<std::uint32_t, core::Enclosure> of_mesh;
  std::vector<std::uint8_t> of_record;
  for (core::Slot slot = 0; slot < snapshot.size(); ++slot) {
    const core::Kind kind = snapshot.kind(slot);
    if (gpuscene::batch_of(kind) != gpuscene::BatchKind::kMesh) continue;
    const std::uint32_t mesh = snapshot.of_kind(kind).meshes[snapshot.index_in_kind(slot)];
    const auto [place, fresh] = of_mesh.try_emplace(mesh);
    if (fresh) place->second = core::enclosure(snapshot.mesh(slot));
    of_record.push_back(std::uint8_t(place->second));
  }
  return of_record;
}

}  // namespace

std::array<gl::ProgramDescription, 3> SectionCaps::describe(const gl::ShaderContext& shaders) {
  return {describe_cap_pass(shaders, "crossings counted", "mesh.vert", "section_crossing.frag", "COUNT_CROSSINGS"),
          describe_cap_pass(shaders, "crossings listed", "mesh.vert", "section_crossing.frag", "LIST_CROSSINGS"),
          describe_cap_pass(shaders, "section caps", "whole_viewport.vert", "section_cap.frag", "SECTION_CAPS")};
}

core::Expected<SectionCaps> SectionCaps::create(const gl::Functions& gl, const gl::ShaderContext& shaders) {
  SectionCaps caps;
  caps.gl_ = &gl;
  auto programs = gl::Program::create_all(gl, describe(shaders));
  if (!programs) return tl::unexpected(programs.error());
  caps.count_ = std::move((*programs)[0]);
  caps.list_ = std::move((*programs)[1]);
  caps.caps_ = std::move((*programs)[2]);
  caps.no_attributes_ = gl::VertexArray(gl);
  auto made = gl::check_names(gl, {caps.no_attributes_.id()}, "vertex array of section caps");
  if (!made) return tl::unexpected(made.error());
  return caps;
}

core::Expected<void> SectionCaps::prepare(const core::Snapshot& snapshot, const gpuscene::GpuScene& scene, int width,
                                          int height) {
  if (width != width_ || height != height_) {
    const std::size_t pixels = std::size_t(width) * std::size_t(height);
    auto cells = gl::Buffer::create(*gl_, pixels * kCellBytes, nullptr, 0, "section crossings of pixels");
    if (!cells) return tl::unexpected(cells.error());
    auto nodes = gl::Buffer::create(*gl_, kNodeHeaderBytes + pixels * kListed * kNodeBytes, nullptr, 0,
                                    "lists of section crossings");
    if (!nodes) return tl::unexpected(nodes.error());
    auto framebuffer = gl::Framebuffer::create_attachmentless(*gl_, width, height, "section crossings");
    if (!framebuffer) return tl::unexpected(framebuffer.error());
    cells_ = std::move(*cells);
    nodes_ = std::move(*nodes);
    crossings_ = std::move(*framebuffer);
    width_ = width;
    height_ = height;
  }
  gpuscene::MeshPool::Enclosures& known = *scene.meshes().enclosures;
  enclosures_ = scene.meshes().enclosures;
  const gpuscene::Batch& meshes = *scene.batch(gpuscene::BatchKind::kMesh);
  if (known.records == meshes.count) return {};
  const std::vector<std::uint8_t> of_record = enclosures(snapshot);
  auto made = gl::TexelArray::create(*gl_, of_record.size(), of_record.data(), GL_R8UI, "what meshes enclose", 0);
  if (auto done = core::store(std::move(made), known.bytes); !done) return done;
  known.records = meshes.count;
  return {};
}

void SectionCaps::begin_counting() const {
  const gl::Functions& gl = *gl_;
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);  // caps of other scenes in this image have counted here
  cells_.fill(0, cells_.size(), 0);
  nodes_.fill(0, kNodeHeaderBytes, 0);
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kCellBinding, cells_.id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kNodeBinding, nodes_.id());
  gl.BindTextureUnit(kEnclosureUnit, enclosures_->bytes.texels.id());
  for (const gl::Program* program : {&count_, &list_, &caps_})
    gl.ProgramUniform1i(program->id(), kWidthUniform, width_);
  // Every crossing counts, even if it is hidden or lies behind the far plane. With more samples than one, neighbouring
  // triangles would count one crossing twice; drivers on Vulkan ignore GL_MULTISAMPLE, which could forbid that.
  crossings_.bind();
  gl.Enable(GL_DEPTH_CLAMP);
  count_.use();
}

void SectionCaps::begin_listing() const {
  gl_->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  list_.use();
}

void SectionCaps::draw_caps(const gl::Framebuffer& image) const {
  const gl::Functions& gl = *gl_;
  gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  image.bind();
  gl.Disable(GL_DEPTH_CLAMP);
  caps_.use();
  no_attributes_.bind();
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace sightline::render
