#include "sightline/gl/context.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "sightline/gl/functions.h"
#include "sightline/gl/internal/driver_test.h"
#include "sightline/gl/internal/platform_context.h"
#include "sightline/gl/internal/program_cache.h"

namespace sightline::gl {

struct Context::State {
  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void set_switches(const WorkaroundSwitches& chosen);

  std::unique_ptr<PlatformContext> own;  // null when adopted, and once destroyed
  std::string platform;
  Functions gl;
  Capabilities capabilities;
  std::optional<ProgramCache> program_cache;
  WorkaroundSwitches switches;
  DriverTest driver_test;
  DebugLog log;
  bool lost = false, destroyed = false;
  std::string vendor;
  std::string renderer;
  std::string version;
};

namespace {

std::string get_string(const Functions& gl, GLenum name) {
  const auto* text = reinterpret_cast<const char*>(gl.GetString(name));
  return text ? text : "";
}

GLint get_int(const Functions& gl, GLenum name) {
  GLint value = 0;
  gl.GetIntegerv(name, &value);
  return value;
}

GLint64 get_int64(const Functions& gl, GLenum name) {
  GLint64 value = 0;
  gl.GetInteger64v(name, &value);
  return value;
}

bool names_software(const std::string& renderer) {
  for (const char* name : {"llvmpipe", "softpipe", "swrast", "SWR", "SwiftShader", "Software"}) {
    if (renderer.find(name) != std::string::npos) return true;
  }
  return false;
}

bool on_lavapipe(const std::string& renderer) {
  return renderer.starts_with("zink (llvmpipe");
}

bool lists(const Functions& gl, const char* extension) {
  const std::vector<std::string> extensions = list_extensions(gl);
  return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

Capabilities query_capabilities(const Functions& gl) {
  Capabilities caps;
  caps.indirect_count = gl.MultiDrawArraysIndirectCountARB && gl.MultiDrawElementsIndirectCountARB;
  caps.shader_draw_parameters = lists(gl, "GL_ARB_shader_draw_parameters");
  caps.robust_access = (get_int(gl, GL_CONTEXT_FLAGS) & GL_CONTEXT_FLAG_ROBUST_ACCESS_BIT) != 0;
  caps.reset_notification = get_int(gl, GL_RESET_NOTIFICATION_STRATEGY) == GL_LOSE_CONTEXT_ON_RESET;
  caps.software = names_software(get_string(gl, GL_RENDERER));
  caps.max_texture_buffer_texels = get_int64(gl, GL_MAX_TEXTURE_BUFFER_SIZE);
  caps.max_storage_block_bytes = get_int64(gl, GL_MAX_SHADER_STORAGE_BLOCK_SIZE);
  caps.max_uniform_block_bytes = get_int64(gl, GL_MAX_UNIFORM_BLOCK_SIZE);
  caps.max_vertex_storage_blocks = get_int(gl, GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS);
  caps.max_geometry_output_vertices = get_int(gl, GL_MAX_GEOMETRY_OUTPUT_VERTICES);
  caps.max_geometry_output_components = get_int(gl, GL_MAX_GEOMETRY_TOTAL_OUTPUT_COMPONENTS);
  caps.max_clip_distances = get_int(gl, GL_MAX_CLIP_DISTANCES);
  caps.max_texture_size = get_int(gl, GL_MAX_TEXTURE_SIZE);
  GLint viewport[2] = {0, 0};
  gl.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
  caps.max_viewport_width = viewport[0];
  caps.max_viewport_height = viewport[1];
  caps.subpixel_bits = std::max(caps.subpixel_bits, get_int(gl, GL_SUBPIXEL_BITS));
  caps.max_samples = get_int(gl, GL_MAX_SAMPLES);
  caps.max_integer_samples = get_int(gl, GL_MAX_INTEGER_SAMPLES);
  caps.uniform_offset_alignment = get_int(gl, GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT);
  caps.storage_offset_alignment = get_int(gl, GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT);
  return caps;
}

/// Follows workarounds that change what the context offers.
void follow_workarounds(Functions& gl, Capabilities& caps) {
  if (gl.workarounds[Workaround::kNoIndirectCount]) {
    gl.MultiDrawArraysIndirectCountARB = nullptr;
    gl.MultiDrawElementsIndirectCountARB = nullptr;
    caps.indirect_count = false;
  }
  if (gl.workarounds[Workaround::kFourSamples]) {
    caps.max_samples = std::min(caps.max_samples, 4);
    caps.max_integer_samples = std::min(caps.max_integer_samples, 4);
  }
  if (gl.workarounds[Workaround::kSmallBlocks])
    caps.max_storage_block_bytes = std::min(caps.max_storage_block_bytes, std::int64_t(1) << 27);
}

// Programs and results of another version of the test are not recalled.
constexpr std::string_view kDriverTestKey = "driver test 2";

/// False when a lack of memory, say, kept a check from running that every context allows.
bool ran(const DriverTest& test) {
  for (const DriverCheck check : {DriverCheck::kClipControl, DriverCheck::kConservativeDepth, DriverCheck::kBaseVertex,
                                  DriverCheck::kFeedback, DriverCheck::kPreciseSums})
    if (test[check] == CheckResult::kNotRun) return false;
  return true;
}

std::string to_text(const DriverTest& test) {
  std::string text;
  for (const CheckResult result : test.results) text += char('0' + int(result));
  return text;
}

bool from_text(std::string_view text, DriverTest& test) {
  if (text.size() != test.results.size()) return false;
  for (std::size_t i = 0; i < text.size(); ++i) test.results[i] = CheckResult(std::clamp(text[i] - '0', 0, 2));
  return test.remembered = true;
}

DebugSeverity severity_of(GLenum severity) {
  switch (severity) {
    case GL_DEBUG_SEVERITY_HIGH:
      return DebugSeverity::kHigh;
    case GL_DEBUG_SEVERITY_MEDIUM:
      return DebugSeverity::kMedium;
    case GL_DEBUG_SEVERITY_LOW:
      return DebugSeverity::kLow;
    default:
      return DebugSeverity::kNotification;
  }
}

void APIENTRY on_message(GLenum, GLenum type, GLuint, GLenum severity, GLsizei length, const GLchar* text,
                         const void* log) {
  DebugMessage message;
  message.severity = severity_of(severity);
  message.is_error = type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR;
  message.text = length >= 0 ? std::string(text, static_cast<std::size_t>(length)) : std::string(text);
  while (!message.text.empty() && message.text.back() == '\n') message.text.pop_back();
  // GL returns the pointer as const; it was passed as a mutable log.
  static_cast<DebugLog*>(const_cast<void*>(log))->add(std::move(message));
}

void collect_debug_output(const Functions& gl, DebugLog& log) {
  gl.Enable(GL_DEBUG_OUTPUT);
  gl.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  gl.DebugMessageCallback(&on_message, &log);
  gl.DebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, nullptr, GL_TRUE);
  // Such as "This buffer will live in video memory": thousands of messages on some drivers.
  gl.DebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DEBUG_SEVERITY_NOTIFICATION, 0, nullptr, GL_FALSE);
}

constexpr std::array<std::string_view, 6> kPlatformNames = {"auto",       "egl",    "egl-surfaceless",
                                                            "egl-device", "osmesa", "wgl"};

/// `why`: why the platform is not the first choice, where it is not.
core::Expected<std::unique_ptr<PlatformContext>> create_platform_context(ContextOptions options, std::string& why) {
  if (options.platform == ContextPlatform::kAutomatic) {
    const char* name = std::getenv("SIGHTLINE_CONTEXT");
    const auto named = parse_platform(name && *name ? name : "auto");
    if (!named) return core::fail("SIGHTLINE_CONTEXT: " + named.error().message);
    options.platform = *named;
  }
  if (options.platform == ContextPlatform::kOsMesa) return create_osmesa_context(options);
  auto own = create_system_context(options);
  if (own || options.platform != ContextPlatform::kAutomatic) return own;
  auto osmesa = create_osmesa_context(options);
  if (!osmesa) return core::fail(own.error().message + "; " + osmesa.error().message);
  why = own.error().message;
  return osmesa;
}

}  // namespace

