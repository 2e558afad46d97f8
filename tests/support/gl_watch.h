// Counts the calls by which a CPU waits for a GPU.
#pragma once

#include <map>
#include <string>

#include "sightline/gl/functions.h"

namespace sightline::tests {

/// While it lives, stands between a context's table and the driver and counts calls by which a CPU learns what a GPU
/// did: all state queries, and those of results, mappings and fences that wait. One at a time.
struct Watch {
  static inline gl::Functions real;
  static inline std::map<std::string, int> calls;
  static inline bool query_buffer = false, results_ready = false;

  explicit Watch(gl::Functions& watched) : table(watched) {
    real = watched;
    calls.clear();
    query_buffer = results_ready = false;
#define COUNT(Name) replace<&gl::Functions::Name>(#Name)
    COUNT(Finish);
    COUNT(GetIntegerv);
    COUNT(GetIntegeri_v);
    COUNT(GetInteger64v);
    COUNT(GetInteger64i_v);
    COUNT(GetFloatv);
    COUNT(GetBooleanv);
    COUNT(GetError);
    COUNT(IsEnabled);
    COUNT(GetNamedBufferSubData);
    COUNT(GetTextureImage);
    COUNT(ReadPixels);
    COUNT(GetQueryiv);
    COUNT(GetQueryObjectiv);
    COUNT(GetSynciv);
    COUNT(GetUniformLocation);
    COUNT(GetProgramiv);
    COUNT(GetShaderiv);
#undef COUNT
    table.MapNamedBufferRange = [](GLuint buffer, GLintptr offset, GLsizeiptr size, GLbitfield access) {
      if (access & GL_MAP_READ_BIT) ++calls["MapNamedBufferRange"];
      return real.MapNamedBufferRange(buffer, offset, size, access);
    };
    table.ClientWaitSync = [](GLsync sync, GLbitfield flags, GLuint64 timeout) {
      if (timeout > 0) ++calls["ClientWaitSync"];
      return real.ClientWaitSync(sync, flags, timeout);
    };
    table.BindBuffer = [](GLenum point, GLuint buffer) {
      if (point == GL_QUERY_BUFFER) query_buffer = buffer != 0;
      real.BindBuffer(point, buffer);
    };
    table.GetQueryObjectuiv = [](GLuint query, GLenum name, GLuint* value) {
      if (!query_buffer && name == GL_QUERY_RESULT) ++calls["GetQueryObjectuiv"];
      real.GetQueryObjectuiv(query, name, value);
      if (!query_buffer && name == GL_QUERY_RESULT_AVAILABLE) results_ready = *value != 0;
    };
    table.GetQueryObjectui64v = [](GLuint query, GLenum name, GLuint64* value) {
      if (!query_buffer && name == GL_QUERY_RESULT && !results_ready) ++calls["GetQueryObjectui64v"];
      real.GetQueryObjectui64v(query, name, value);
    };
  }
  ~Watch() {
    table = real;
  }

  template <auto Member>
  void replace(const char* name) {
    table.*Member = counted<Member>(table.*Member, name);
  }
  template <auto Member, class Result, class... Arguments>
  static auto counted(Result (*)(Arguments...), const char* name) -> Result (*)(Arguments...) {
    static const char* called = name;
    return [](Arguments... arguments) -> Result {
      ++calls[called];
      return (real.*Member)(arguments...);
    };
  }

  gl::Functions& table;
};

}  // namespace sightline::tests
