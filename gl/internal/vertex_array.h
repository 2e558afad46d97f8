// Vertex array objects: the core profile draws nothing without one, not even from gl_VertexID alone.
#pragma once

#include "sightline/gl/functions.h"
#include "sightline/gl/internal/handle.h"

namespace sightline::gl {

/// Owns a vertex array; attributes and bindings are set through the table's VertexArray… functions. Move-only.
class VertexArray {
 public:
  VertexArray() = default;
  explicit VertexArray(const Functions& gl) : handle_(gl, create_name<&Functions::CreateVertexArrays>(gl)) {}

  GLuint id() const { return handle_.name(); }
  void bind() const { handle_.gl().BindVertexArray(id()); }

 private:
  Handle<&Functions::DeleteVertexArrays> handle_;
};

}  // namespace sightline::gl
