/* The smallest program in C that embeds Sightline: read a model, cull and draw one view of it, pick what is in the
 * middle, save the image.
 *   c_embed MODEL OUT.png */
#include <stdio.h>
#include <stdlib.h>

#include "sightline/sightline.h"

enum { WIDTH = 640, HEIGHT = 480 };

/* Ends the program where a call fails. */
static void must(sl_status status) {
  if (status == SL_OK) return;
  fprintf(stderr, "%s\n", sl_last_error());
  exit(1);
}

static int32_t show_progress(double share, void* user) {
  (void)user;
  fprintf(stderr, "\r%3.0f %%%s", 100.0 * share, share < 1.0 ? "" : "\n");
  return 1; /* 0 cancels */
}

int main(int argc, char** argv) {
  static uint8_t rgb[3 * WIDTH * HEIGHT];
  const char* paths[1];
  char name[256];
  sl_text path = {name, sizeof name, 0};
  sl_scene scene;
  sl_scene_info scene_info = SL_SCENE_INFO_INIT;
  sl_import_options options = SL_IMPORT_OPTIONS_INIT;
  sl_engine_config config = SL_ENGINE_CONFIG_INIT;
  sl_engine engine;
  sl_box bounds;
  sl_view view = SL_VIEW_INIT;
  sl_frame_report report = SL_FRAME_REPORT_INIT;
  sl_pick pick = SL_PICK_INIT;

  if (argc != 3) {
    fprintf(stderr, "usage: c_embed MODEL OUT.png\n");
    return 2;
  }
  paths[0] = argv[1];
  must(sl_scene_create(&scene));
  must(sl_scene_get(scene, &scene_info));
  options.progress = show_progress;
  must(sl_import(scene, scene_info.root, paths, 1, &options, NULL, NULL));

  config.draw = 1;
  config.width = WIDTH;
  config.height = HEIGHT;
  must(sl_engine_create(scene, &config, &engine));
  must(sl_scene_bounds(scene, scene_info.root, SL_DEFAULT_LAYERS, &bounds));
  must(sl_view_fit(&bounds, NULL, 0.9, (double)WIDTH / HEIGHT, &view));
  must(sl_engine_frame(engine, &view, NULL, &report));
  printf("%lld items visible, culled in %.3f ms\n", (long long)report.visible, report.cull_ms);

  must(sl_engine_pick(engine, &view, 0.5 * WIDTH, 0.5 * HEIGHT, &pick));
  if (pick.item == SL_NO_ITEM) {
    printf("nothing in the middle\n");
  } else {
    must(sl_node_path(scene, pick.node, &path));
    printf("item %u of %s in the middle\n", (unsigned)pick.item, name);
  }

  must(sl_engine_read_colour(engine, rgb, sizeof rgb));
  must(sl_write_png(argv[2], WIDTH, HEIGHT, rgb));
  must(sl_engine_destroy(engine));
  must(sl_scene_destroy(scene));
  return 0;
}
