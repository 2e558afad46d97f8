#include "sightline/gl/program.h"

#include <utility>

#include <fmt/format.h>

namespace sightline::gl {
namespace {

void delete_shader(const Functions& gl, GLuint name) {
  gl.DeleteShader(name);
}
using Shader = Handle<delete_shader>;

std::string shader_log(const Functions& gl, GLuint shader) {
  GLint length = 0;
  gl.GetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
  if (length <= 0) return "the driver says nothing";
  std::string log(static_cast<std::size_t>(length), '\0');
  gl.GetShaderInfoLog(shader, length, &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  return log;
}

std::string program_log(const Functions& gl, GLuint program) {
  GLint length = 0;
  gl.GetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
  if (length <= 0) return "the driver says nothing";
  std::string log(static_cast<std::size_t>(length), '\0');
  gl.GetProgramInfoLog(program, length, &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  while (!log.empty() && log.back() == '\n') log.pop_back();
  return log;
}

std::string stage_name(GLenum stage) {
  switch (stage) {
    case GL_VERTEX_SHADER:
      return "vertex";
    case GL_TESS_CONTROL_SHADER:
      return "tessellation control";
    case GL_TESS_EVALUATION_SHADER:
      return "tessellation evaluation";
    case GL_GEOMETRY_SHADER:
      return "geometry";
    case GL_FRAGMENT_SHADER:
      return "fragment";
    case GL_COMPUTE_SHADER:
      return "compute";
    default:
      return fmt::format("{:#06x}", stage);
  }
}

core::Expected<Shader> compile(const Functions& gl, const ProgramDescription& program, const StageDescription& stage) {
  const auto where = [&] {
    return fmt::format("GL program '{}', {} stage {}", program.name, stage_name(stage.stage),
                       stage.files.empty() ? "without files" : stage.files.front());
  };
  auto source = assemble_stage(program.shaders, stage.files);
  if (!source) return core::fail(where() + ": " + source.error().message);
  Shader shader(gl, gl.CreateShader(stage.stage));
  if (!shader.name()) return core::fail(where() + ": not a shader stage");
  const GLchar* text = source->text.data();
  const auto length = static_cast<GLint>(source->text.size());
  gl.ShaderSource(shader.name(), 1, &text, &length);
  gl.CompileShader(shader.name());
  GLint compiled = GL_FALSE;
  gl.GetShaderiv(shader.name(), GL_COMPILE_STATUS, &compiled);
  if (compiled) return shader;
  return core::fail(where() + " does not compile:\n" + name_files_in_log(shader_log(gl, shader.name()), source->files));
}

void set_feedback(const Functions& gl, GLuint program, const ProgramDescription& description) {
  if (description.feedback_varyings.empty()) return;
  std::vector<const GLchar*> names;
  for (const std::string& name : description.feedback_varyings) names.push_back(name.c_str());
  gl.TransformFeedbackVaryings(program, static_cast<GLsizei>(names.size()), names.data(), description.feedback_mode);
}

}  // namespace

namespace detail {
void delete_program(const Functions& gl, GLuint name) {
  gl.DeleteProgram(name);
}
}  // namespace detail

core::Expected<Program> Program::create(const Functions& gl, const ProgramDescription& description) {
  std::vector<Shader> shaders;
  for (const StageDescription& stage : description.stages) {
    auto shader = compile(gl, description, stage);
    if (!shader) return tl::unexpected(shader.error());
    shaders.push_back(std::move(*shader));
  }
  Program program;
  program.handle_ = Handle<detail::delete_program>(gl, gl.CreateProgram());
  for (const Shader& shader : shaders) gl.AttachShader(program.id(), shader.name());
  set_feedback(gl, program.id(), description);
  if (description.separable) gl.ProgramParameteri(program.id(), GL_PROGRAM_SEPARABLE, GL_TRUE);
  gl.LinkProgram(program.id());
  for (const Shader& shader : shaders) gl.DetachShader(program.id(), shader.name());
  GLint linked = GL_FALSE;
  gl.GetProgramiv(program.id(), GL_LINK_STATUS, &linked);
  if (!linked) {
    return core::fail(
        fmt::format("GL program '{}' does not link:\n{}", description.name, program_log(gl, program.id())));
  }
  if (!description.name.empty()) {
    gl.ObjectLabel(GL_PROGRAM, program.id(), static_cast<GLsizei>(description.name.size()), description.name.data());
  }
  return program;
}

}  // namespace sightline::gl