std::string_view name_of(ContextPlatform platform) {
  return kPlatformNames[std::size_t(platform)];
}

core::Expected<ContextPlatform> parse_platform(const std::string& name) {
  const auto found = std::find(kPlatformNames.begin(), kPlatformNames.end(), name);
  if (found != kPlatformNames.end()) return ContextPlatform(found - kPlatformNames.begin());
  return core::fail(fmt::format("expected one of {}, found \"{}\"", fmt::join(kPlatformNames, ", "), name));
}

void Context::State::set_switches(const WorkaroundSwitches& chosen) {
  switches = chosen;
  gl.workarounds = choose_workarounds(driver_test, switches);
  follow_workarounds(gl, capabilities);
}

Context::Context(std::shared_ptr<State> state, bool shares) : state_(std::move(state)), shares_(shares) {}
Context::Context(Context&& other) noexcept = default;
Context& Context::operator=(Context&& other) noexcept {
  if (this == &other) return *this;
  destroy();
  state_ = std::move(other.state_);
  shares_ = other.shares_;
  return *this;
}
Context::~Context() {
  destroy();
}

void Context::destroy() {
  if (!state_ || shares_) return;
  stop_freeing(state_->gl);
  state_->lost = state_->destroyed = true;
  state_->own.reset();
}

Context Context::share() const {
  return {state_, true};
}

