// gl: the thin OpenGL leaf. A loader and its table of entry points, a context (EGL offscreen, or a foreign one
// adopted), move-only objects (buffers, textures, framebuffers, programs, timers) and debug output as values. Knows
// nothing of scenes. OpenGL 4.5 core with direct state access is the floor. Depends on core's error type alone.
//
// This header is the table. There is no global state: a Functions value belongs to a Context and is passed on by const
// reference. Members are plain function pointers, so a test may copy the table and replace some to count calls.
#pragma once

#include <string>
#include <vector>

#include <GL/glcorearb.h>

#include "sightline/core/error.h"

namespace sightline::gl {

/// Oldest context that will do.
inline constexpr int kRequiredMajor = 4;
inline constexpr int kRequiredMinor = 5;

class ProgramCache;

using Proc = void (*)();
/// Finds an entry point by its full name ("glEnable"); null when unknown. `user` is what was given beside the callback.
/// Suits eglGetProcAddress, OSMesaGetProcAddress and glfwGetProcAddress, each behind a one-line wrapper.
using GetProc = Proc (*)(const char* name, void* user);

/// OpenGL entry points without their gl prefix. Core ones are never null after load_functions(); those of extensions
/// are null unless the context lists the extension (platforms hand out addresses for names they do not know).
struct Functions {
#define SIGHTLINE_GL_FUNCTION(name, type) PFNGL##type##PROC name = nullptr;
#define SIGHTLINE_GL_EXTENSION(name, type, extension) PFNGL##type##PROC name = nullptr;
#include "sightline/gl/internal/function_table.inc"

  /// Beside the entry points: where Program looks before it compiles, see Context::cache_programs(). Null: nowhere.
  const ProgramCache* program_cache = nullptr;
};

/// Loads the table for the context that is current on this thread. Fails when none is, when it is older than 4.5 (with
/// the version found) or when entry points are missing (with all their names).
core::Expected<Functions> load_functions(GetProc get_proc, void* user);

/// The extensions that the current context lists.
std::vector<std::string> list_extensions(const Functions& gl);

/// "GL_INVALID_OPERATION" and so on; the number in hexadecimal for others.
std::string error_name(GLenum error);

/// Makes what frees objects do nothing, for a table whose context is gone and took them along: what still owns some may
/// then be destroyed at any time, whichever context is current.
void stop_freeing(Functions& gl);

/// Reads and forgets pending errors, so that the next check_error() speaks of what happened in between only. In a debug
/// context the debug log has them already.
void discard_errors(const Functions& gl);

/// The oldest pending error, GL_NO_ERROR when there is none; forgets all others.
GLenum check_error(const Functions& gl);

}  // namespace sightline::gl
