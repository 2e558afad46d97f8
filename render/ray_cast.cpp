#include "sightline/render/ray_cast.h"

#include <cstring>

#include "sightline/gl/internal/shader_source.h"
#include "sightline/gpuprims/internal/packing.h"
#include "sightline/gpuprims/internal/view_block.h"
#include "sightline/gpuscene/internal/batch_kinds.h"
#include "sightline/gpuscene/internal/record_commands.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::render {

core::Expected<RayCastProgram> ray_cast_program(core::Kind kind, const RayCastFormat& format) {
  const gpuscene::BatchKind batch = gpuscene::batch_of(kind);
  if (!gpuscene::is_ray_cast(batch))
    return core::fail("'" + std::string(core::name_of(kind)) + "' is a kind that is not ray-cast");
  const auto cut = format.sections ? Renderer::Cut::kPlain : Renderer::Cut::kNone;
  gl::ShaderContext context =
      Renderer::describe_batch(batch, {.normals = format.normals, .samples = format.samples}, cut, Surface::kSolid)
          .shaders;
  for (std::string& define : gpuscene::batch_kind_defines()) context.defines.push_back(std::move(define));
  context.defines.emplace_back("PROXY_CORNERS");
  if (format.plain_depth) context.defines.emplace_back("PLAIN_DEPTH");
  const std::string files[] = {"primitive.vert", "primitive.frag"};
  auto vertex = gl::assemble_stage(context, std::span(files).first(1));
  if (!vertex) return tl::unexpected(vertex.error());
  auto fragment = gl::assemble_stage(context, std::span(files).last(1));
  if (!fragment) return tl::unexpected(fragment.error());
  return RayCastProgram{std::move(vertex->text), std::move(fragment->text), std::uint32_t(batch),
                        gpuscene::texels_per_record(batch)};
}

void append_ray_cast_record(const core::Primitive& primitive, const core::Placement& placement, std::uint32_t id,
                            std::uint32_t material, std::vector<std::uint32_t>& records) {
  const core::Kind kind = core::kind_of(primitive);
  std::vector<gpuprims::Texel> texels(std::size_t(gpuprims::texels_per_item(kind)));
  gpuprims::pack(kind, core::parameters(primitive), {placement, id, material & gpuprims::kMaterialMask}, texels);
  for (const gpuprims::Texel& texel : texels) records.insert(records.end(), texel.begin(), texel.end());
}

std::vector<std::uint32_t> ray_cast_indices(std::uint32_t records) {
  std::vector<std::uint32_t> indices;
  indices.reserve(records * gpuscene::kProxyTriangles.size());
  for (std::uint32_t record = 0; record < records; ++record)
    for (const std::uint32_t corner : gpuscene::kProxyTriangles) indices.push_back(8 * record + corner);
  return indices;
}

core::Expected<std::vector<std::byte>> ray_cast_view(const core::View& view, int width, int height) {
  return gpuprims::make_view_block(view, width, height).map([](const gpuprims::ViewBlock& block) {
    std::vector<std::byte> bytes(sizeof block);
    std::memcpy(bytes.data(), &block, sizeof block);
    return bytes;
  });
}

std::vector<glm::vec4> ray_cast_origins(const core::View& view, std::span<const core::dvec3> origins) {
  std::vector<glm::vec4> rows;
  gpuprims::eye_relative_origins(view, origins, rows);
  return rows;
}

}  // namespace sightline::render
