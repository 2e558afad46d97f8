/* Which boxes does a camera see? No scene, no GL. */
#include <stdio.h>

#include "sightline/sightline.h"

int main(void) {
  const sl_box boxes[] = {{{-1, 5, -1}, {1, 7, 1}}, {{40, 5, -1}, {42, 7, 1}}, {{0, -9, 0}, {1, -8, 1}}};
  const sl_pose pose = {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}; /* eye, target, up */
  sl_view view = SL_VIEW_INIT;
  sl_box_culler culler;
  uint32_t visible[3];
  size_t count = 0, i;
  if (sl_view_perspective(&pose, 0.9, 1.5, 0.1, HUGE_VAL, &view) != SL_OK ||
      sl_box_culler_create(boxes, 3, &culler) != SL_OK ||
      sl_box_culler_visible(culler, &view, visible, 3, &count) != SL_OK) {
    fprintf(stderr, "%s\n", sl_last_error());
    return 1;
  }
  for (i = 0; i < count; ++i) printf("box %u\n", (unsigned)visible[i]);
  return sl_box_culler_destroy(culler) == SL_OK ? 0 : 1;
}
