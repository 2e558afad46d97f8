// Counts the GL calls of a program: a measure of the CPU's work that is the same on every machine.
#pragma once

#include <cstdint>

#include "sightline/gl/context.h"
#include "sightline/gl/functions.h"

namespace sightline::bench {

/// Counts every call through a context's table while it lives. Only one may exist at a time.
class GlCallCount {
 public:
  explicit GlCallCount(const gl::Context& context) : table_(const_cast<gl::Functions&>(context.functions())) {
    real_ = table_;
    calls_ = 0;
#define SIGHTLINE_GL_FUNCTION(Name, type) \
  if (real_.Name) table_.Name = counted<&gl::Functions::Name>(real_.Name);
#define SIGHTLINE_GL_EXTENSION(Name, type, extension) SIGHTLINE_GL_FUNCTION(Name, type)
#include "sightline/gl/function_table.inc"
  }
  ~GlCallCount() {
    table_ = real_;
  }
  GlCallCount(const GlCallCount&) = delete;
  GlCallCount& operator=(const GlCallCount&) = delete;

  std::uint64_t calls() const {
    return calls_;
  }

 private:
  template <auto Member, class Result, class... Arguments>
  static auto counted(Result (*)(Arguments...)) -> Result (*)(Arguments...) {
    return [](Arguments... arguments) -> Result {
      ++calls_;
      return (real_.*Member)(arguments...);
    };
  }

  static inline gl::Functions real_;
  static inline std::uint64_t calls_ = 0;
  gl::Functions& table_;
};

}  // namespace sightline::bench
