// The one place in engine that knows whether this build has GL: class Drawing, or what stands in for it.
#pragma once

#if SIGHTLINE_HAS_GL
#include "sightline/engine/internal/drawing.h"
#else
#include "sightline/engine/internal/no_drawing.h"
#endif
