#include "sightline/culling/gpu/internal/gpu_occlusion.h"

#include "sightline/core/internal/store.h"
#include "sightline/culling/gpu/internal/gpu_pass.h"
#include "sightline/gl/internal/pipeline_state.h"
#include "sightline/gpuprims/internal/view_block.h"

namespace sightline::culling {
namespace {

constexpr GLuint kDepthUnit = 0, kFarthestBinding = 0;
constexpr GLint kLevelUniform = 0, kFinerUniform = 1, kEyeFromDepthUniform = 1;

GLuint groups(int blocks) {
  return (GLuint(blocks) + kPyramidGroup - 1) / kPyramidGroup;
}

gl::ProgramDescription describe_pyramid(bool pixels) {
  auto pass = describe_pass("depth pyramid", {{GL_COMPUTE_SHADER, {"build_pyramid.comp"}}}, ProgramKind::kRecords);
  if (pixels) pass.shaders.defines.emplace_back("PIXELS");
  return pass;
}

}  // namespace

std::vector<gl::PipelineDescription> GpuDepthPyramid::all_programs() {
  return {{describe_pyramid(true)}, {describe_pyramid(false)}};
}

core::Expected<GpuDepthPyramid> GpuDepthPyramid::create(const gl::Functions& gl) {
  auto programs = gl::Program::create_all(gl, std::array{describe_pyramid(true), describe_pyramid(false)});
  if (!programs) return tl::unexpected(programs.error());
  GpuDepthPyramid made;
  made.gl_ = &gl;
  made.pixels_ = std::move((*programs)[0]);
  made.blocks_ = std::move((*programs)[1]);
  return made;
}

core::Expected<void> GpuDepthPyramid::resize(int width, int height) {
  if (!levels_.empty() && levels_[0].width == width && levels_[0].height == height) return {};
  levels_ = DepthPyramid::levels_of(width, height);
  if (levels_.size() > std::size_t(kMaxLevels)) return core::fail("depth pyramid: the image is too large");
  return core::store(
      gl::TexelArray::create(*gl_, levels_.back().end() * sizeof(float), nullptr, GL_R32F, "depth pyramid", 0), array_);
}

core::Expected<void> GpuDepthPyramid::build(const gl::Texture2D& depth, const core::View& view) {
  if (auto done = resize(depth.width(), depth.height()); !done) {
    levels_.clear();
    return done;
  }
  const core::dmat4 clip = gpuprims::reversed_clip_from_eye(view);
  const GLdouble eye_from_depth[] = {clip[3][2], clip[3][3], clip[2][2], clip[2][3]};  // gpuprims::eye_depth()
  gl_->ProgramUniform4dv(pixels_.id(), kEyeFromDepthUniform, 1, eye_from_depth);
  gl_->BindTextureUnit(kDepthUnit, depth.id());
  gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, kFarthestBinding, array_.buffer.id());
  const auto set_level = [&](const gl::Program& program, GLint uniform, const DepthPyramid::Level& level) {
    gl_->ProgramUniform3ui(program.id(), uniform, GLuint(level.first), GLuint(level.width), GLuint(level.height));
  };
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    const DepthPyramid::Level& level = levels_[i];
    const gl::Program& program = i == 0 ? pixels_ : blocks_;
    set_level(program, kLevelUniform, level);
    if (i > 0) {
      const DepthPyramid::Level& finer = levels_[i - 1];
      set_level(program, kFinerUniform, finer);
    }
    program.use();
    gl_->DispatchCompute(groups(level.width), groups(level.height), 1);
    gl_->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
  }
  gl::unbind_texture(*gl_, kDepthUnit, GL_TEXTURE_2D);  // it will be drawn to
  return {};
}

}  // namespace sightline::culling
