// Makes OpenGL fail at chosen calls: out of memory, shaders that do not compile, programs that do not link,
// framebuffers that are not complete, waits that fail, a context that is lost.
#pragma once

#include <limits>
#include <string_view>

#include "sightline/gl/context.h"
#include "sightline/gl/functions.h"

namespace sightline::tests {
namespace faulty_gl {

/// How a call fails. It then has no effect, and returns 0 or what is named here.
enum class Fault {
  kNever,
  kMemory,  ///< GL_OUT_OF_MEMORY
  kSilent,  ///< no error: there is a status to ask for
  kWait,    ///< GL_OUT_OF_MEMORY and GL_WAIT_FAILED
  kFree,    ///< never, and has its effect in a lost context, too
};
constexpr Fault fault_of(std::string_view name) {
  constexpr std::string_view kMemory[] = {
      "CreateBuffers",
      "CreateVertexArrays",
      "CreateTextures",
      "CreateSamplers",
      "CreateFramebuffers",
      "CreateRenderbuffers",
      "CreateShader",
      "CreateProgram",
      "CreateProgramPipelines",
      "CreateQueries",
      "CreateTransformFeedbacks",
      "GenQueries",
      "NamedBufferStorage",
      "BufferData",
      "TextureBuffer",
      "TextureStorage2D",
      "TextureStorage2DMultisample",
      "NamedRenderbufferStorage",
      "MapNamedBufferRange",
      "FenceSync",
      "GetTextureImage",
  };
  constexpr std::string_view kSilent[] = {"CompileShader", "LinkProgram", "ProgramBinary",
                                          "CheckNamedFramebufferStatus"};
  for (const std::string_view one : kMemory)
    if (name == one) return Fault::kMemory;
  for (const std::string_view one : kSilent)
    if (name == one) return Fault::kSilent;
  if (name == "ClientWaitSync") return Fault::kWait;
  return name.starts_with("Delete") ? Fault::kFree : Fault::kNever;
}

constexpr int kForever = std::numeric_limits<int>::max();

/// The state of all calls since a test began to count.
struct State {
  int calls = 0, fallible = 0;
  int first = 0, count = 0;  // of those that may fail, the ones that do
  int lost_at = kForever;
  GLenum error = GL_NO_ERROR;
  std::string_view failed;
};

}  // namespace faulty_gl

/// While it lives, stands between a context's table and the driver. It counts all calls, and among them those that may
/// fail because something cannot be had. One at a time.
class FaultyGl {
 public:
  static constexpr int kForever = faulty_gl::kForever;

  explicit FaultyGl(const gl::Context& context)
      : table_(const_cast<gl::Functions&>(context.functions())),
        capabilities_(const_cast<gl::Capabilities&>(context.capabilities())) {
    real_ = table_;
    state_ = faulty_gl::State();
    notifies_ = capabilities_.reset_notification;
#define SIGHTLINE_GL_FUNCTION(name, type) wrap<&gl::Functions::name, faulty_gl::fault_of(#name)>(#name);
#define SIGHTLINE_GL_EXTENSION(name, type, extension) wrap<&gl::Functions::name, faulty_gl::fault_of(#name)>(#name);
#include "sightline/gl/function_table.inc"
    table_.GetError = get_error;
    table_.GetGraphicsResetStatus = reset_status;
  }
  FaultyGl(const FaultyGl&) = delete;
  FaultyGl& operator=(const FaultyGl&) = delete;
  ~FaultyGl() {
#define SIGHTLINE_GL_FUNCTION(name, type) table_.name = real_.name;
#define SIGHTLINE_GL_EXTENSION(name, type, extension) table_.name = real_.name;
#include "sightline/gl/function_table.inc"
    capabilities_.reset_notification = notifies_;
  }

  /// Counts from 0 again, and nothing fails.
  void reset() {
    state_ = faulty_gl::State();
  }
  /// The calls that may fail with these numbers do, counted from 0 since reset().
  void fail(int first, int count = 1) {
    state_.first = first, state_.count = count;
  }
  /// What fails no more; the counts go on.
  void stop() {
    state_.count = 0;
  }
  /// The context is lost at the call with this number, counted from 0 since reset(). From then on calls have no effect,
  /// but for those that free objects, so that a long run of losses does not fill the memory.
  void lose(int call) {
    state_.lost_at = call;
    capabilities_.reset_notification = true;
  }

  int calls() const {
    return state_.calls;
  }
  int fallible() const {
    return state_.fallible;
  }  ///< of these calls, those that may fail
  bool failed() const {
    return !state_.failed.empty();
  }  ///< any has failed, or the context is lost
  std::string_view failed_first() const {
    return state_.failed;
  }  ///< the entry point
  bool lost() const {
    return is_lost();
  }

 private:
  using Fault = faulty_gl::Fault;

  template <auto Member, Fault kFault>
  void wrap(const char* name) {
    if (table_.*Member) table_.*Member = wrapped<Member, kFault>(table_.*Member, name);
  }
  template <auto Member, Fault kFault, class Result, class... Arguments>
  static auto wrapped(Result (*)(Arguments...), const char* name) -> Result (*)(Arguments...) {
    static const char* const entry = name;
    return [](Arguments... arguments) -> Result {
      if (kFault != Fault::kFree && (loses(entry) || (kFault != Fault::kNever && fails(entry)))) {
        if (is_lost() || kFault != Fault::kSilent) state_.error = is_lost() ? GL_CONTEXT_LOST : GL_OUT_OF_MEMORY;
        return refused<kFault, Result>();
      }
      return (real_.*Member)(arguments...);
    };
  }
  template <Fault kFault, class Result>
  static Result refused() {
    if constexpr (kFault == Fault::kWait) return GL_WAIT_FAILED;
    return Result();
  }

  static bool is_lost() {
    return state_.calls > state_.lost_at;
  }
  static bool loses(const char* entry) {
    ++state_.calls;
    if (is_lost() && state_.failed.empty()) state_.failed = entry;
    return is_lost();
  }
  static bool fails(const char* entry) {
    const int number = state_.fallible++;
    const bool chosen = number >= state_.first && number - state_.first < state_.count;
    if (chosen && state_.failed.empty()) state_.failed = entry;
    return chosen;
  }
  static GLenum get_error() {
    const GLenum error = state_.error;
    state_.error = GL_NO_ERROR;
    return error != GL_NO_ERROR ? error : is_lost() ? GLenum(GL_NO_ERROR) : real_.GetError();
  }
  static GLenum reset_status() {
    return is_lost() ? GL_UNKNOWN_CONTEXT_RESET : GL_NO_ERROR;
  }

  static inline gl::Functions real_;
  static inline faulty_gl::State state_;

  gl::Functions& table_;
  gl::Capabilities& capabilities_;
  bool notifies_ = false;
};

}  // namespace sightline::tests
