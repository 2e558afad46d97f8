#include "sightline/gl/functions.h"

#include <algorithm>
#include <cassert>

#include <fmt/format.h>

#include "sightline/gl/internal/handle.h"

namespace sightline::gl {
namespace {

// A lost context may report errors forever.
constexpr int kMaxPendingErrors = 32;

template <class Function>
void load(GetProc get_proc, void* user, const char* name, Function& function, std::string& missing) {
  function = reinterpret_cast<Function>(get_proc(name, user));
  if (!function) missing += (missing.empty() ? "" : ", ") + std::string(name);
}

core::Expected<void> check_version(const Functions& gl) {
  const auto* text = reinterpret_cast<const char*>(gl.GetString(GL_VERSION));
  if (!text) return core::fail("OpenGL: no context is current on this thread");
  GLint major = 0;
  GLint minor = 0;
  gl.GetIntegerv(GL_MAJOR_VERSION, &major);
  gl.GetIntegerv(GL_MINOR_VERSION, &minor);
  if (major > kRequiredMajor || (major == kRequiredMajor && minor >= kRequiredMinor)) return {};
  return core::fail(fmt::format("OpenGL: found version {}, required {}.{} core", text, kRequiredMajor, kRequiredMinor));
}

}  // namespace

core::Expected<Functions> load_functions(GetProc get_proc, void* user) {
  assert(get_proc);
  Functions gl;
  std::string missing;
  load(get_proc, user, "glGetString", gl.GetString, missing);
  load(get_proc, user, "glGetIntegerv", gl.GetIntegerv, missing);
  if (!missing.empty()) return core::fail("OpenGL: missing entry points: " + missing);
  if (auto version = check_version(gl); !version) return tl::unexpected(version.error());
  load(get_proc, user, "glGetStringi", gl.GetStringi, missing);
  if (!missing.empty()) return core::fail("OpenGL: missing entry points: " + missing);

  const std::vector<std::string> extensions = list_extensions(gl);
  const auto listed = [&](const char* name) {
    return std::find(extensions.begin(), extensions.end(), name) != extensions.end();
  };
  std::string optional_missing;
#define SIGHTLINE_GL_FUNCTION(name, type) load(get_proc, user, "gl" #name, gl.name, missing);
#define SIGHTLINE_GL_EXTENSION(name, type, extension) \
  if (listed(extension)) load(get_proc, user, "gl" #name, gl.name, optional_missing);
#include "sightline/gl/function_table.inc"
  if (missing.empty()) return gl;
  return core::fail(fmt::format("OpenGL: missing entry points in version {} (required {}.{} core): {}",
                                reinterpret_cast<const char*>(gl.GetString(GL_VERSION)), kRequiredMajor, kRequiredMinor,
                                missing));
}

std::vector<std::string> list_extensions(const Functions& gl) {
  GLint count = 0;
  gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
  std::vector<std::string> names;
  for (GLint i = 0; i < count; ++i) {
    const auto* name = reinterpret_cast<const char*>(gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i)));
    if (name) names.emplace_back(name);
  }
  return names;
}

std::string error_name(GLenum error) {
  switch (error) {
    case GL_NO_ERROR:
      return "GL_NO_ERROR";
    case GL_INVALID_ENUM:
      return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE:
      return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION:
      return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
      return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_OUT_OF_MEMORY:
      return "GL_OUT_OF_MEMORY";
    case GL_STACK_OVERFLOW:
      return "GL_STACK_OVERFLOW";
    case GL_STACK_UNDERFLOW:
      return "GL_STACK_UNDERFLOW";
    case GL_CONTEXT_LOST:
      return "GL_CONTEXT_LOST";
    default:
      return fmt::format("GL error {:#06x}", error);
  }
}

void stop_freeing(Functions& gl) {
  const auto free_none = [](GLsizei, const GLuint*) {};
  const auto free_not = [](GLuint) {};
  for (auto* entry : {&gl.DeleteBuffers, &gl.DeleteFramebuffers, &gl.DeleteProgramPipelines, &gl.DeleteQueries,
                      &gl.DeleteRenderbuffers, &gl.DeleteSamplers, &gl.DeleteTextures, &gl.DeleteTransformFeedbacks,
                      &gl.DeleteVertexArrays})
    *entry = free_none;
  gl.DeleteProgram = gl.DeleteShader = free_not;
  gl.DeleteSync = [](GLsync) {};
  gl.pinned_memory = false;  // nothing is left that may read it
}

void discard_errors(const Functions& gl) {
  for (int i = 0; i < kMaxPendingErrors && gl.GetError() != GL_NO_ERROR; ++i) {
  }
}

core::Expected<void> check_names(const Functions& gl, std::initializer_list<GLuint> names, std::string_view what) {
  if (std::find(names.begin(), names.end(), 0u) == names.end()) return {};
  return core::fail(fmt::format("GL {}: the driver made no object: {}", what, error_name(check_error(gl))));
}

GLenum check_error(const Functions& gl) {
  const GLenum first = gl.GetError();
  if (first != GL_NO_ERROR) discard_errors(gl);
  return first;
}

}  // namespace sightline::gl
