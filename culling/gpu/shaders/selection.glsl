// Which items of the view volume are written. C++ side: Selection in gpu_pass.h.

#ifdef SAMPLED

#include "screen_box.glsl"

layout(location = 1) uniform bool all_selected;  // of lines, whose rule is another

// Items that may cover a sample of the picture.
bool selected(vec3 low, vec3 high) {
  return all_selected || covers_sample(project_box(low, high));
}

#else

bool selected(vec3 low, vec3 high) {
  return true;
}

#endif
