// Which items of the view volume are written. C++ side: Selection in gpu_pass.h.

#ifdef FOR_PICTURE
#include "screen_box.glsl"

layout(location = 1) uniform bool exempt;  // of lines, whose rules are others: the first pass of a frame draws all
#endif

#if defined(OPEN_BEFORE) || defined(OPEN_NOW)
#include "occlusion_test.glsl"
#endif

#if defined(SAMPLED)

bool cluster_selected(vec3 low, vec3 high) {
  return true;
}

bool selected(uint record, vec3 low, vec3 high) {
  return exempt || covers_sample(project_box(low, high));
}

#elif defined(OPEN_BEFORE)

bool cluster_selected(vec3 low, vec3 high) {
  return true;
}

bool selected(uint record, vec3 low, vec3 high) {
  return exempt || (open_in_frame_before(record) && covers_sample(project_box(low, high)));
}

#elif defined(OPEN_NOW)

bool cluster_selected(vec3 low, vec3 high) {
  return !exempt && !hidden(project_box(low, high));
}

// What the first pass has drawn is tested, too, but not drawn again.
bool selected(uint record, vec3 low, vec3 high) {
  if (hidden(project_box(low, high))) return false;
  bool drawn = open_in_frame_before(record);
  open_frames[record] = occlusion.this_frame;
  return !drawn;
}

#else

bool cluster_selected(vec3 low, vec3 high) {
  return true;
}

bool selected(uint record, vec3 low, vec3 high) {
  return true;
}

#endif
