// The one place in engine that knows whether this build has GL: class Drawing, or what stands in for it.
#pragma once

#if SIGHTLINE_HAS_GL
#include "sightline/engine/drawing.h"
#else
#include "sightline/engine/no_drawing.h"
#endif
