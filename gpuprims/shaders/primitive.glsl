// The primitive that a program is for: one of these defines. What several share comes first: a file is included once, where it is first
// named, be that in a branch that is not taken.
#include "payload.glsl"
#include "arithmetic.glsl"
#include "search.glsl"
#include "cylinder_span.glsl"
#include "wedge.glsl"

// Bits of the faces that an item does not show: its ends, and what stands in for them.
uint hidden_faces(uint material_word) {
  uint bottom = (material_word & kBottomOpen) != 0u ? 1u << kBottom | 1u << kBottomLevel : 0u;
  uint top = (material_word & kTopOpen) != 0u ? 1u << kTop | 1u << kTopLevel : 0u;
  return bottom | top;
}

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
