#include "sightline/render/internal/edge_pass.h"

#include <algorithm>
#include <bit>
#include <cstddef>

#include "sightline/core/internal/store.h"
#include "sightline/gl/internal/pipeline_state.h"
#include "sightline/gpuprims/internal/view_block.h"
#include "sightline/render/internal/shaders.h"

namespace sightline::render {
namespace {

enum EdgeUniform : GLint {
  kClipFromEye,
  kImage,
  kEyeFromMesh,
  kStrength,
  kParts = kStrength,
  kHalfWidth,
  kEdgePixelDepth,
  kSamplePlace,
  kSectionCount,
  kEyeFromClip,
  kEdgeSections = 16
};
constexpr GLint kEdgeColour = 3;  // of put_edges.frag
constexpr GLsizei kPartVertices = 6;
constexpr std::size_t kLeastSegments = 4096, kLeastCurves = 1024;

static_assert(sizeof(EdgeSegment) == 24);
static_assert(offsetof(CurvedLine, u) == 12 && offsetof(CurvedLine, v) == 24 && offsetof(CurvedLine, sweep) == 36 &&
              offsetof(CurvedLine, strength) == 40);

gl::ProgramDescription describe_edges(int samples, bool curves) {
  gl::ProgramDescription description;
  description.name = "edges";
  description.stages = {{GL_VERTEX_SHADER, {"edge.vert"}}, {GL_FRAGMENT_SHADER, {"edge.frag"}}};
  description.shaders.tables = {shaders()};
  if (curves) description.shaders.defines.emplace_back("CURVES");
  if (samples > 1) description.shaders.defines.emplace_back("SAMPLES");
  return description;
}

/// Attributes of floats, one set an instance.
core::Expected<gl::VertexArray> make_array(const gl::Functions& gl, std::span<const std::array<GLuint, 2>> parts) {
  gl::VertexArray array(gl);
  if (auto made = gl::check_names(gl, {array.id()}, "vertex array of edges"); !made)
    return tl::unexpected(made.error());
  for (GLuint i = 0; i < parts.size(); ++i) {
    gl.EnableVertexArrayAttrib(array.id(), i);
    gl.VertexArrayAttribFormat(array.id(), i, GLint(parts[i][0]), GL_FLOAT, GL_FALSE, parts[i][1]);
    gl.VertexArrayAttribBinding(array.id(), i, 0);
  }
  gl.VertexArrayBindingDivisor(array.id(), 0, 1);
  return array;
}

}  // namespace

std::vector<gl::PipelineDescription> EdgePass::all_programs() {
  std::vector<gl::PipelineDescription> all;
  for (const int samples : {1, 2})
    for (const bool curves : {false, true}) all.push_back({describe_edges(samples, curves)});
  return all;
}

core::Expected<void> EdgePass::add(std::span<const EdgeSegment> segments) {
  if (segments.empty()) return {};
  const std::size_t used = segment_count_ * sizeof(EdgeSegment), bytes = used + segments.size_bytes();
  if (bytes > segments_.size()) {
    const std::size_t larger = std::bit_ceil(std::max(bytes, kLeastSegments * sizeof(EdgeSegment)));
    auto made = segments_.enlarged(*gl_, larger, GL_DYNAMIC_STORAGE_BIT, "edges of meshes");
    if (auto done = core::store(std::move(made), segments_); !done) return done;
  }
  segments_.write(used, segments.size_bytes(), segments.data());
  segment_count_ += std::uint32_t(segments.size());
  return {};
}

void EdgePass::clear() {
  segments_ = {};
  segment_count_ = 0;
}

/// Makes what is not there yet, and an empty image of covers as large as the image.
core::Expected<void> EdgePass::prepare(const RenderTarget& image) {
  if (mesh_program_.id() == 0) {
    const int samples = image.format().samples;
    constexpr std::array<std::array<GLuint, 2>, 2> kOfSegments{{{3, 0}, {3, 12}}};
    constexpr std::array<std::array<GLuint, 2>, 4> kOfCurves{{{3, 0}, {3, 12}, {3, 24}, {2, 36}}};
    auto done = core::store(make_array(*gl_, kOfSegments), mesh_array_);
    if (done) done = core::store(make_array(*gl_, kOfCurves), curve_array_);
    if (done) done = core::store(gl::Program::create(*gl_, describe_edges(samples, true)), curve_program_);
    if (done) done = core::store(gl::Program::create(*gl_, describe_edges(samples, false)), mesh_program_);
    if (!done) return done;
  }
  if (cover_.width() != image.width() || cover_.height() != image.height()) {
    framebuffer_ = {};
    auto done = core::store(gl::Texture2D::create(*gl_, image.width(), image.height(), GL_R8, "edges"), cover_);
    const gl::Attachment attachments[] = {{GL_COLOR_ATTACHMENT0, &cover_}};
    if (done) done = core::store(gl::Framebuffer::create(*gl_, attachments, "edges"), framebuffer_);
    if (!done) return done;
  }
  const float nothing[4] = {0.0f, 0.0f, 0.0f, 0.0f};
  gl::reset_pipeline_state(*gl_);
  gl_->ClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 0, nothing);
  return {};
}

core::Expected<void> EdgePass::upload(std::span<const CurvedLine> curves) {
  if (curves.size_bytes() > curves_.size()) {
    const std::size_t count = std::bit_ceil(std::max(curves.size(), kLeastCurves));
    auto made = gl::Buffer::create(*gl_, count * sizeof(CurvedLine), nullptr, GL_DYNAMIC_STORAGE_BIT, "curved edges");
    if (auto done = core::store(std::move(made), curves_); !done) return done;
  }
  if (!curves.empty()) curves_.write(0, curves.size_bytes(), curves.data());
  return {};
}

