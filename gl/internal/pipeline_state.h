// State that an application may have left in a context, and that comes between a draw and its picture.
#pragma once

#include "sightline/gl/functions.h"

namespace sightline::gl {

/// Gives state of OpenGL 4.5 core its initial value, as far as it decides which pixels of a framebuffer object draws
/// and clears reach and what they leave there, and turns dithering off. A draw then sets what it wants otherwise, its
/// viewport, and what it binds. Asks nothing, and so waits for nothing.
///
/// What GL neither tells nor resets must not be active: conditional rendering, transform feedback that is not paused,
/// a query of GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN. Nor does it know state of extensions.
void reset_pipeline_state(const Functions& gl);

}  // namespace sightline::gl
