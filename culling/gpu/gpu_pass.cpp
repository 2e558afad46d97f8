#include "sightline/culling/gpu/gpu_pass.h"

#include "sightline/culling/gpu/shaders.h"

namespace sightline::culling {

core::Expected<void> BatchPrograms::make(const gl::Functions& gl, std::span<const CullBatch> batches,
                                         const std::function<gl::ProgramDescription(const CullBatch&)>& describe) {
  std::vector<std::string> keys;
  for (const CullBatch& batch : batches) {
    const gl::ProgramDescription description = describe(batch);
    std::string key;
    for (const auto& stage : description.stages)
      for (const auto& file : stage.files) key += file + ' ';
    for (const auto& define : description.shaders.defines) key += define + ' ';
    std::size_t& index = index_[std::size_t(batch.kind)];
    for (index = 0; index < keys.size() && keys[index] != key;) ++index;
    if (index < keys.size()) continue;
    auto program = gl::Program::create(gl, description);
    if (!program) return tl::unexpected(program.error());
    programs_.push_back(std::move(*program));
    keys.push_back(std::move(key));
  }
  return {};
}

gl::ProgramDescription describe_pass(std::string name, std::vector<gl::StageDescription> stages) {
  gl::ProgramDescription description;
  description.name = std::move(name);
  description.stages = std::move(stages);
  description.shaders = gpuscene::DrawLists::shader_context();
  description.shaders.tables.push_back(shaders());
  return description;
}

void bind_batch(const gl::Functions& gl, const CullBatch& batch) {
  const GpuBoxes &clusters = batch.bounds.clusters(), &items = batch.bounds.items();
  gl.BindTextureUnit(kClusterBoxUnit, clusters.corner_texels.id());
  gl.BindTextureUnit(kClusterLayerUnit, clusters.layer_texels.id());
  gl.BindTextureUnit(kItemBoxUnit, items.corner_texels.id());
  gl.BindTextureUnit(kItemLayerUnit, items.layer_texels.id());
  gl.BindTextureUnit(kCommandUnit, batch.command_texels.id());
}

}  // namespace sightline::culling
