// Resets state that an application may have left in a context and that affects the image.
#pragma once

#include <span>

#include "sightline/gl/functions.h"

namespace sightline::gl {

/// Texture units that shaders of this library may use.
constexpr int kTextureUnits = 6;

/// Resets state of OpenGL 4.5 core to its initial value where it decides which pixels of a framebuffer object draws and
/// clears reach, or what they write there, or which vertices draws have. Also turns dithering off, and takes samplers
/// from the units 0 to kTextureUnits - 1. A draw then sets only what it needs otherwise, its
/// viewport, and its bindings. Queries no state, so it never waits.
///
/// GL offers no way to query or reset some state, which must not be active: conditional rendering, transform feedback
/// that is not paused, a query of GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN or, for stream 1, GL_PRIMITIVES_GENERATED.
/// State of extensions is not reset.
void reset_pipeline_state(const Functions& gl);

/// The capabilities that reset_pipeline_state() turns off.
std::span<const GLenum> pipeline_capabilities();

/// Leaves one texture target of a unit without texture. (glBindTextureUnit would do so with all targets, among them
/// those of an application.) Changes which unit is active.
void unbind_texture(const Functions& gl, GLuint unit, GLenum target);

}  // namespace sightline::gl
