/* The header in C99: a program that builds a scene, culls, picks and meets errors, all without GL. */
#include <stdio.h>
#include <string.h>

#include "sightline/sightline.h"

static int failures = 0;

static void expect(int holds, const char* what) {
  if (holds) return;
  fprintf(stderr, "c_program: expected %s; last error: %s\n", what, sl_last_error());
  ++failures;
}

static void cull_boxes(void) {
  sl_box boxes[100];
  sl_box_culler culler;
  sl_view view = SL_VIEW_INIT;
  const sl_pose pose = {{10, -10, 0.5}, {10, 0, 0.5}, {0, 0, 1}};
  uint32_t visible[100];
  size_t count = 0, i;
  for (i = 0; i < 100; ++i) {
    const sl_box box = {{(double)i, 0, 0}, {(double)i + 0.5, 1, 1}};
    boxes[i] = box;
  }
  expect(sl_box_culler_create(boxes, 100, &culler) == SL_OK, "a culler");
  expect(sl_view_perspective(&pose, 0.5, 1.0, 0.1, HUGE_VAL, &view) == SL_OK, "a view");
  expect(sl_box_culler_visible(culler, &view, visible, 100, &count) == SL_OK, "to cull");
  expect(count >= 5 && count <= 7, "5 to 7 visible boxes");
  expect(sl_box_culler_destroy(culler) == SL_OK, "to destroy the culler");
  expect(sl_box_culler_destroy(culler) == SL_ERROR_HANDLE, "an error the second time");
}

static void build_and_pick(void) {
  sl_scene scene = {0};
  sl_scene_info scene_info = SL_SCENE_INFO_INIT;
  sl_node node = {0};
  sl_material_data red = SL_MATERIAL_DATA_INIT;
  sl_material material = {0};
  const sl_material inherited = {0};
  sl_primitive cylinder = {SL_CYLINDER, {{0}}};
  const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const uint32_t indices[] = {0, 1, 2};
  sl_mesh_data triangle = SL_MESH_DATA_INIT;
  sl_mesh mesh = {0};
  sl_item item = SL_NO_ITEM, other = SL_NO_ITEM;
  double placement[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1};
  sl_engine_config config = SL_ENGINE_CONFIG_INIT;
  sl_engine engine = {0};
  sl_ray ray = SL_RAY_INIT;
  sl_pick pick = SL_PICK_INIT;
  sl_frame_report report = SL_FRAME_REPORT_INIT;
  sl_view view = SL_VIEW_INIT;
  sl_controller_info controller_info = SL_CONTROLLER_INFO_INIT;
  sl_loss_report loss = SL_LOSS_REPORT_INIT;
  sl_cull_states states = SL_CULL_STATES_INIT;
  uint8_t of_item[2];
  sl_box bounds;
  char path[32];
  sl_text text = {NULL, 0, 0};

  expect(sl_scene_create(&scene) == SL_OK, "a scene");
  expect(sl_scene_get(scene, &scene_info) == SL_OK, "its info");
  expect(sl_node_add(scene, scene_info.root, "pipes", NULL, &node) == SL_OK, "a node");
  red.colour[0] = 1.0f;
  red.colour[1] = red.colour[2] = 0.0f;
  expect(sl_material_add(scene, &red, &material) == SL_OK, "a material");
  cylinder.of.cylinder.radius = 0.5f;
  cylinder.of.cylinder.height = 4.0f;
  expect(sl_item_add_primitive(scene, node, &cylinder, NULL, material, &item) == SL_OK, "a cylinder");
  triangle.vertex_count = 3;
  triangle.positions = corners;
  triangle.indices = indices;
  triangle.index_count = 3;
  expect(sl_mesh_add(scene, &triangle, &mesh) == SL_OK, "a mesh");
  expect(sl_item_add_mesh(scene, node, mesh, placement, inherited, &other) == SL_OK, "an instance of it");
  text.data = path;
  text.capacity = sizeof path;
  expect(sl_node_path(scene, node, &text) == SL_OK && strcmp(path, "pipes") == 0, "the node's path");

  config.width = 320;
  config.height = 240;
  expect(sl_engine_create(scene, &config, &engine) == SL_OK, "an engine");
  expect(sl_scene_bounds(scene, scene_info.root, SL_DEFAULT_LAYERS, &bounds) == SL_OK, "bounds");
  expect(sl_view_fit(&bounds, NULL, 0.9, 320.0 / 240.0, &view) == SL_OK, "a view");
  expect(sl_engine_frame(engine, &view, NULL, &report) == SL_OK && report.visible == 2, "two visible items");
  states.of_item = of_item;
  states.item_capacity = 2;
  expect(sl_engine_cull_states(engine, &view, &states) == SL_OK && states.item_count == 2, "two states");
  expect(of_item[item] != SL_CULL_OUTSIDE && of_item[other] != SL_CULL_OUTSIDE, "the view to hold both");
  expect(sl_engine_loss(engine, &view, &loss) == SL_OK && loss.items == 0, "nothing to be left out");
  expect(sl_engine_get_config(engine, &config) == SL_OK && config.width == 320, "the settings");
  config.losses.budget_ms = 5.0;
  expect(sl_engine_configure(engine, &config) == SL_OK, "another budget");
  expect(sl_engine_get_controller(engine, &controller_info) == SL_OK && !controller_info.there, "no hybrid");
  if (sl_features() & SL_FEATURE_PICKING) {
    ray.origin[1] = -10.0;
    expect(sl_engine_pick_ray(engine, &ray, &pick) == SL_OK, "to pick");
    expect(pick.item == item && pick.node.id == node.id && pick.t == 9.5, "the cylinder at 9.5 m");
  }
  expect(sl_engine_destroy(engine) == SL_OK, "to destroy the engine");
  expect(sl_scene_destroy(scene) == SL_OK, "to destroy the scene");
  expect(sl_node_remove(scene, node) == SL_ERROR_HANDLE, "an error with a dead scene");
  expect(strcmp(sl_last_error(), "sl_node_remove: scene: stale handle") == 0, "its message");
}

int main(void) {
  expect(sl_version() == SL_VERSION, "the header's version");
  cull_boxes();
  build_and_pick();
  return failures != 0;
}
