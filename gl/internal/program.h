// GLSL programs from embedded shader files.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/gl/functions.h"
#include "sightline/gl/internal/handle.h"
#include "sightline/gl/internal/shader_source.h"

namespace sightline::gl {

/// One stage: GL_VERTEX_SHADER, … and its files in order (see assemble_stage()).
struct StageDescription {
  GLenum stage = GL_NONE;
  std::vector<std::string> files;
};

struct ProgramDescription {
  std::string name;  ///< for errors and debug output
  std::vector<StageDescription> stages;
  ShaderContext shaders;                          ///< tables, extensions and defines of every stage
  std::vector<std::string> feedback_varyings;     ///< for transform feedback; "gl_NextBuffer" and the like work
  GLenum feedback_mode = GL_INTERLEAVED_ATTRIBS;  ///< or GL_SEPARATE_ATTRIBS
  bool separable = false;                         ///< for a ProgramPipeline; may then lack stages
};

/// Programs whose stages run together: one, or the separable ones of a ProgramPipeline. Whoever makes programs also
/// lists all that it can ever ask for, so that tests compile them without a context.
using PipelineDescription = std::vector<ProgramDescription>;

/// A linked program. Move-only; a default-made one is empty (id 0).
class Program {
 public:
  Program() = default;

  /// Compiles and links. Fails with the program's name, the stage's first file and the driver's log, in which source
  /// numbers are replaced by file names.
  static core::Expected<Program> create(const Functions& gl, const ProgramDescription& description);
  /// Creates several programs. Begins all before it waits for any, so that drivers with compiler threads compile
  /// all at once; contexts made offscreen ask for these (GL_KHR_parallel_shader_compile). Fails with the first error.
  static core::Expected<std::vector<Program>> create_all(const Functions& gl,
                                                         std::span<const ProgramDescription> descriptions);

  /// Whether the program cache has this program, so that it need not be compiled. False without a cache.
  static bool is_cached(const Functions& gl, const ProgramDescription& description);

  GLuint id() const { return handle_.name(); }
  void use() const { handle_.gl().UseProgram(id()); }

  /// Location of an active uniform; -1 when there is none of that name (a ProgramUniform… call then does nothing). Call
  /// it once and keep the result.
  GLint uniform(const char* name) const { return handle_.gl().GetUniformLocation(id(), name); }

 private:
  struct Pending;
  static core::Expected<Pending> begin(const Functions& gl, const ProgramDescription& description);
  static core::Expected<Program> finish(const Functions& gl, const ProgramDescription& description, Pending pending);

  Handle<&Functions::DeleteProgram> handle_;
};

}  // namespace sightline::gl
