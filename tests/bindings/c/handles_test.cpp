// Handles that are null, stale, destroyed twice or of another kind, other threads, and lifetimes.
#include <functional>
#include <random>
#include <string>
#include <thread>

#include "c_scene.h"

namespace sightline::tests::handles_test {
namespace {

sl_status on_another_thread(const std::function<sl_status()>& call) {
  sl_status status = SL_OK;
  std::thread([&] { status = call(); }).join();
  return status;
}

TEST(CapiHandles, NullHandlesAreErrors) {
  sl_scene_info info = SL_SCENE_INFO_INIT;
  EXPECT_EQ(sl_scene_get({0}, &info), SL_ERROR_HANDLE);
  EXPECT_STREQ(sl_last_error(), "sl_scene_get: scene: null handle");
  EXPECT_EQ(sl_scene_destroy({0}), SL_ERROR_HANDLE);
  EXPECT_EQ(sl_engine_destroy({0}), SL_ERROR_HANDLE);
  EXPECT_EQ(sl_box_culler_destroy({0}), SL_ERROR_HANDLE);
  const CScene c;
  sl_node node = {123};
  EXPECT_EQ(sl_node_add(c.scene, {0}, "name", nullptr, &node), SL_ERROR_HANDLE);
  EXPECT_EQ(node.id, 123u) << "a failed call leaves its result as it was";
}

TEST(CapiHandles, ADestroyedHandleStaysDead) {
  sl_scene scene = {0};
  ASSERT_OK(sl_scene_create(&scene));
  ASSERT_OK(sl_scene_destroy(scene));
  EXPECT_EQ(sl_scene_destroy(scene), SL_ERROR_HANDLE);
  EXPECT_STREQ(sl_last_error(), "sl_scene_destroy: scene: stale handle");
  for (int i = 0; i < 1000; ++i) {
    sl_scene other = {0};
    ASSERT_OK(sl_scene_create(&other));
    ASSERT_NE(other.id, scene.id);
    ASSERT_EQ(sl_scene_commit(scene), SL_ERROR_HANDLE);
    ASSERT_OK(sl_scene_destroy(other));
  }
}

TEST(CapiHandles, OtherKindsAreErrors) {
  const CScene c;
  sl_engine engine = {0};
  ASSERT_OK(sl_engine_create(c.scene, nullptr, &engine));
  EXPECT_EQ(sl_engine_commit({c.scene.id}), SL_ERROR_HANDLE);
  EXPECT_STREQ(sl_last_error(), "sl_engine_commit: engine: found the handle of another kind: scene");
  EXPECT_EQ(sl_scene_commit({engine.id}), SL_ERROR_HANDLE);
  EXPECT_EQ(sl_box_culler_destroy({c.root.id}), SL_ERROR_HANDLE);
  EXPECT_EQ(sl_node_remove(c.scene, {c.scene.id}), SL_ERROR_HANDLE);
  const sl_material_data data = SL_MATERIAL_DATA_INIT;
  sl_material material = {0};
  ASSERT_OK(sl_material_add(c.scene, &data, &material));
  EXPECT_EQ(sl_mesh_remove(c.scene, {material.id}), SL_ERROR_HANDLE);
  EXPECT_EQ(sl_material_remove(c.scene, {c.root.id}), SL_ERROR_HANDLE);
  EXPECT_EQ(sl_node_set_material(c.scene, c.root, {c.root.id}), SL_ERROR_HANDLE);
  EXPECT_OK(sl_engine_destroy(engine));
}

TEST(CapiHandles, NodesMeshesMaterialsAndItemsGoStale) {
  const CScene c;
  const sl_node node = c.add_node(c.root), below = c.add_node(node);
  const sl_item item = c.add(below, SL_SPHERE);
  ASSERT_OK(sl_node_remove(c.scene, node));
  for (const sl_node gone : {node, below}) {
    EXPECT_EQ(sl_node_set_visible(c.scene, gone, 1), SL_ERROR_HANDLE);
    EXPECT_EQ(sl_node_remove(c.scene, gone), SL_ERROR_HANDLE);
  }
  EXPECT_EQ(sl_item_remove(c.scene, item), SL_ERROR_HANDLE);
  EXPECT_STREQ(sl_last_error(), "sl_item_remove: item 0: not in the scene");
  const sl_node reuses_its_place = c.add_node(c.root);
  EXPECT_NE(reuses_its_place.id, node.id);
  EXPECT_EQ(sl_node_set_visible(c.scene, node, 1), SL_ERROR_HANDLE);
  EXPECT_EQ(sl_item_add_primitive(c.scene, node, nullptr, nullptr, {0}, nullptr), SL_ERROR_ARGUMENT);

  const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::uint32_t indices[3] = {0, 1, 2};
  const sl_mesh_data data = {sizeof data, 3, "triangle", corners, nullptr, indices, 3};
  sl_mesh mesh = {0};
  ASSERT_OK(sl_mesh_add(c.scene, &data, &mesh));
  sl_item instance = SL_NO_ITEM;
  ASSERT_OK(sl_item_add_mesh(c.scene, c.root, mesh, nullptr, {0}, &instance));
  EXPECT_EQ(sl_mesh_remove(c.scene, mesh), SL_ERROR_BUSY);
  ASSERT_OK(sl_item_remove(c.scene, instance));
  ASSERT_OK(sl_mesh_remove(c.scene, mesh));
  EXPECT_EQ(sl_mesh_remove(c.scene, mesh), SL_ERROR_HANDLE);
  EXPECT_EQ(sl_item_add_mesh(c.scene, c.root, mesh, nullptr, {0}, &instance), SL_ERROR_HANDLE);
}

TEST(CapiHandles, AnyNumberIsSafe) {
  constexpr unsigned kSeed = 17;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  const CScene c;
  sl_engine engine = {0};
  ASSERT_OK(sl_engine_create(c.scene, nullptr, &engine));
  const std::uint64_t live[] = {c.scene.id, c.root.id, engine.id};
  for (int i = 0; i < 20'000; ++i) {
    std::uint64_t id = random();
    if (i % 2 == 0) id = live[random() % 3] ^ std::uint64_t(1) << random() % 64;  // one bit beside a live one
    ASSERT_EQ(sl_scene_commit({id}), SL_ERROR_HANDLE);
    ASSERT_EQ(sl_engine_commit({id}), SL_ERROR_HANDLE);
    ASSERT_EQ(sl_box_culler_destroy({id}), SL_ERROR_HANDLE);
    ASSERT_EQ(sl_node_remove(c.scene, {id}), SL_ERROR_HANDLE);
    ASSERT_EQ(sl_mesh_remove(c.scene, {id}), SL_ERROR_HANDLE);
    ASSERT_EQ(sl_material_remove(c.scene, {id}), SL_ERROR_HANDLE);
  }
  EXPECT_OK(sl_engine_destroy(engine));
}

TEST(CapiHandles, OtherThreadsAreRefused) {
  const CScene c;
  sl_engine engine = {0};
  ASSERT_OK(sl_engine_create(c.scene, nullptr, &engine));
  EXPECT_EQ(on_another_thread([&] { return sl_scene_commit(c.scene); }), SL_ERROR_THREAD);
  EXPECT_EQ(on_another_thread([&] { return sl_scene_destroy(c.scene); }), SL_ERROR_THREAD);
  EXPECT_EQ(on_another_thread([&] { return sl_engine_commit(engine); }), SL_ERROR_THREAD);
  EXPECT_EQ(on_another_thread([&] { return sl_engine_destroy(engine); }), SL_ERROR_THREAD);
  EXPECT_EQ(sl_scene_hand_over(c.scene), SL_ERROR_BUSY) << "an engine uses it";
  EXPECT_OK(sl_engine_destroy(engine));
  EXPECT_EQ(on_another_thread([&] { return sl_scene_hand_over(c.scene); }), SL_ERROR_THREAD);
}

TEST(CapiHandles, AWorkerHandsItsSceneOver) {
  sl_scene scene = {0};
  std::thread([&] {
    EXPECT_OK(sl_scene_create(&scene));
    sl_scene_info info = SL_SCENE_INFO_INIT;
    EXPECT_OK(sl_scene_get(scene, &info));
    sl_node node = {0};
    EXPECT_OK(sl_node_add(scene, info.root, "by the worker", nullptr, &node));
    EXPECT_OK(sl_scene_hand_over(scene));
  }).join();
  const CScene c;
  ASSERT_OK(sl_scene_append(c.scene, c.root, scene));
  EXPECT_EQ(sl_scene_destroy(scene), SL_ERROR_HANDLE) << "append() has destroyed it";
  sl_scene_info info = SL_SCENE_INFO_INIT;
  ASSERT_OK(sl_scene_get(c.scene, &info));
  EXPECT_EQ(info.nodes, 2u);
}

TEST(CapiHandles, AThreadThatHasHandedOverIsRefused) {
  sl_scene scene = {0};
  ASSERT_OK(sl_scene_create(&scene));
  ASSERT_OK(sl_scene_hand_over(scene));
  EXPECT_EQ(on_another_thread([&] { return sl_scene_commit(scene); }), SL_OK);
  EXPECT_EQ(sl_scene_commit(scene), SL_ERROR_THREAD);
  EXPECT_EQ(on_another_thread([&] { return sl_scene_commit(scene); }), SL_ERROR_THREAD) << "a third thread";
}

TEST(CapiHandles, AnEngineKeepsItsSceneAlive) {
  sl_scene scene = {0};
  ASSERT_OK(sl_scene_create(&scene));
  sl_scene_info info = SL_SCENE_INFO_INIT;
  ASSERT_OK(sl_scene_get(scene, &info));
  const sl_primitive sphere = some_primitive(SL_SPHERE);
  sl_item item = SL_NO_ITEM;
  ASSERT_OK(sl_item_add_primitive(scene, info.root, &sphere, nullptr, {0}, &item));
  sl_engine first = {0}, second = {0};
  ASSERT_OK(sl_engine_create(scene, nullptr, &first));
  ASSERT_OK(sl_engine_create(scene, nullptr, &second));
  ASSERT_OK(sl_scene_destroy(scene));
  EXPECT_EQ(sl_scene_get(scene, &info), SL_ERROR_HANDLE);
  const BothViews view({0, -5, 0}, {0, 0, 0});
  for (const sl_engine engine : {first, second}) {
    sl_frame_report report = SL_FRAME_REPORT_INIT;
    ASSERT_OK(sl_engine_frame(engine, &view.c, nullptr, &report));
    EXPECT_EQ(report.visible, 1);
    ASSERT_OK(sl_engine_commit(engine));
    ASSERT_OK(sl_engine_destroy(engine));
    EXPECT_EQ(sl_engine_destroy(engine), SL_ERROR_HANDLE);
  }
}

TEST(CapiHandles, AppendRefusesWhatCannotBeMoved) {
  const CScene c, committed, with_items;
  ASSERT_OK(sl_scene_commit(committed.scene));
  with_items.add(with_items.root, SL_BOX);
  EXPECT_EQ(sl_scene_append(c.scene, c.root, committed.scene), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_scene_append(c.scene, c.root, with_items.scene), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_scene_append(c.scene, c.root, c.scene), SL_ERROR_BUSY);
  EXPECT_EQ(sl_scene_append(c.scene, {with_items.scene.id}, with_items.scene), SL_ERROR_HANDLE);
  EXPECT_OK(sl_scene_commit(c.scene)) << "still in order";
}

TEST(CapiHandles, EachThreadHasItsMessage) {
  EXPECT_EQ(sl_scene_destroy({0}), SL_ERROR_HANDLE);
  std::string there = "not asked";
  std::thread([&] { there = sl_last_error(); }).join();
  EXPECT_EQ(there, "");
  EXPECT_STREQ(sl_last_error(), "sl_scene_destroy: scene: null handle");
}

}  // namespace
}  // namespace sightline::tests::handles_test