core::Expected<Context> Context::create_offscreen(const ContextOptions& options) {
  std::string why;
  auto own = create_platform_context(options, why);
  if (!own) return tl::unexpected(own.error());
  const auto get_proc = [](const char* name, void* platform) {
    return static_cast<const PlatformContext*>(platform)->get_proc(name);
  };
  const auto switches = WorkaroundSwitches::parse(options.workarounds);
  if (!switches) return tl::unexpected(switches.error());
  auto context = adopt(get_proc, own->get());
  if (!context) return core::fail((*own)->name() + ": " + context.error().message);
  context->state_->platform = (*own)->name();
  if (!why.empty()) context->state_->platform += " (" + why + ")";
  context->state_->own = std::move(*own);
  context->state_->set_switches(switches->with(context->state_->switches));
  const Functions& gl = context->state_->gl;
  // As many as the driver likes. Some drivers have none until they are asked. An application's context is its own.
  if (gl.MaxShaderCompilerThreadsKHR) gl.MaxShaderCompilerThreadsKHR(0xffffffffu);
  if (options.debug) collect_debug_output(context->state_->gl, context->state_->log);
  return context;
}

core::Expected<Context> Context::adopt(GetProc get_proc, void* user) {
  const char* variable = std::getenv("SIGHTLINE_GL_WORKAROUNDS");
  const auto switches = WorkaroundSwitches::parse(variable ? variable : "");
  if (!switches) return core::fail("SIGHTLINE_GL_WORKAROUNDS: " + switches.error().message);
  auto functions = load_functions(get_proc, user);
  if (!functions) return tl::unexpected(functions.error());
  auto state = std::make_unique<State>();
  state->platform = "adopted";
  state->gl = *functions;
  state->vendor = get_string(state->gl, GL_VENDOR);
  state->renderer = get_string(state->gl, GL_RENDERER);
  state->version = get_string(state->gl, GL_VERSION);
  if (on_lavapipe(state->renderer)) {
    state->gl.stale_indirect_draws = true;
    state->gl.MultiDrawArraysIndirectCountARB = nullptr;
    state->gl.MultiDrawElementsIndirectCountARB = nullptr;
  }
  state->capabilities = query_capabilities(state->gl);
  state->gl.pinned_memory = state->capabilities.software && lists(state->gl, "GL_AMD_pinned_memory");
  state->set_switches(*switches);
  return Context(std::move(state), false);
}

const Functions& Context::functions() const {
  return state_->gl;
}
const Capabilities& Context::capabilities() const {
  return state_->capabilities;
}
const std::string& Context::vendor() const {
  return state_->vendor;
}
const std::string& Context::renderer() const {
  return state_->renderer;
}
const std::string& Context::version() const {
  return state_->version;
}
const std::string& Context::platform() const {
  return state_->platform;
}
const DebugLog& Context::debug_log() const {
  return state_->log;
}

core::Expected<void> Context::make_current() const {
  if (state_->destroyed) return core::fail(state_->platform + ": the GL context is destroyed");
  return state_->own ? state_->own->make_current() : core::Expected<void>();
}

void Context::release_current() const {
  if (state_->own) state_->own->release_current();
}

void Context::cache_programs(const std::filesystem::path& folder) {
  state_->program_cache.reset();
  if (!folder.empty()) state_->program_cache.emplace(state_->gl, folder);
  state_->gl.program_cache = state_->program_cache ? &*state_->program_cache : nullptr;
}

void Context::test_driver() {
  DriverTest& test = state_->driver_test;
  if (test.ms > 0.0 || test.remembered) return;
  const ProgramCache* cache = state_->gl.program_cache;
  const auto recalled = cache ? cache->recall(kDriverTestKey) : std::nullopt;
  if (!recalled || !from_text(*recalled, test)) {
    test = run_driver_test(state_->gl, state_->capabilities);
    if (cache && ran(test)) cache->remember(kDriverTestKey, to_text(test));
  }
  state_->gl.workarounds = choose_workarounds(test, state_->switches);
  follow_workarounds(state_->gl, state_->capabilities);
}

const DriverTest& Context::driver_test() const {
  return state_->driver_test;
}
const WorkaroundSwitches& Context::workaround_switches() const {
  return state_->switches;
}

bool Context::lost() const {
  // A driver reports a reset only while it lasts.
  if (!state_->lost && state_->capabilities.reset_notification)
    state_->lost = state_->gl.GetGraphicsResetStatus() != GL_NO_ERROR;
  return state_->lost;
}

std::vector<std::string> Context::take_errors() {
  std::vector<std::string> errors;
  DebugLog& log = state_->log;
  for (const DebugMessage& message : log.messages()) {
    if (message.is_error || message.severity == DebugSeverity::kHigh) errors.push_back(message.text);
  }
  if (log.errors() > errors.size()) {
    errors.push_back(fmt::format("{} further GL errors were not kept", log.errors() - errors.size()));
  }
  log.clear();
  if (const GLenum error = check_error(state_->gl); error != GL_NO_ERROR) {
    errors.push_back("GetError: " + error_name(error));
  }
  return errors;
}

}  // namespace sightline::gl
