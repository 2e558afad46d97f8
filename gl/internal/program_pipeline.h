// Program pipeline objects: stages of several separable programs used as one.
#pragma once

#include "sightline/gl/functions.h"
#include "sightline/gl/internal/handle.h"
#include "sightline/gl/internal/program.h"

namespace sightline::gl {

/// Owns a program pipeline object. Move-only.
class ProgramPipeline {
 public:
  ProgramPipeline() = default;
  explicit ProgramPipeline(const Functions& gl) : handle_(gl, create_name<&Functions::CreateProgramPipelines>(gl)) {}

  GLuint id() const { return handle_.name(); }

  /// Takes `stages` (GL_VERTEX_SHADER_BIT | …) from a separable program, which must outlive every use.
  void set_stages(GLbitfield stages, const Program& program) const {
    handle_.gl().UseProgramStages(id(), stages, program.id());
  }
  /// Binds it in place of a program. The order matters: Mesa's glUseProgram(0) binds the former pipeline again, and
  /// reports an error if that was deleted meanwhile.
  void use() const {
    handle_.gl().BindProgramPipeline(id());
    handle_.gl().UseProgram(0);
  }

 private:
  Handle<&Functions::DeleteProgramPipelines> handle_;
};

}  // namespace sightline::gl
