// Counts the GL objects that are made and freed.
#pragma once

#include <map>
#include <string>

#include "sightline/gl/functions.h"

namespace sightline::tests {

/// While it lives, stands between a context's table and the driver and counts objects by kind. One at a time. Objects
/// made before it must not be freed while it lives.
class CountedObjects {
 public:
  explicit CountedObjects(gl::Functions& counted) : table_(counted) {
    real_ = counted;
    made_.clear();
    left_.clear();
#define COUNT_PLURAL(kind)                              \
  counted.Create##kind = [](GLsizei n, GLuint* names) { \
    made_[#kind] += n, left_[#kind] += n;               \
    real_.Create##kind(n, names);                       \
  };                                                    \
  COUNT_DELETES(kind)
#define COUNT_TARGETED(kind)                                           \
  counted.Create##kind = [](GLenum target, GLsizei n, GLuint* names) { \
    made_[#kind] += n, left_[#kind] += n;                              \
    real_.Create##kind(target, n, names);                              \
  };                                                                   \
  COUNT_DELETES(kind)
#define COUNT_DELETES(kind)                                        \
  counted.Delete##kind = [](GLsizei n, const GLuint* names) {      \
    for (GLsizei i = 0; i < n; ++i) left_[#kind] -= names[i] != 0; \
    real_.Delete##kind(n, names);                                  \
  };
    COUNT_PLURAL(Buffers)
    COUNT_PLURAL(VertexArrays)
    COUNT_PLURAL(Framebuffers)
    COUNT_PLURAL(Renderbuffers)
    COUNT_PLURAL(Samplers)
    COUNT_PLURAL(ProgramPipelines)
    COUNT_PLURAL(TransformFeedbacks)
    COUNT_TARGETED(Textures)
    COUNT_TARGETED(Queries)
#undef COUNT_PLURAL
#undef COUNT_TARGETED
#undef COUNT_DELETES
    counted.CreateProgram = [] { return ++made_["Program"], ++left_["Program"], real_.CreateProgram(); };
    counted.DeleteProgram = [](GLuint name) { left_["Program"] -= name != 0, real_.DeleteProgram(name); };
    counted.CreateShader = [](GLenum stage) { return ++made_["Shader"], ++left_["Shader"], real_.CreateShader(stage); };
    counted.DeleteShader = [](GLuint name) { left_["Shader"] -= name != 0, real_.DeleteShader(name); };
    counted.FenceSync = [](GLenum what, GLbitfield flags) {
      return ++made_["Sync"], ++left_["Sync"], real_.FenceSync(what, flags);
    };
    counted.DeleteSync = [](GLsync sync) { left_["Sync"] -= sync != nullptr, real_.DeleteSync(sync); };
  }
  CountedObjects(const CountedObjects&) = delete;
  CountedObjects& operator=(const CountedObjects&) = delete;
  ~CountedObjects() {
    table_ = real_;
  }

  static int made() {
    return sum(made_);
  }
  static int left() {
    return sum(left_);
  }
  static std::string what_is_left() {
    std::string text;
    for (const auto& [kind, count] : left_)
      if (count != 0) text += std::to_string(count) + " " + kind + " ";
    return text;
  }

 private:
  static int sum(const std::map<std::string, int>& counts) {
    int all = 0;
    for (const auto& [kind, count] : counts) all += count;
    return all;
  }
  static inline gl::Functions real_;
  static inline std::map<std::string, int> made_, left_;
  gl::Functions& table_;
};

}  // namespace sightline::tests
