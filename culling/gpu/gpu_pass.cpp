#include "sightline/culling/gpu/internal/gpu_pass.h"

#include <algorithm>

#include "sightline/culling/gpu/internal/shaders.h"

namespace sightline::culling {

core::Expected<void> BatchPrograms::make(const gl::Functions& gl, std::span<const CullBatch> batches,
                                         const std::function<gl::ProgramDescription(bool meshes)>& describe) {
  std::vector<gl::ProgramDescription> descriptions;
  std::vector<bool> of_meshes;
  for (const bool meshes : {false, true}) {
    if (std::none_of(batches.begin(), batches.end(), [&](const CullBatch& b) { return b.meshes() == meshes; }))
      continue;
    descriptions.push_back(describe(meshes));
    of_meshes.push_back(meshes);
  }
  auto programs = gl::Program::create_all(gl, descriptions);
  if (!programs) return tl::unexpected(programs.error());
  for (std::size_t i = 0; i < programs->size(); ++i) programs_[of_meshes[i]] = std::move((*programs)[i]);
  return {};
}

gl::ProgramDescription describe_pass(std::string name, std::vector<gl::StageDescription> stages, Selection selection) {
  gl::ProgramDescription description;
  description.name = std::move(name);
  description.stages = std::move(stages);
  description.shaders = gpuscene::DrawLists::shader_context();
  description.shaders.tables.push_back(shaders());
  std::vector<std::string>& defines = description.shaders.defines;
  if (selection != Selection::kAll) {
    constexpr const char* kDefines[] = {"", "SAMPLED", "UNOCCLUDED_BEFORE", "UNOCCLUDED_NOW"};
    defines.emplace_back("FOR_IMAGE");
    defines.emplace_back(kDefines[std::size_t(selection)]);
    if (counts_in_view(selection)) defines.emplace_back("COUNTS_IN_VIEW");
  }
  return description;
}

void bind_selection(const gl::Functions& gl, const gl::Program& program, const CullBatch& batch, Selection selection) {
  constexpr GLint kExemptUniform = 1;
  constexpr GLuint kUnoccludedFramesBinding = 5;
  if (selection != Selection::kAll)
    gl.ProgramUniform1i(program.id(), kExemptUniform, batch.kind == gpuscene::BatchKind::kLine);
  if (tests_occlusion(selection))
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kUnoccludedFramesBinding, batch.unoccluded_frames.id());
}

void bind_batch(const gl::Functions& gl, const CullBatch& batch) {
  gl.BindTextureUnit(kClusterBoxUnit, batch.bounds.cluster_boxes().texels.id());
  gl.BindTextureUnit(kClusterLayerUnit, batch.bounds.cluster_layers().texels.id());
  gl.BindTextureUnit(kItemBoxUnit, batch.bounds.item_boxes().texels.id());
  gl.BindTextureUnit(kItemLayerUnit, batch.bounds.item_layers().texels.id());
  gl.BindTextureUnit(kCommandUnit, batch.commands.texels.id());
}

}  // namespace sightline::culling
