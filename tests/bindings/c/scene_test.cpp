// Scenes built in C hold what the same calls in C++ make.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include <glm/gtc/type_ptr.hpp>

#include "c_scene.h"
#include "sightline/core/find_nodes.h"

namespace sightline::tests::scene_test {
namespace {

std::string text_of(const std::function<sl_status(sl_text*)>& ask) {
  sl_text text = {nullptr, 0, 0};
  EXPECT_OK(ask(&text));
  std::string found(text.length, '\0');
  text = {found.data(), found.size() + 1, 0};
  EXPECT_OK(ask(&text));
  return found;
}

TEST(CapiScene, NodesKeepWhatIsSet) {
  const CScene c;
  const sl_node site = c.add_node(c.root, "site", translation(1, 2, 3));
  const sl_node unit = c.add_node(site, "", translation(10, 20, 30));
  const sl_node other = c.add_node(site, "other");
  ASSERT_OK(sl_node_set_attribute(c.scene, unit, "Type", "VALV"));
  ASSERT_OK(sl_node_set_attribute(c.scene, unit, "Bore", "50"));
  ASSERT_OK(sl_node_set_layers(c.scene, unit, SL_LAYER_INSULATION));
  ASSERT_OK(sl_node_set_visible(c.scene, unit, 0));
  const sl_item item = c.add(unit, SL_BOX);

  sl_node_info info = SL_NODE_INFO_INIT;
  ASSERT_OK(sl_node_get(c.scene, unit, &info));
  EXPECT_EQ(info.parent.id, site.id);
  EXPECT_EQ(info.first_child.id, 0u);
  EXPECT_EQ(info.next_sibling.id, other.id);
  EXPECT_EQ(info.layers, SL_LAYER_INSULATION);
  EXPECT_EQ(info.visible, 0);
  EXPECT_EQ(info.material.id, 0u);
  EXPECT_EQ(info.attributes, 2u);
  EXPECT_EQ(info.first_item, item);
  EXPECT_EQ(info.transform[12], 10.0);
  EXPECT_EQ(info.part.id, 0u) << "its site is taken for a file";
  ASSERT_OK(sl_node_get(c.scene, c.add_node(other, ""), &info));
  EXPECT_EQ(info.part.id, other.id);
  double world[16];
  ASSERT_OK(sl_node_world_transform(c.scene, unit, world));
  EXPECT_EQ(world[12], 11.0);
  EXPECT_EQ(world[13], 22.0);
  EXPECT_EQ(world[14], 33.0);
  EXPECT_EQ(world[15], 1.0);

  EXPECT_EQ(text_of([&](sl_text* t) { return sl_node_path(c.scene, unit, t); }), "site/#0");
  EXPECT_EQ(text_of([&](sl_text* t) { return sl_node_attribute(c.scene, unit, 1, t, nullptr); }), "Bore");
  EXPECT_EQ(text_of([&](sl_text* t) { return sl_node_attribute(c.scene, unit, 1, nullptr, t); }), "50");
  EXPECT_EQ(sl_node_attribute(c.scene, unit, 2, nullptr, nullptr), SL_ERROR_ARGUMENT);
  ASSERT_OK(sl_node_set_name(c.scene, unit, "valve"));
  EXPECT_EQ(text_of([&](sl_text* t) { return sl_node_name(c.scene, unit, t); }), "valve");

  ASSERT_OK(sl_node_get(c.scene, c.root, &info));
  EXPECT_EQ(info.parent.id, 0u);
  EXPECT_EQ(info.first_child.id, site.id);
}

TEST(CapiScene, TreesRefuseWhatWouldBreakThem) {
  const CScene c;
  const sl_node a = c.add_node(c.root, "a"), b = c.add_node(a, "b");
  EXPECT_EQ(sl_node_set_parent(c.scene, a, b), SL_ERROR_FAILED);
  EXPECT_NE(std::string(sl_last_error()).find("outside its subtree"), std::string::npos) << sl_last_error();
  EXPECT_EQ(sl_node_set_parent(c.scene, c.root, a), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_node_remove(c.scene, c.root), SL_ERROR_ARGUMENT);
  ASSERT_OK(sl_node_set_parent(c.scene, b, c.root));
  sl_node_info info = SL_NODE_INFO_INIT;
  ASSERT_OK(sl_node_get(c.scene, b, &info));
  EXPECT_EQ(info.parent.id, c.root.id);
  Matrix projective;
  projective.m[3] = 1.0;
  EXPECT_EQ(sl_node_set_transform(c.scene, a, projective.m), SL_ERROR_ARGUMENT);
}

TEST(CapiScene, ItemsOfAllKindsAreThoseOfCpp) {
  const CScene c;
  core::Scene scene;
  const core::Affine map{core::dmat3(0, 2, 0, -2, 0, 0, 0, 0, 2), {1e6, -3, 4}};
  Matrix matrix = translation(1e6, -3, 4);
  matrix.m[0] = matrix.m[5] = 0, matrix.m[1] = 2, matrix.m[4] = -2, matrix.m[10] = 2;
  for (sl_kind kind = 0; kind < 10; ++kind) {
    const sl_node node = c.add_node(c.root);
    const sl_item item = c.add(node, kind, matrix);
    const core::NodeId twin_node = scene.add_node(scene.root());
    const core::ItemId twin = scene.add_primitive(
        twin_node, core::make_primitive(core::Kind(kind), some_parameters()[std::size_t(kind)]), map);
    EXPECT_EQ(item, to_index(twin));
    sl_item_info info = SL_ITEM_INFO_INIT;
    ASSERT_OK(sl_item_get(c.scene, item, &info));
    EXPECT_EQ(info.kind, kind);
    EXPECT_EQ(info.node.id, node.id);
    EXPECT_EQ(info.mesh.id, 0u);
    EXPECT_EQ(info.next_item, SL_NO_ITEM);
    EXPECT_EQ(info.visible, 1);
    EXPECT_TRUE(std::equal(matrix.m, matrix.m + 16, info.placement));
    const core::Primitive primitive = scene.primitive(twin);
    const auto values = core::parameters(primitive);
    EXPECT_TRUE(std::equal(values.begin(), values.end(), info.primitive.of.parameters)) << kind;
    sl_box box;
    ASSERT_OK(sl_scene_bounds(c.scene, node, SL_DEFAULT_LAYERS, &box));
    const core::AabbD expected = scene.bounds(twin_node);
    EXPECT_EQ(glm::make_vec3(box.min), expected.min) << kind;
    EXPECT_EQ(glm::make_vec3(box.max), expected.max) << kind;
  }
  const sl_primitive wrong = {SL_MESH, {{0}}};
  sl_item item = 77;
  EXPECT_EQ(sl_item_add_primitive(c.scene, c.root, &wrong, nullptr, {0}, &item), SL_ERROR_ARGUMENT);
  EXPECT_EQ(item, 77u);
}

TEST(CapiScene, NamedParametersLieInTheirOrder) {
  // The union's structs follow core/primitive.h.
  sl_primitive p = {};
  p.of.snout.top_shear_y = 9;
  EXPECT_EQ(p.of.parameters[8], 9);
  p.of.pyramid.height = 7;
  EXPECT_EQ(p.of.parameters[6], 7);
  p.of.circular_torus.angle = 3;
  EXPECT_EQ(p.of.parameters[2], 3);
  p.of.rectangular_torus.height = 4;
  EXPECT_EQ(p.of.parameters[2], 4);
  for (int kind = 0; kind < 10; ++kind)
    EXPECT_EQ(std::size_t(core::parameter_count(core::Kind(kind))), some_parameters()[std::size_t(kind)].size());
}

TEST(CapiScene, MeshesAndMaterialsComeBack) {
  const CScene c;
  const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, normals[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  const std::uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
  const sl_mesh_data data = {sizeof data, 4, "sheet", positions, normals, indices, 6};
  sl_mesh mesh = {0};
  ASSERT_OK(sl_mesh_add(c.scene, &data, &mesh));
  sl_mesh_data found = SL_MESH_DATA_INIT;
  ASSERT_OK(sl_mesh_get(c.scene, mesh, &found));
  ASSERT_EQ(found.vertex_count, 4u);
  ASSERT_EQ(found.index_count, 6u);
  EXPECT_TRUE(std::equal(positions, positions + 12, found.positions));
  EXPECT_TRUE(std::equal(normals, normals + 12, found.normals));
  EXPECT_TRUE(std::equal(indices, indices + 6, found.indices));
  const float* before = found.positions;
  for (int i = 0; i < 1000; ++i) {
    sl_mesh more = {0};
    ASSERT_OK(sl_mesh_add(c.scene, &data, &more));
  }
  ASSERT_OK(sl_mesh_get(c.scene, mesh, &found));
  EXPECT_EQ(found.positions, before) << "valid as long as the mesh";

  const std::uint32_t beyond[3] = {0, 1, 4};
  sl_mesh_data bad = data;
  bad.indices = beyond, bad.index_count = 3;
  EXPECT_EQ(sl_mesh_add(c.scene, &bad, &mesh), SL_ERROR_FAILED);
  bad.indices = nullptr;
  EXPECT_EQ(sl_mesh_add(c.scene, &bad, &mesh), SL_ERROR_ARGUMENT);

  sl_material_data red = SL_MATERIAL_DATA_INIT;
  red.name = "red", red.code = 4, red.alpha = 0.5f;
  red.colour[0] = 1, red.colour[1] = red.colour[2] = 0;
  sl_material material = {0};
  ASSERT_OK(sl_material_add(c.scene, &red, &material));
  sl_item item = SL_NO_ITEM;
  ASSERT_OK(sl_item_add_mesh(c.scene, c.root, mesh, nullptr, material, &item));
  sl_item_info info = SL_ITEM_INFO_INIT;
  ASSERT_OK(sl_item_get(c.scene, item, &info));
  EXPECT_EQ(info.kind, SL_MESH);
  EXPECT_EQ(info.mesh.id, mesh.id);
  EXPECT_EQ(info.material.id, material.id);
  red.colour[1] = 0.25f;
  ASSERT_OK(sl_material_update(c.scene, material, &red));
  sl_material_data look = SL_MATERIAL_DATA_INIT;
  EXPECT_EQ(text_of([&](sl_text* t) { return sl_material_get(c.scene, material, &look, t); }), "red");
  EXPECT_EQ(look.colour[1], 0.25f);
  EXPECT_EQ(look.alpha, 0.5f);
  EXPECT_EQ(look.code, 4u);
  red.alpha = 1.5f;
  EXPECT_EQ(sl_material_update(c.scene, material, &red), SL_ERROR_ARGUMENT);
  red.alpha = std::nanf("");
  EXPECT_EQ(sl_material_add(c.scene, &red, &material), SL_ERROR_ARGUMENT);
  ASSERT_OK(sl_material_remove(c.scene, material));
  ASSERT_OK(sl_item_get(c.scene, item, &info));
  EXPECT_EQ(info.material.id, 0u);
}

TEST(CapiScene, CommitNamesWhatIsNotFinite) {
  const CScene c;
  const sl_node node = c.add_node(c.root, "pump", translation(std::nan(""), 0, 0));
  c.add(node, SL_SPHERE);
  EXPECT_EQ(sl_scene_commit(c.scene), SL_ERROR_FAILED);
  EXPECT_NE(std::string(sl_last_error()).find("\"pump\""), std::string::npos) << sl_last_error();
  sl_engine engine = {55};
  EXPECT_EQ(sl_engine_create(c.scene, nullptr, &engine), SL_ERROR_FAILED);
  EXPECT_EQ(engine.id, 55u);
  ASSERT_OK(sl_node_set_transform(c.scene, node, nullptr));
  EXPECT_OK(sl_scene_commit(c.scene));
}

TEST(CapiScene, FindsNodesAsCppDoes) {
  const CScene c;
  const sl_node a = c.add_node(c.root, "Pump 1"), b = c.add_node(a, "pump 2"), other = c.add_node(c.root, "tank");
  ASSERT_OK(sl_node_set_attribute(c.scene, other, "Type", "PUMP"));
  const sl_condition any = {nullptr, "pump"}, of_type = {"Type", "pump"};
  sl_node found[8];
  std::size_t count = 99;
  ASSERT_OK(sl_scene_find_nodes(c.scene, c.root, &any, 1, found, 8, &count));
  ASSERT_EQ(count, 1u) << "a value before words";
  EXPECT_EQ(found[0].id, other.id);
  const auto find = [&](const char* text) {
    const sl_condition one = {nullptr, text};
    EXPECT_OK(sl_scene_find_nodes(c.scene, c.root, &one, 1, found, 8, &count));
    return count;
  };
  ASSERT_EQ(find("pump?*"), 2u);
  EXPECT_EQ(found[0].id, a.id);
  EXPECT_EQ(found[1].id, b.id);
  EXPECT_EQ(find("pump 1/pump 2"), 1u);
  EXPECT_EQ(find("Name=pump 1"), 1u);
  EXPECT_EQ(find("type=pump"), 1u);
  EXPECT_EQ(find("um"), 0u);
  const sl_condition wrong = {nullptr, "re:("};
  EXPECT_EQ(sl_scene_find_nodes(c.scene, c.root, &wrong, 1, found, 8, &count), SL_ERROR_FAILED);
  ASSERT_OK(sl_scene_find_nodes(c.scene, c.root, &of_type, 1, found, 8, &count));
  ASSERT_EQ(count, 1u);
  EXPECT_EQ(found[0].id, other.id);
  const sl_condition all = {nullptr, "re:pump|tank"};
  ASSERT_OK(sl_scene_find_nodes(c.scene, c.root, &all, 1, nullptr, 0, &count));
  EXPECT_EQ(count, 3u);
  EXPECT_EQ(sl_scene_find_nodes(c.scene, c.root, &any, 1, nullptr, 1, &count), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_scene_find_nodes(c.scene, c.root, nullptr, 1, found, 8, &count), SL_ERROR_ARGUMENT);
}

TEST(CapiScene, ItemsAreListedAndEdited) {
  const CScene c;
  const sl_item first = c.add(c.root, SL_BOX), second = c.add(c.root, SL_SPHERE), third = c.add(c.root, SL_LINE);
  ASSERT_OK(sl_item_remove(c.scene, second));
  sl_item_info info = SL_ITEM_INFO_INIT;
  ASSERT_OK(sl_item_get(c.scene, first, &info));
  EXPECT_EQ(info.next_item, third);
  ASSERT_OK(sl_item_set_visible(c.scene, first, 0));
  ASSERT_OK(sl_item_set_placement(c.scene, first, translation(7, 8, 9).m));
  ASSERT_OK(sl_item_get(c.scene, first, &info));
  EXPECT_EQ(info.visible, 0);
  EXPECT_EQ(info.placement[13], 8.0);
  sl_scene_info scene = SL_SCENE_INFO_INIT;
  ASSERT_OK(sl_scene_get(c.scene, &scene));
  EXPECT_EQ(scene.items, 2u);
  EXPECT_EQ(scene.item_slots, 3u);
}

}  // namespace
}  // namespace sightline::tests::scene_test
