// Which items of the view volume are written. C++ side: Selection in gpu_pass.h.

#ifdef FOR_IMAGE
#include "screen_box.glsl"

// Set for lines, whose rules are others, and for parts of meshes beside section planes: the first pass of a frame draws all of them.
layout(location = 1) uniform int exempt;
#endif

#if defined(UNOCCLUDED_BEFORE) || defined(UNOCCLUDED_NOW)
#include "occlusion_test.glsl"
#endif

#if defined(SAMPLED)

bool cluster_selected(vec3 low, vec3 high) {
  return true;
}

bool selected(uint record, vec3 low, vec3 high) {
  return exempt != 0 || covers_sample(project_box(low, high));
}

#elif defined(UNOCCLUDED_BEFORE)

bool cluster_selected(vec3 low, vec3 high) {
  return true;
}

bool selected(uint record, vec3 low, vec3 high) {
  return exempt != 0 || (unoccluded_in_frame_before(record) && covers_sample(project_box(low, high)));
}

#elif defined(UNOCCLUDED_NOW)

bool cluster_selected(vec3 low, vec3 high) {
  return exempt == 0 && !occluded(project_box(low, high));
}

// What the first pass has drawn is tested, too, but not drawn again.
bool selected(uint record, vec3 low, vec3 high) {
  if (occluded(project_box(low, high))) return false;
  bool drawn = unoccluded_in_frame_before(record);
  unoccluded_frames[record] = occlusion.this_frame;
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