void EdgePass::set_view(const gl::Program& program, const RenderTarget& image, const core::View& view,
                        const LineStyle& style) {
  const gl::Functions& gl = *gl_;
  const GLuint id = program.id();
  const core::dmat4 clip = gpuprims::reversed_clip_from_eye(view);
  const glm::mat4 clip_from_eye(clip), eye_from_clip(glm::inverse(clip));
  const float half_width = 0.5f * style.width;
  gl.ProgramUniformMatrix4fv(id, kClipFromEye, 1, GL_FALSE, &clip_from_eye[0][0]);
  gl.ProgramUniformMatrix4fv(id, kEyeFromClip, 1, GL_FALSE, &eye_from_clip[0][0]);
  gl.ProgramUniform3f(id, kImage, float(image.width()), float(image.height()), half_width + 1.0f);
  gl.ProgramUniform1f(id, kHalfWidth, half_width);
  const glm::vec2 step = gpuprims::pixel_depth(view, image.height());
  gl.ProgramUniform4f(id, kEdgePixelDepth, step.x, step.y, kHiddenPixels + style.surface_error, kSectionShare);
  const glm::vec2 sample = 0.5f + image.sample_offsets().front();
  gl.ProgramUniform2f(id, kSamplePlace, sample.x, sample.y);
  const glm::dmat4 world_from_eye = glm::inverse(view.eye_from_world());
  std::array<glm::vec4, core::kMaxSectionPlanes> planes{};
  int count = 0;
  for (const core::Plane& plane : view.sections)
    if (plane.normal != core::dvec3(0.0) && count < int(planes.size()))
      planes[std::size_t(count++)] = glm::vec4(glm::transpose(world_from_eye) *
                                               core::dvec4(plane.normal, plane.offset) / glm::length(plane.normal));
  gl.ProgramUniform4fv(id, kEdgeSections, GLsizei(planes.size()), &planes[0].x);
  gl.ProgramUniform2i(id, kSectionCount, count, view.section_mode == core::SectionMode::kUnion ? 1 : 0);
}

void EdgePass::draw_meshes(std::span<const MeshLines> meshes) const {
  mesh_program_.use();
  mesh_array_.bind();
  const GLuint id = mesh_program_.id();
  for (const MeshLines& lines : meshes) {
    gl_->VertexArrayVertexBuffer(mesh_array_.id(), 0, segments_.id(), GLintptr(lines.first * sizeof(EdgeSegment)),
                                 sizeof(EdgeSegment));
    gl_->ProgramUniformMatrix4fv(id, kEyeFromMesh, 1, GL_FALSE, &lines.eye_from_mesh[0][0]);
    gl_->ProgramUniform1f(id, kStrength, lines.strength);
    gl_->DrawArraysInstanced(GL_TRIANGLES, 0, kPartVertices, GLsizei(lines.count));
  }
}

void EdgePass::draw_curves(std::span<const CurvedLine> curves) const {
  curve_program_.use();
  curve_array_.bind();
  for (std::size_t first = 0, end = 0; first < curves.size(); first = end) {
    while (end < curves.size() && curves[end].parts == curves[first].parts) ++end;
    const auto parts = GLsizei(curves[first].parts);
    gl_->VertexArrayVertexBuffer(curve_array_.id(), 0, curves_.id(), GLintptr(first * sizeof(CurvedLine)),
                                 sizeof(CurvedLine));
    gl_->ProgramUniform1i(curve_program_.id(), kParts, parts);
    gl_->DrawArraysInstanced(GL_TRIANGLES, 0, kPartVertices * parts, GLsizei(end - first));
  }
}

core::Expected<void> EdgePass::draw(const RenderTarget& image, const core::View& view,
                                    std::span<const MeshLines> meshes, std::span<const CurvedLine> curves,
                                    const LineStyle& style) {
  if (meshes.empty() && curves.empty()) return {};
  auto ready = prepare(image);
  if (ready) ready = upload(curves);
  if (!ready) return ready;
  const auto put = pass_.program(put_program_, kPutEdges, 1);
  if (!put) return tl::unexpected(put.error());
  const gl::Functions& gl = *gl_;
  set_view(mesh_program_, image, view, style);
  set_view(curve_program_, image, view, style);
  framebuffer_.bind();
  gl.Viewport(0, 0, image.width(), image.height());
  gl.Enablei(GL_BLEND, 0);
  gl.BlendEquationSeparatei(0, GL_MAX, GL_MAX);
  gl.BindProgramPipeline(0);
  gl.BindTextureUnit(0, image.depth().id());
  draw_meshes(meshes);
  draw_curves(curves);
  gl.UseProgram(0);
  gl::unbind_texture(gl, 0, image.texture_target());

  pass_.begin(**put, {image.framebuffer().id(), 0, 0, image.width(), image.height()});
  gl.DepthMask(GL_FALSE);
  pass_.blend();
  gl.ProgramUniform3f((*put)->id(), kEdgeColour, style.colour.r, style.colour.g, style.colour.b);
  const GLuint cover = cover_.id();
  pass_.draw(**put, {&cover, 1}, GL_TEXTURE_2D);
  gl::reset_pipeline_state(gl);
  return {};
}

}  // namespace sightline::render
