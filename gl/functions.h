// gl: a thin layer over OpenGL. It has a loader with its table of entry points, a context (EGL offscreen, or adopted),
// move-only objects (buffers, textures, framebuffers, programs, timers) and debug output as values. It knows nothing of
// scenes. It needs OpenGL 4.5 core with direct state access. It depends only on core's error type.
//
// This header is the table. It brings GL's own header, which must not come after <GL/gl.h>; an application that uses
// that one needs gl/context.h alone. There is no global state: a Functions value belongs to a Context and is passed on
// by const reference. Members are plain function pointers, so a test may copy the table and replace some to count
// calls.
#pragma once

#include <string>
#include <vector>

// GL's own header would bring the system's on Windows to define it. Calls are the same without it where there are 64
// bits.
#ifndef APIENTRY
#define APIENTRY
#endif
#include <GL/glcorearb.h>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/gl/get_proc.h"
#include "sightline/gl/workarounds.h"

namespace sightline::gl {

/// Oldest version that is accepted.
inline constexpr int kRequiredMajor = 4;
inline constexpr int kRequiredMinor = 5;

class ProgramCache;

/// OpenGL entry points without their gl prefix. Core ones are never null after load_functions(); those of extensions
/// are null unless the context lists the extension (platforms hand out addresses for names they do not know).
struct Functions {
#define SIGHTLINE_GL_FUNCTION(name, type) PFNGL##type##PROC name = nullptr;
#define SIGHTLINE_GL_EXTENSION(name, type, extension) PFNGL##type##PROC name = nullptr;
#include "sightline/gl/function_table.inc"

  /// Not an entry point: the cache that Program searches before it compiles, see Context::cache_programs(). Null: none.
  const ProgramCache* program_cache = nullptr;
  /// Not an entry point: whether large buffers lie in memory of ours (GL_AMD_pinned_memory), see Buffer. Contexts of
  /// software rasterisers that list the extension set it.
  bool pinned_memory = false;
  /// Not an entry point: what is done in another way with this driver.
  Workarounds workarounds;
  /// Not an entry point: whether a draw may take arguments of an indirect draw before it, until the commands are
  /// flushed. Lavapipe, Mesa's Vulkan without a GPU, does (docs/reference/drivers.md). Draws whose number of commands
  /// lies in a buffer are null then.
  bool stale_indirect_draws = false;
};

/// Loads the table for the context that is current on this thread. Fails when none is, when it is older than 4.5 (with
/// the version found) or when entry points are missing (with all their names).
SIGHTLINE_API core::Expected<Functions> load_functions(GetProc get_proc, void* user);

/// The extensions that the current context lists.
SIGHTLINE_API std::vector<std::string> list_extensions(const Functions& gl);

/// "GL_INVALID_OPERATION" and so on; the number in hexadecimal for others.
SIGHTLINE_API std::string error_name(GLenum error);

/// Replaces all entry points that free objects by ones that do nothing, for a table whose context is gone with its
/// objects. Owners of such objects may then be destroyed at any time, whichever context is current.
SIGHTLINE_API void stop_freeing(Functions& gl);

/// Drops pending errors, so that the next check_error() reports only later ones. In a debug context the debug log
/// already has them.
SIGHTLINE_API void discard_errors(const Functions& gl);

/// The oldest pending error, or GL_NO_ERROR; drops all others.
SIGHTLINE_API GLenum check_error(const Functions& gl);

}  // namespace sightline::gl
