#include "sightline/culling/gpu/internal/gpu_pass.h"

#include <algorithm>

#include "sightline/culling/gpu/internal/shaders.h"

namespace sightline::culling {

core::Expected<void> BatchPrograms::make(const gl::Functions& gl, std::span<const CullBatch> batches,
                                         const std::function<gl::ProgramDescription(ProgramKind)>& describe) {
  std::vector<gl::ProgramDescription> descriptions;
  std::vector<std::size_t> kinds;
  for (std::size_t kind = 0; kind < kProgramKinds; ++kind) {
    const auto wants = [&](const CullBatch& batch) { return std::size_t(program_kind(batch)) == kind; };
    if (programs_[kind].id() != 0 || std::none_of(batches.begin(), batches.end(), wants)) continue;
    descriptions.push_back(describe(ProgramKind(kind)));
    kinds.push_back(kind);
  }
  if (kinds.empty()) return {};
  auto programs = gl::Program::create_all(gl, descriptions);
  if (!programs) return tl::unexpected(programs.error());
  for (std::size_t i = 0; i < programs->size(); ++i) programs_[kinds[i]] = std::move((*programs)[i]);
  return {};
}

gl::ProgramDescription describe_pass(std::string name, std::vector<gl::StageDescription> stages, ProgramKind kind,
                                     Selection selection) {
  gl::ProgramDescription description;
  description.name = std::move(name);
  description.stages = std::move(stages);
  description.shaders = gpuscene::DrawLists::shader_context();
  description.shaders.tables.push_back(shaders());
  std::vector<std::string>& defines = description.shaders.defines;
  if (kind != ProgramKind::kRecords) defines.emplace_back("MESHES");
  if (kind == ProgramKind::kParts) defines.emplace_back("PARTS");
  if (selection != Selection::kAll) {
    constexpr const char* kDefines[] = {"", "SAMPLED", "UNOCCLUDED_BEFORE", "UNOCCLUDED_NOW"};
    defines.emplace_back("FOR_IMAGE");
    defines.emplace_back(kDefines[std::size_t(selection)]);
    if (counts_in_view(selection)) defines.emplace_back("COUNTS_IN_VIEW");
  }
  return description;
}

void bind_selection(const gl::Functions& gl, const gl::Program& program, const CullList& list, Selection selection) {
  constexpr GLint kExemptUniform = 1;
  constexpr GLuint kUnoccludedFramesBinding = 5;
  const CullBatch& batch = list.batch;
  if (selection != Selection::kAll)
    gl.ProgramUniform1i(program.id(), kExemptUniform,
                        list.parts ? batch.parts->exempt : batch.kind == gpuscene::BatchKind::kLine);
  if (tests_occlusion(selection))
    gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, kUnoccludedFramesBinding,
                      (list.parts ? batch.parts->unoccluded_frames : batch.unoccluded_frames).id());
}

void bind_list(const gl::Functions& gl, const gl::Program& program, const CullList& list) {
  constexpr GLint kOfPartsUniform = 3;
  const CullBatch& batch = list.batch;
  if (batch.parts) gl.ProgramUniform1i(program.id(), kOfPartsUniform, list.parts);
  gl.BindTextureUnit(kClusterBoxUnit, batch.bounds.cluster_boxes().texels.id());
  gl.BindTextureUnit(kClusterLayerUnit, batch.bounds.cluster_layers().texels.id());
  gl.BindTextureUnit(kItemBoxUnit, batch.bounds.item_boxes().texels.id());
  gl.BindTextureUnit(kItemLayerUnit, batch.bounds.item_layers().texels.id());
  gl.BindTextureUnit(kCommandUnit, batch.commands.texels.id());
  if (!list.parts) return;
  gl.BindTextureUnit(kPartClusterUnit, batch.parts->clusters().texels.id());
  gl.BindTextureUnit(kPartDetailUnit, batch.parts->details().texels.id());
}

}  // namespace sightline::culling
