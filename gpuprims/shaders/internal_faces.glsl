// Which faces of a solid are not shown.
#include "payload.glsl"
#include "search.glsl"

// Bits of the faces that an item does not show: its open ends, and the level cuts that replace them.
uint internal_faces(uint material_word) {
  uint bottom = (material_word & kBottomOpen) != 0u ? 1u << kBottom | 1u << kBottomLevel : 0u;
  uint top = (material_word & kTopOpen) != 0u ? 1u << kTop | 1u << kTopLevel : 0u;
  return bottom | top;
}
