#include "sightline/culling/gpu/gpu_pass.h"

#include "sightline/culling/gpu/shaders.h"

namespace sightline::culling {

core::Expected<void> BatchPrograms::make(const gl::Functions& gl, std::span<const CullBatch> batches,
                                         const std::function<gl::ProgramDescription(const CullBatch&)>& describe) {
  std::vector<std::string> keys;
  std::vector<gl::ProgramDescription> descriptions;
  for (const CullBatch& batch : batches) {
    gl::ProgramDescription description = describe(batch);
    std::string key;
    for (const auto& stage : description.stages)
      for (const auto& file : stage.files) key += file + ' ';
    for (const auto& define : description.shaders.defines) key += define + ' ';
    std::size_t& index = index_[std::size_t(batch.kind)];
    for (index = 0; index < keys.size() && keys[index] != key;) ++index;
    if (index < keys.size()) continue;
    descriptions.push_back(std::move(description));
    keys.push_back(std::move(key));
  }
  auto programs = gl::Program::create_all(gl, descriptions);
  if (!programs) return tl::unexpected(programs.error());
  programs_ = std::move(*programs);
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

gl::ProgramDescription describe_item_pass(std::string name, const CullBatch& batch,
                                          std::vector<gl::StageDescription> stages) {
  gl::ProgramDescription description = describe_pass(std::move(name), std::move(stages));
  const auto define = [&](const char* what) { description.shaders.defines.emplace_back(what); };
  if (batch.bounds.form() == GpuBoundsForm::kFloat) define("BOUNDS_FLOAT");
  if (batch.bounds.form() == GpuBoundsForm::kCompact) define("BOUNDS_COMPACT");
  if (batch.bounds.form() != GpuBoundsForm::kParameters) return description;
  static constexpr std::array<const char*, 7> kShapes = {
      "SHAPE_CYLINDER",          "SHAPE_SNOUT",   "SHAPE_TORUS", "SHAPE_CAP",
      "SHAPE_RECTANGULAR_TORUS", "SHAPE_PYRAMID", "SHAPE_BOX"};  // of the first batch kinds
  define(kShapes[std::size_t(batch.kind)]);
  return description;
}

void bind_batch(const gl::Functions& gl, const CullBatch& batch) {
  gl.BindTextureUnit(kClusterBoxUnit, batch.bounds.cluster_boxes().texels.id());
  gl.BindTextureUnit(kClusterLayerUnit, batch.bounds.cluster_layers().texels.id());
  gl.BindTextureUnit(kItemBoxUnit, batch.bounds.item_boxes().texels.id());
  gl.BindTextureUnit(kItemLayerUnit, batch.bounds.item_layers().texels.id());
  gl.BindTextureUnit(kCommandUnit, batch.commands.texels.id());
  if (batch.bounds.form() != GpuBoundsForm::kParameters) return;
  gl.BindTextureUnit(kRecordUnit, batch.record_texels);
  gl.BindTextureUnit(kChunkUnit, batch.chunk_texels);
}

}  // namespace sightline::culling
