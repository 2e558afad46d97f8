#include "sightline/apps/study/gpu/in_draw.h"

#include <cassert>

#include "sightline/apps/study/gpu/shaders.h"
#include "sightline/gpuprims/internal/shaders.h"
#include "sightline/render/internal/shaders.h"

namespace sightline::study {
namespace {

using gpuscene::BatchKind;

// Texture units of payload.glsl.
constexpr GLuint kPayloadUnit = 0, kSinglesUnit = 3;
constexpr GLint kRecordCountUniform = 0, kBatchKindUniform = 1, kTexelsPerRecordUniform = 2;

gl::ProgramDescription describe_in_draw() {
  gl::ProgramDescription description;
  description.name = "cylinders culled in the draw";
  description.stages = {{GL_VERTEX_SHADER, {"in_draw_names.glsl", "primitive.vert", "in_draw.vert"}},
                        {GL_GEOMETRY_SHADER, {"primitive.geom"}},
                        {GL_FRAGMENT_SHADER, {"primitive.frag"}}};
  description.shaders.tables = {shaders(), render::shaders(), gpuprims::shaders()};
  description.shaders.defines = gpuscene::batch_kind_defines();
  for (std::string& define : gpuscene::batch_defines(BatchKind::kCylinder))
    description.shaders.defines.push_back(std::move(define));
  return description;
}

/// Boxes of the cylinders, in the order of their records.
std::vector<core::Aabb> boxes_of(const core::Snapshot& snapshot) {
  std::vector<core::Aabb> boxes;
  for (core::Slot slot = 0; slot < snapshot.size(); ++slot)
    if (gpuscene::batch_of(snapshot.kind(slot)) == BatchKind::kCylinder) boxes.push_back(snapshot.bounds().box(slot));
  return boxes;
}

}  // namespace

std::vector<gl::PipelineDescription> InDraw::all_programs() {
  return {{describe_in_draw()}};
}

core::Expected<InDraw> InDraw::create(const gl::Context& context, const core::Snapshot& snapshot,
                                      const gpuscene::GpuScene& scene) {
  assert(scene.batch(BatchKind::kCylinder) != nullptr);
  assert(!context.functions().workarounds[gl::Workaround::kNoGeometryStage] && "the test is in the draw of points");
  const gl::Functions& gl = context.functions();
  auto program = gl::Program::create(gl, describe_in_draw());
  if (!program) return tl::unexpected(program.error());
  auto planes = GpuPlanes::create(gl);
  if (!planes) return tl::unexpected(planes.error());
  const std::vector<core::Aabb> by_record = boxes_of(snapshot);
  auto boxes = TexelArray::create(gl, std::span(by_record), GL_RGB32F, 0, "boxes of cylinders");
  if (!boxes) return tl::unexpected(boxes.error());
  auto all = gpuscene::DrawLists::create(context, scene), none = gpuscene::DrawLists::create(context, scene);
  if (!all) return tl::unexpected(all.error());
  if (!none) return tl::unexpected(none.error());
  core::VisibleSet everything;
  everything.ranges = {{0, std::uint32_t(snapshot.size())}};
  if (auto done = all->update(snapshot, scene, everything); !done) return tl::unexpected(done.error());
  if (auto done = none->update(snapshot, scene, {}); !done) return tl::unexpected(done.error());
  InDraw made;
  made.gl_ = &gl;
  made.program_ = std::move(*program);
  made.array_ = gl::VertexArray(gl);
  made.planes_ = std::move(*planes);
  made.boxes_ = std::move(*boxes);
  made.all_ = std::move(*all);
  made.none_ = std::move(*none);
  return made;
}

core::Expected<void> InDraw::draw(const core::View& view, const core::Snapshot& snapshot,
                                  const gpuscene::GpuScene& scene, render::Renderer& renderer,
                                  const render::RenderTarget& target) {
  // An empty draw sets up everything that the renderer's own programs need.
  if (auto done = renderer.draw(view, snapshot, scene, none_, target); !done) return done;
  const culling::CullPlanes planes(view, snapshot.bounds());
  if (planes.nothing_visible()) return {};
  const gl::Functions& gl = *gl_;
  const gpuscene::Batch& batch = *scene.batch(BatchKind::kCylinder);
  const gpuscene::DrawLists::Section& section = all_.section(BatchKind::kCylinder);
  planes_.upload(planes, snapshot.bounds());
  program_.use();
  gl.ProgramUniform1ui(program_.id(), kRecordCountUniform, batch.count);
  gl.ProgramUniform1ui(program_.id(), kBatchKindUniform, GLuint(batch.kind));
  gl.ProgramUniform1i(program_.id(), kTexelsPerRecordUniform, gpuscene::texels_per_record(batch.kind));
  gl.BindTextureUnit(kPayloadUnit, batch.texels.id());
  gl.BindTextureUnit(kSinglesUnit, all_.singles().id());
  gl.BindTextureUnit(kBoxUnit, boxes_.texels.id());
  gl.Enable(GL_DEPTH_CLAMP);
  gl.Enable(GL_CULL_FACE);
  gl.VertexArrayElementBuffer(array_.id(), all_.record_indices().id());
  array_.bind();
  gl.BindBuffer(GL_DRAW_INDIRECT_BUFFER, all_.commands().id());
  gl.MultiDrawElementsIndirect(GL_POINTS, GL_UNSIGNED_SHORT,
                               reinterpret_cast<const void*>(section.offset),  // NOLINT(performance-no-int-to-ptr)
                               section.count, sizeof(gpuscene::ElementsCommand));
  return {};
}

}  // namespace sightline::study
