// Vertex array objects: the core profile draws nothing without one, not even from gl_VertexID alone.
#pragma once

#include "sightline/gl/functions.h"
#include "sightline/gl/handle.h"

namespace sightline::gl {

namespace detail {
inline void delete_vertex_array(const Functions& gl, GLuint name) {
  gl.DeleteVertexArrays(1, &name);
}
}  // namespace detail

/// Owns a vertex array; attributes and bindings are set through the table's VertexArray… functions. Move-only.
class VertexArray {
 public:
  VertexArray() = default;
  explicit VertexArray(const Functions& gl) : handle_(gl, make(gl)) {}

  GLuint id() const { return handle_.name(); }
  void bind() const { handle_.gl().BindVertexArray(id()); }

 private:
  static GLuint make(const Functions& gl) {
    GLuint name = 0;
    gl.CreateVertexArrays(1, &name);
    return name;
  }
  Handle<detail::delete_vertex_array> handle_;
};

}  // namespace sightline::gl
