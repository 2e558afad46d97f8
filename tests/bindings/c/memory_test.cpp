// Memory that runs out at each allocation of each call: an error, and no undefined behaviour afterwards.
#include <cstring>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "c_scene.h"
#include "failing_memory.h"

namespace sightline::tests::memory_test {
namespace {

/// A scene with some of everything.
struct Filled {
  CScene c;
  sl_node node = {0};
  sl_item item = SL_NO_ITEM;
  sl_mesh mesh = {0};
  sl_material material = {0};
  sl_engine engine = {0};

  Filled() {
    node = c.add_node(c.root, "node");
    item = c.add(node, SL_BOX);
    c.add(c.add_node(node, "below"), SL_SPHERE);
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::uint32_t indices[3] = {0, 1, 2};
    const sl_mesh_data data = {sizeof data, 3, "triangle", corners, nullptr, indices, 3};
    EXPECT_OK(sl_mesh_add(c.scene, &data, &mesh));
    const sl_material_data look = SL_MATERIAL_DATA_INIT;
    EXPECT_OK(sl_material_add(c.scene, &look, &material));
    EXPECT_OK(sl_engine_create(c.scene, nullptr, &engine));
    c.add(node, SL_CYLINDER);  // for a commit
  }
  ~Filled() { EXPECT_OK(sl_engine_destroy(engine)); }
  Filled(const Filled&) = delete;
  Filled& operator=(const Filled&) = delete;
};

/// Runs the call with memory for 0, 1, 2 … allocations, each time on a new scene, until it succeeds.
void run_out(const char* name, const std::function<sl_status(Filled&)>& call) {
  SCOPED_TRACE(name);
  for (int successes = 0; successes < 10'000; ++successes) {
    Filled filled;
    sl_status status = SL_OK;
    bool failed = false;
    {
      const FailingMemory memory(successes);
      status = call(filled);
      failed = memory.failed();
    }
    if (!failed) {
      EXPECT_EQ(status, SL_OK) << sl_last_error();
      return;
    }
    // Some parts of the library turn lack of memory into an error of their own, or do without.
    if (status == SL_ERROR_MEMORY) {
      EXPECT_NE(std::strstr(sl_last_error(), "out of memory"), nullptr) << sl_last_error();
    }
    // Whatever became of it, the scene can be asked and destroyed.
    sl_scene_info info = SL_SCENE_INFO_INIT;
    const sl_status after = sl_scene_get(filled.c.scene, &info);
    EXPECT_TRUE(after == SL_OK || (after == SL_ERROR_MEMORY && status == SL_ERROR_MEMORY)) << after;
  }
  ADD_FAILURE() << "needs ever more memory";
}

const std::string kLong(200, 'n');

TEST(CapiMemory, RunsOutInEdits) {
  const sl_primitive primitive = some_primitive(SL_SNOUT);
  run_out("sl_node_add", [&](Filled& f) {
    sl_node node;
    return sl_node_add(f.c.scene, f.node, kLong.c_str(), nullptr, &node);
  });
  run_out("sl_node_remove", [](Filled& f) { return sl_node_remove(f.c.scene, f.node); });
  run_out("sl_node_set_name", [](Filled& f) { return sl_node_set_name(f.c.scene, f.node, kLong.c_str()); });
  run_out("sl_node_set_attribute",
          [](Filled& f) { return sl_node_set_attribute(f.c.scene, f.node, kLong.c_str(), kLong.c_str()); });
  run_out("sl_node_set_visible", [](Filled& f) { return sl_node_set_visible(f.c.scene, f.node, 0); });
  run_out("sl_item_add_primitive", [&](Filled& f) {
    sl_item item;
    return sl_item_add_primitive(f.c.scene, f.node, &primitive, nullptr, f.material, &item);
  });
  run_out("sl_item_add_mesh", [](Filled& f) {
    sl_item item;
    return sl_item_add_mesh(f.c.scene, f.node, f.mesh, nullptr, f.material, &item);
  });
  run_out("sl_item_remove", [](Filled& f) { return sl_item_remove(f.c.scene, f.item); });
  run_out("sl_material_remove", [](Filled& f) { return sl_material_remove(f.c.scene, f.material); });
  run_out("sl_mesh_remove", [](Filled& f) { return sl_mesh_remove(f.c.scene, f.mesh); });
  run_out("sl_scene_commit", [](Filled& f) { return sl_scene_commit(f.c.scene); });
}

TEST(CapiMemory, RunsOutInEngines) {
  const BothViews view({0, -5, 1}, {0, 0, 0});
  run_out("sl_engine_commit", [](Filled& f) { return sl_engine_commit(f.engine); });
  run_out("sl_engine_rebuild", [](Filled& f) { return sl_engine_rebuild(f.engine); });
  run_out("sl_engine_frame", [&](Filled& f) { return sl_engine_frame(f.engine, &view.c, nullptr, nullptr); });
  run_out("sl_engine_items_in", [&](Filled& f) {
    const double rectangle[4] = {0, 0, 1280, 720};
    std::size_t count;
    return sl_engine_items_in(f.engine, &view.c, rectangle, SL_REGION_WHOLLY, nullptr, 0, &count);
  });
  if (sl_features() & SL_FEATURE_PICKING)
    run_out("sl_engine_pick", [&](Filled& f) {
      sl_pick pick = SL_PICK_INIT;
      return sl_engine_pick(f.engine, &view.c, 640, 360, &pick);
    });
  run_out("sl_engine_configure", [&](Filled& f) {
    sl_engine_config config = SL_ENGINE_CONFIG_INIT;
    config.culling.culler = SL_CULLER_CPU;
    return sl_engine_configure(f.engine, &config);
  });
  run_out("sl_engine_cull_states", [&](Filled& f) {
    std::uint8_t of_item[8];
    sl_cull_states states = SL_CULL_STATES_INIT;
    states.of_item = of_item, states.item_capacity = 8;
    return sl_engine_cull_states(f.engine, &view.c, &states);
  });
  run_out("sl_engine_frame_tile", [&](Filled& f) {
    const sl_image_tile part = {4000, 3000, 100.0, 50.0};
    return sl_engine_frame_tile(f.engine, &view.c, &part, nullptr);
  });
}

TEST(CapiMemory, RunsOutInQueries) {
  run_out("sl_scene_bounds", [](Filled& f) {
    sl_box box;
    return sl_scene_bounds(f.c.scene, f.c.root, 1, &box);
  });
  run_out("sl_scene_find_nodes", [](Filled& f) {
    const sl_condition condition = {nullptr, kLong.c_str()};
    std::size_t count;
    return sl_scene_find_nodes(f.c.scene, f.c.root, &condition, 1, nullptr, 0, &count);
  });
  run_out("sl_node_path", [](Filled& f) {
    sl_text text = {nullptr, 0, 0};
    return sl_node_path(f.c.scene, f.node, &text);
  });
}

/// A change that fails changes nothing, so a box that moved out of sight is still seen after it.
TEST(CapiMemory, RunsOutInChangesOfBoxes) {
  const BothViews view({0, -5, 1}, {0, 0, 0});
  const sl_box near = {{0, 0, 0}, {1, 1, 1}}, far = {{0, -900, 0}, {1, -899, 1}};
  const std::vector<sl_box> all(10'000, near), moved(10'000, far);
  std::vector<std::uint32_t> indices(10'000);
  std::iota(indices.begin(), indices.end(), 0u);
  {
    // This thread's lists grow to their sizes, so that culling needs no memory below.
    sl_box_culler culler = {0};
    std::size_t count = 0;
    ASSERT_OK(sl_box_culler_create(all.data(), all.size(), &culler));
    ASSERT_OK(sl_box_culler_visible(culler, &view.c, nullptr, 0, &count));
    ASSERT_EQ(count, all.size());
    ASSERT_OK(sl_box_culler_destroy(culler));
  }
  for (const bool refit : {false, true}) {
    run_out(refit ? "sl_box_culler_refit" : "sl_box_culler_update_many", [&](Filled&) {
      sl_box_culler culler = {0};
      const sl_status made = sl_box_culler_create(all.data(), all.size(), &culler);
      if (made != SL_OK) return made;
      const sl_status status = refit ? sl_box_culler_refit(culler, moved.data(), moved.size())
                                     : sl_box_culler_update_many(culler, indices.data(), moved.data(), moved.size());
      std::size_t count = 0;
      const sl_status asked = sl_box_culler_visible(culler, &view.c, nullptr, 0, &count);
      if (asked == SL_OK) {
        EXPECT_EQ(count, status == SL_OK ? 0u : all.size());
      }
      EXPECT_OK(sl_box_culler_destroy(culler));
      return status != SL_OK ? status : asked;
    });
  }
}

TEST(CapiMemory, RunsOutInCreation) {
  run_out("sl_scene_create", [](Filled&) {
    sl_scene scene = {0};
    const sl_status status = sl_scene_create(&scene);
    if (status == SL_OK) {
      EXPECT_OK(sl_scene_destroy(scene));
    }
    return status;
  });
  run_out("sl_box_culler_create", [](Filled&) {
    const sl_box boxes[3] = {{{0, 0, 0}, {1, 1, 1}}, {{2, 0, 0}, {3, 1, 1}}, {{4, 0, 0}, {5, 1, 1}}};
    sl_box_culler culler = {0};
    const sl_status status = sl_box_culler_create(boxes, 3, &culler);
    if (status == SL_OK) {
      EXPECT_OK(sl_box_culler_destroy(culler));
    }
    return status;
  });
  run_out("sl_engine_create", [](Filled& f) {
    sl_engine engine = {0};
    const sl_status status = sl_engine_create(f.c.scene, nullptr, &engine);
    if (status == SL_OK) {
      EXPECT_OK(sl_engine_destroy(engine));
    }
    return status;
  });
}

TEST(CapiMemory, AHugeMeshIsAnErrorAndLeavesTheSceneUsable) {
  const Filled f;
  const float corner[3] = {0, 0, 0};
  const std::uint32_t index = 0;
  sl_mesh_data data = {sizeof data, 1, nullptr, corner, nullptr, &index, std::uint64_t(1) << 62};
  sl_mesh mesh = {5};
  EXPECT_EQ(sl_mesh_add(f.c.scene, &data, &mesh), SL_ERROR_ARGUMENT);
  {
    const FailingMemory memory(0);
    data.index_count = 0;
    EXPECT_EQ(sl_mesh_add(f.c.scene, &data, &mesh), SL_ERROR_MEMORY);
  }
  EXPECT_EQ(mesh.id, 5u);
  EXPECT_OK(sl_mesh_add(f.c.scene, &data, &mesh)) << "the arguments did not fit, the scene is as before";
}

TEST(CapiMemory, ABrokenSceneAcceptsNothingButDestruction) {
  sl_scene scene = {0};
  ASSERT_OK(sl_scene_create(&scene));
  sl_scene_info info = SL_SCENE_INFO_INIT;
  ASSERT_OK(sl_scene_get(scene, &info));
  sl_engine engine = {0};
  ASSERT_OK(sl_engine_create(scene, nullptr, &engine));
  {
    const FailingMemory memory(0);
    EXPECT_EQ(sl_node_set_name(scene, info.root, kLong.c_str()), SL_ERROR_MEMORY);
  }
  EXPECT_EQ(sl_scene_get(scene, &info), SL_ERROR_MEMORY);
  EXPECT_EQ(sl_engine_commit(engine), SL_ERROR_MEMORY);
  EXPECT_OK(sl_engine_destroy(engine));
  EXPECT_OK(sl_scene_destroy(scene));
}

}  // namespace
}  // namespace sightline::tests::memory_test
