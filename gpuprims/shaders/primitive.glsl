// Includes the code of one primitive, which one of these defines selects. Its shape_reach() bounds the absolute
// coordinates of its points. Shared files come first: each file is included once, where it is first named, even if that
// is in a branch that is not taken.
#include "internal_faces.glsl"
#include "payload.glsl"
#include "arithmetic.glsl"
#include "search.glsl"
#include "cylinder_span.glsl"
#include "wedge.glsl"

#if defined(CYLINDER)
#include "cylinder.glsl"
#elif defined(SNOUT)
#include "snout.glsl"
#elif defined(CIRCULAR_TORUS)
#include "circular_torus.glsl"
#elif defined(SPHERE_CAP)
#include "sphere_cap.glsl"
#elif defined(RECTANGULAR_TORUS)
#include "rectangular_torus.glsl"
#elif defined(PYRAMID)
#include "pyramid.glsl"
#elif defined(BOX)
#include "box.glsl"
#endif
