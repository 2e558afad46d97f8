// Draws that compute each pixel of a viewport from textures: one triangle over all of it.
#pragma once

#include <initializer_list>
#include <span>

#include "sightline/gl/external_target.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/vertex_array.h"

namespace sightline::render {

/// What such draws have in common. A draw is begin(), what it needs beyond that, and draw(). All calls set GL state and
/// leave it set.
class PixelPass {
 public:
  /// Uniforms that all fragment shaders for begin() have.
  enum Uniform : GLint { kCorner = 0, kLinearColour = 2 };

  explicit PixelPass(const gl::Functions& gl) : gl_(&gl) {}

  /// `made`, which is made first if it is empty: for textures of so many samples. Fails with the driver's log.
  core::Expected<const gl::Program*> program(gl::Program& made, const char* fragment, int samples,
                                             std::initializer_list<const char*> defines = {}) const;

  /// Makes draws write fragment output 0 to a part of a framebuffer, which is bound, without depth test and blending.
  void begin(const gl::Program& program, const gl::ExternalTarget& to) const;
  /// From begin() on: draws only what is nearer than what is there.
  void test_depth(const gl::ExternalTarget& to) const;
  /// From begin() on: blends colours that are multiplied by their alpha.
  void blend() const;

  /// Draws with the textures at units 0, 1 …, and leaves these units empty.
  void draw(const gl::Program& program, std::span<const GLuint> textures, GLenum texture_target) const;

 private:
  const gl::Functions* gl_;
  mutable gl::VertexArray no_attributes_;  // made with the first program
};

}  // namespace sightline::render
