#include "sightline/gl/internal/program.h"

#include <utility>

#include <fmt/format.h>

#include "sightline/gl/internal/program_cache.h"

namespace sightline::gl {
namespace {

using Shader = Handle<&Functions::DeleteShader>;

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

/// Describes the place of a stage's error: program, stage and first file.
std::string place_of(const ProgramDescription& program, const StageDescription& stage) {
  return fmt::format("GL program '{}', {} stage {}", program.name, stage_name(stage.stage),
                     stage.files.empty() ? "without files" : stage.files.front());
}

core::Expected<std::vector<StageSource>> assemble(const ProgramDescription& description, Workarounds workarounds) {
  const ShaderContext context = with_workarounds(description.shaders, workarounds);
  std::vector<StageSource> sources;
  for (const StageDescription& stage : description.stages) {
    auto source = assemble_stage(context, stage.files);
    if (!source) return core::fail(place_of(description, stage) + ": " + source.error().message);
    sources.push_back(std::move(*source));
  }
  return sources;
}

/// Everything that the result of linking depends on.
std::string cache_key(const ProgramDescription& description, const std::vector<StageSource>& sources) {
  std::string key;
  for (std::size_t i = 0; i < sources.size(); ++i)
    key += fmt::format("stage {:#x}, {} bytes\n{}\n", description.stages[i].stage, sources[i].text.size(),
                       sources[i].text);
  for (const std::string& name : description.feedback_varyings) key += fmt::format("feedback {}\n", name);
  return key + fmt::format("mode {:#x}, separable {}\n", description.feedback_mode, description.separable);
}

void set_feedback(const Functions& gl, GLuint program, const ProgramDescription& description) {
  if (description.feedback_varyings.empty()) return;
  std::vector<const GLchar*> names;
  for (const std::string& name : description.feedback_varyings) names.push_back(name.c_str());
  gl.TransformFeedbackVaryings(program, static_cast<GLsizei>(names.size()), names.data(), description.feedback_mode);
}

}  // namespace

struct Program::Pending {
  Program program;
  std::vector<StageSource> sources;
  std::vector<Shader> shaders;
  std::string key;  // empty without a cache
  bool cached = false;
};

/// Makes no query for which the driver would have to finish compiling.
core::Expected<Program::Pending> Program::begin(const Functions& gl, const ProgramDescription& description) {
  auto sources = assemble(description, gl.workarounds);
  if (!sources) return tl::unexpected(sources.error());
  Pending pending;
  pending.sources = std::move(*sources);
  pending.program.handle_ = Handle<&Functions::DeleteProgram>(gl, gl.CreateProgram());
  const GLuint program = pending.program.id();
  if (auto made = check_names(gl, {program}, fmt::format("program '{}'", description.name)); !made)
    return tl::unexpected(made.error());
  if (description.separable) gl.ProgramParameteri(program, GL_PROGRAM_SEPARABLE, GL_TRUE);
  if (gl.program_cache && gl.program_cache->enabled()) {
    pending.key = cache_key(description, pending.sources);
    pending.cached = gl.program_cache->load(gl, program, pending.key);
    if (pending.cached) return pending;
    gl.ProgramParameteri(program, GL_PROGRAM_BINARY_RETRIEVABLE_HINT, GL_TRUE);
  }
  for (std::size_t i = 0; i < description.stages.size(); ++i) {
    Shader shader(gl, gl.CreateShader(description.stages[i].stage));
    if (!shader.name()) return core::fail(place_of(description, description.stages[i]) + ": not a shader stage");
    const GLchar* text = pending.sources[i].text.data();
    const auto length = static_cast<GLint>(pending.sources[i].text.size());
    gl.ShaderSource(shader.name(), 1, &text, &length);
    gl.CompileShader(shader.name());
    gl.AttachShader(program, shader.name());
    pending.shaders.push_back(std::move(shader));
  }
  set_feedback(gl, program, description);
  gl.LinkProgram(program);
  return pending;
}

core::Expected<Program> Program::finish(const Functions& gl, const ProgramDescription& description, Pending pending) {
  const GLuint program = pending.program.id();
  if (!pending.cached) {
    GLint linked = GL_FALSE;
    gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
    for (std::size_t i = 0; !linked && i < pending.shaders.size(); ++i) {
      const GLuint shader = pending.shaders[i].name();
      GLint compiled = GL_FALSE;
      gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
      if (!compiled)
        return core::fail(place_of(description, description.stages[i]) + " does not compile:\n" +
                          name_files_in_log(shader_log(gl, shader), pending.sources[i].files));
    }
    if (!linked)
      return core::fail(fmt::format("GL program '{}' does not link:\n{}", description.name, program_log(gl, program)));
    for (const Shader& shader : pending.shaders) gl.DetachShader(program, shader.name());
    if (!pending.key.empty()) gl.program_cache->store(gl, program, pending.key);
  }
  if (!description.name.empty())
    gl.ObjectLabel(GL_PROGRAM, program, static_cast<GLsizei>(description.name.size()), description.name.data());
  return std::move(pending.program);
}

bool Program::is_cached(const Functions& gl, const ProgramDescription& description) {
  if (!gl.program_cache || !gl.program_cache->enabled()) return false;
  const auto sources = assemble(description, gl.workarounds);
  return sources && gl.program_cache->has(cache_key(description, *sources));
}

core::Expected<Program> Program::create(const Functions& gl, const ProgramDescription& description) {
  auto programs = create_all(gl, std::span(&description, 1));
  if (!programs) return tl::unexpected(programs.error());
  return std::move(programs->front());
}

core::Expected<std::vector<Program>> Program::create_all(const Functions& gl,
                                                         std::span<const ProgramDescription> descriptions) {
  std::vector<Pending> pending;
  for (const ProgramDescription& description : descriptions) {
    auto begun = begin(gl, description);
    if (!begun) return tl::unexpected(begun.error());
    pending.push_back(std::move(*begun));
  }
  std::vector<Program> programs;
  for (std::size_t i = 0; i < descriptions.size(); ++i) {
    auto program = finish(gl, descriptions[i], std::move(pending[i]));
    if (!program) return tl::unexpected(program.error());
    programs.push_back(std::move(*program));
  }
  return programs;
}

}  // namespace sightline::gl
