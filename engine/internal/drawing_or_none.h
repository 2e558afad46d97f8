// Includes class Drawing or its stand-in. The only place in engine that knows whether this build has GL.
#pragma once

#if SIGHTLINE_HAS_GL
#include "sightline/engine/internal/drawing.h"
#else
#include "sightline/engine/internal/no_drawing.h"
#endif
