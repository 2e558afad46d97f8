// A GL context: made offscreen through EGL, WGL or OSMesa, or adopted from the application. Needs no header of GL's,
// and so goes with any.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/gl/debug_log.h"
#include "sightline/gl/get_proc.h"
#include "sightline/gl/workarounds.h"

namespace sightline::gl {

struct Functions;  // gl/functions.h

/// Ways to a context without a window.
///
/// Each of them may be used beside the others. A thread has one context current at most: making one current releases
/// the one of EGL, GLX, WGL or OSMesa that is current on that thread, the application's included. An engine makes that
/// current again (EngineConfig::context.application); who makes contexts current himself does so himself.
enum class ContextPlatform : std::uint8_t {
  /// What the environment variable SIGHTLINE_CONTEXT names (name_of()). Without it kEgl, or on Windows kWgl, and
  /// kOsMesa
  /// where that is absent or gives no context: Context::platform() then says why.
  kAutomatic,
  kEgl,             ///< hardware EGL devices in order, then surfaceless, then software devices
  kEglSurfaceless,  ///< EGL_MESA_platform_surfaceless
  kEglDevice,       ///< EGL_EXT_platform_device: the first device that works, hardware first
  kOsMesa,          ///< Mesa's software rasteriser as a library; needs no driver and no display server
  kWgl,             ///< Windows' own, with a window that is never shown
};

/// "auto", "egl", "egl-surfaceless", "egl-device", "osmesa", "wgl"
SIGHTLINE_API std::string_view name_of(ContextPlatform platform);
/// The platform of that name. The error lists all names.
SIGHTLINE_API core::Expected<ContextPlatform> parse_platform(const std::string& name);

struct ContextOptions {
  ContextPlatform platform = ContextPlatform::kAutomatic;
  int device = -1;               ///< index of the EGL device for kEglDevice; -1 tries all
  bool debug = false;            ///< collect KHR_debug messages; calls become synchronous and slower
  std::string workarounds = {};  ///< "plain-depth=on,…": forces these on or off, see gl/workarounds.h
  // Opened at run time, so a machine without them gets an error value.
  std::string egl_library = "libEGL.so.1";
  std::string osmesa_library = "libOSMesa.so.8";
};

/// What the context offers beyond what GL 4.5 guarantees. Sizes in the units named.
struct Capabilities {
  bool indirect_count = false;          ///< MultiDraw*IndirectCountARB are loaded
  bool shader_draw_parameters = false;  ///< GL_ARB_shader_draw_parameters
  bool robust_access = false;           ///< out-of-range reads are defined
  bool reset_notification = false;      ///< GetGraphicsResetStatus reports a lost context
  bool software = false;  ///< a software rasteriser: GPU work is CPU work, and its timer queries mean nothing
  std::int64_t max_texture_buffer_texels = 0;
  std::int64_t max_storage_block_bytes = 0;
  std::int64_t max_uniform_block_bytes = 0;
  int max_vertex_storage_blocks = 0;  ///< may be 0: vertex stages then need texture buffers
  int max_geometry_output_vertices = 0;
  int max_geometry_output_components = 0;  ///< for all vertices together
  int max_clip_distances = 0;
  int max_texture_size = 0;  ///< pixels, either side of a 2D texture
  int max_viewport_width = 0;
  int max_viewport_height = 0;
  int max_samples = 0;
  int subpixel_bits = 4;  ///< to which a rasteriser rounds vertices, at least
  int max_integer_samples = 0;
  int uniform_offset_alignment = 0;  ///< bytes
  int storage_offset_alignment = 0;  ///< bytes
};

/// Whether the system has a device for drawing that is no software rasteriser. Makes no context, and takes a fraction
/// of a millisecond where the system has no such device at all.
SIGHTLINE_API bool has_gpu();

/// Owns or borrows one GL context with its function table. Move-only; functions() keeps its address when the Context
/// moves. Objects made with the table must be destroyed before the Context and while it is current, unless a share()
/// exists. A thread may use a context only while it is current there. Several contexts in one process are independent.
///
/// An offscreen context has no surface, or with OSMesa one of a single pixel. Without a surface and with framebuffer 0
/// bound, even a draw with rasterizer discard fails with GL_INVALID_FRAMEBUFFER_OPERATION. So bind a gl::Framebuffer
/// first; one without attachments is enough.
class SIGHTLINE_API Context {
 public:
  /// Makes an OpenGL 4.5 core context without a window and makes it current. Fails when the platform or its driver is
  /// absent; the error lists what was tried and what to install.
  static core::Expected<Context> create_offscreen(const ContextOptions& options = {});

  /// Uses the context that is current on this thread (GLFW, Qt, another EGL, OSMesa). This class neither destroys it
  /// nor makes it current, and leaves the application's debug callback in place. The context must outlive the Context.
  static core::Expected<Context> adopt(GetProc get_proc, void* user);

  /// Another handle of this context, for objects that may outlive it. It keeps the function table and capabilities, but
  /// not the context. Once this Context is destroyed, the share is lost(). Objects made with functions() may then be
  /// destroyed later, whichever context is current. They free nothing: the context freed them.
  Context share() const;

  Context(Context&& other) noexcept;
  Context& operator=(Context&& other) noexcept;
  ~Context();

  const Functions& functions() const;
  const Capabilities& capabilities() const;
  const std::string& vendor() const;
  const std::string& renderer() const;
  const std::string& version() const;
  /// How the context was made: "EGL surfaceless", "EGL device 1", "OSMesa", "adopted". Where kAutomatic had to do
  /// without EGL, its error follows in parentheses.
  const std::string& platform() const;

  /// Makes the context current on this thread; nearly free when it already is. Does nothing for an adopted one. Fails
  /// when the context is destroyed or current elsewhere.
  core::Expected<void> make_current() const;
  /// Leaves no context current, so that another thread may take this one. Does nothing for an adopted one.
  void release_current() const;

  /// From now on Program looks for linked programs in that folder and stores them there: see ProgramCache. Empty: no
  /// cache, which is the initial state. The context must be current.
  void cache_programs(const std::filesystem::path& folder);

  /// Tests the driver, and works around what fails from now on; see gl/workarounds.h. Only the first call does
  /// anything. It takes some milliseconds, and none where the folder of cache_programs() has the results of an earlier
  /// one. The context must be current; its state is left changed. Programs made before do not know what is found.
  void test_driver();
  const DriverTest& driver_test() const;
  /// The workarounds that the user has set.
  const WorkaroundSwitches& workaround_switches() const;

  /// True once the driver has reset the context, for example after a hang of the GPU. Its contents are gone, calls do
  /// nothing, and only a new context helps. Also true for a share() whose context is destroyed. Stays true. Asks the
  /// driver without waiting for the GPU; the context must be current. Without Capabilities::reset_notification resets
  /// go unnoticed.
  bool lost() const;

  /// Messages since the last take_errors(), of every severity; empty unless made with ContextOptions::debug.
  const DebugLog& debug_log() const;
  /// Errors since the last call: the debug log's errors and messages of high severity, then what GetError has pending.
  /// Clears the log. The context must be current.
  std::vector<std::string> take_errors();

 private:
  struct State;
  Context(std::shared_ptr<State> state, bool shares);
  void destroy();
  std::shared_ptr<State> state_;
  bool shares_ = false;
};

}  // namespace sightline::gl
