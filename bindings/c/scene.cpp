// Versions, scenes and nodes.
#include <memory>
#include <vector>

#include "sightline/bindings/c/internal/objects.h"
#include "sightline/bindings/c/internal/values.h"
#include "sightline/core/find_nodes.h"

using namespace sightline;
using namespace sightline::capi;

// --- versions --------------------------------------------------------------------------------------------------------

int32_t sl_version(void) {
  static_assert(SL_VERSION == SIGHTLINE_PROJECT_VERSION, "sightline.h and project() name different versions");
  return SL_VERSION;
}

uint32_t sl_features(void) {
  uint32_t features = 0;
  if (SIGHTLINE_HAS_GL) features |= SL_FEATURE_DRAWING;
  if (SIGHTLINE_HAS_RAYTRACE) features |= SL_FEATURE_PICKING;
  if (SIGHTLINE_HAS_IMPORTERS) features |= SL_FEATURE_IMPORTING;
  if (SIGHTLINE_HAS_IMAGE) features |= SL_FEATURE_PNG;
  return features;
}

// --- scenes ----------------------------------------------------------------------------------------------------------

sl_status sl_scene_create(sl_scene* scene) {
  return call(__func__, [&] {
    check_result(scene);
    *scene = add_scene(std::make_shared<SceneObject>());
  });
}

sl_status sl_scene_destroy(sl_scene handle) {
  return call(__func__, [&] {
    std::shared_ptr<SceneObject> gone;
    const SceneUse scene(handle, Access::kDestroy);
    gone = remove(handle);
  });
}

sl_status sl_scene_hand_over(sl_scene handle) {
  return call(__func__, [&] {
    const SceneUse scene(handle, Access::kRead);
    if (scene.object().engines > 0) refuse(SL_ERROR_BUSY, "an engine uses the scene: destroy it first");
    hand_over(scene.object());
  });
}

sl_status sl_scene_append(sl_scene to, sl_node parent, sl_scene from) {
  return call(__func__, [&] {
    std::shared_ptr<SceneObject> gone;
    const SceneUse scene(to, Access::kEdit);
    const core::NodeId below = scene.id(parent);
    const SceneUse other(from, Access::kEdit);  // busy when it is the same scene
    if (other.object().committed || other.object().engines > 0)
      refuse(SL_ERROR_ARGUMENT, "the other scene has been committed");
    require(other->first_item(other->root()) == core::kNoItem, "a scene whose root has no items");
    require(scene->node_count() + other->node_count() <= kMostPerScene &&
                scene->mesh_slots() + other->mesh_slots() <= kMostPerScene &&
                scene->material_slots() + other->material_slots() <= kMostPerScene,
            "scenes that have handles enough together");
    (void)scene->append(below, std::move(*other));
    gone = remove(from);
  });
}

sl_status sl_scene_commit(sl_scene handle) {
  return call(__func__, [&] {
    const SceneUse scene(handle, Access::kEdit);
    scene.object().committed = true;
    (void)value_of(scene->commit());
  });
}

sl_status sl_scene_reuse_ids(sl_scene handle, int32_t reuse) {
  return call(__func__, [&] { SceneUse(handle, Access::kEdit)->reuse_ids(reuse != 0); });
}

sl_status sl_scene_get(sl_scene handle, sl_scene_info* info) {
  return call(__func__, [&] {
    const SceneUse scene(handle, Access::kRead);
    write(info, {0, handle_of(scene->root()), scene->node_count(), scene->item_count(), scene->item_slots()});
  });
}

sl_status sl_scene_bounds(sl_scene handle, sl_node top, uint32_t layers, sl_box* bounds) {
  return call(__func__, [&] {
    check_result(bounds);
    const SceneUse scene(handle, Access::kRead);
    *bounds = box_of(scene->bounds(scene.id(top), layers));
  });
}

sl_status sl_scene_find_nodes(sl_scene handle, sl_node top, const sl_condition* conditions, size_t condition_count,
                              sl_node* nodes, size_t capacity, size_t* count) {
  return call(__func__, [&] {
    check_buffer(nodes, capacity);
    check_result(count);
    check_array(conditions, condition_count, kMostListed);
    const SceneUse scene(handle, Access::kRead);
    const core::NodeId below = scene.id(top);
    std::vector<core::NodeCondition> all;
    for (std::size_t i = 0; i < condition_count; ++i)
      all.push_back({std::string(text_or_empty(conditions[i].key)), std::string(text_or_empty(conditions[i].text))});
    write_list(value_of(core::find_nodes(*scene, below, all)).nodes, nodes, capacity, count,
               [](core::NodeId id) { return handle_of(id); });
  });
}

// --- nodes -----------------------------------------------------------------------------------------------------------

sl_status sl_node_add(sl_scene handle, sl_node parent, const char* name, const double transform[16], sl_node* node) {
  return call(__func__, [&] {
    check_result(node);
    const core::Affine parent_from_node = affine_of(transform);
    const SceneUse scene(handle, Access::kEdit);
    const core::NodeId above = scene.id(parent);
    require(scene->node_count() < kMostPerScene, "at most 2^28 nodes");
    *node = handle_of(scene->add_node(above, text_or_empty(name), parent_from_node));
  });
}

namespace {

/// Runs an edit of one node.
template <class Edit>
sl_status edit_node(const char* function, sl_scene handle, sl_node node, const Edit& edit) {
  return call(function, [&] {
    const SceneUse scene(handle, Access::kEdit);
    edit(scene, scene.id(node));
  });
}

}  // namespace

sl_status sl_node_remove(sl_scene handle, sl_node node) {
  return edit_node(__func__, handle, node, [&](const SceneUse& scene, core::NodeId id) {
    require(id != scene->root(), "a node other than the root");
    scene->remove_node(id);
  });
}

sl_status sl_node_set_parent(sl_scene handle, sl_node node, sl_node parent) {
  return edit_node(__func__, handle, node, [&](const SceneUse& scene, core::NodeId id) {
    require(id != scene->root(), "a node other than the root");
    value_of(scene->reparent(id, scene.id(parent)));
  });
}

sl_status sl_node_set_transform(sl_scene handle, sl_node node, const double transform[16]) {
  return edit_node(__func__, handle, node,
                   [&](const SceneUse& scene, core::NodeId id) { scene->set_transform(id, affine_of(transform)); });
}

sl_status sl_node_set_visible(sl_scene handle, sl_node node, int32_t visible) {
  return edit_node(__func__, handle, node,
                   [&](const SceneUse& scene, core::NodeId id) { scene->set_visible(id, visible != 0); });
}

sl_status sl_node_set_layers(sl_scene handle, sl_node node, uint32_t layers) {
  return edit_node(__func__, handle, node,
                   [&](const SceneUse& scene, core::NodeId id) { scene->set_layers(id, layers); });
}

sl_status sl_node_set_material(sl_scene handle, sl_node node, sl_material material) {
  return edit_node(__func__, handle, node, [&](const SceneUse& scene, core::NodeId id) {
    scene->set_material(id, scene.id_or_none(material));
  });
}

sl_status sl_node_set_name(sl_scene handle, sl_node node, const char* name) {
  return edit_node(__func__, handle, node,
                   [&](const SceneUse& scene, core::NodeId id) { scene->set_name(id, text_or_empty(name)); });
}

sl_status sl_node_set_attribute(sl_scene handle, sl_node node, const char* key, const char* value) {
  return edit_node(__func__, handle, node, [&](const SceneUse& scene, core::NodeId id) {
    scene->set_attribute(id, required_text(key), text_or_empty(value));
  });
}

sl_status sl_node_get(sl_scene handle, sl_node node, sl_node_info* info) {
  return call(__func__, [&] {
    const SceneUse scene(handle, Access::kRead);
    const core::NodeId id = scene.id(node);
    sl_node_info found SL_NODE_INFO_INIT;
    found.layers = scene->layers(id);
    found.parent = handle_of(scene->parent(id));
    found.first_child = handle_of(scene->first_child(id));
    found.next_sibling = handle_of(scene->next_sibling(id));
    found.material = handle_of(scene->material(id));
    write_affine(scene->transform(id), found.transform);
    found.attributes = scene->attributes(id).size();
    found.first_item = to_index(scene->first_item(id));
    found.visible = scene->visible(id);
    found.part = handle_of(core::part_of(*scene, id));
    write(info, found);
  });
}

sl_status sl_node_world_transform(sl_scene handle, sl_node node, double world_from_node[16]) {
  return call(__func__, [&] {
    check_result(world_from_node);
    const SceneUse scene(handle, Access::kRead);
    write_affine(scene->world_from_node(scene.id(node)), world_from_node);
  });
}

sl_status sl_node_name(sl_scene handle, sl_node node, sl_text* name) {
  return call(__func__, [&] {
    check_text(name);
    const SceneUse scene(handle, Access::kRead);
    write_text(name, scene->name(scene.id(node)));
  });
}

sl_status sl_node_path(sl_scene handle, sl_node node, sl_text* path) {
  return call(__func__, [&] {
    check_text(path);
    const SceneUse scene(handle, Access::kRead);
    write_text(path, scene->path(scene.id(node)));
  });
}

sl_status sl_node_attribute(sl_scene handle, sl_node node, size_t index, sl_text* key, sl_text* value) {
  return call(__func__, [&] {
    for (const sl_text* text : {key, value})
      if (text) check_text(text);
    const SceneUse scene(handle, Access::kRead);
    const core::Scene::Attributes& attributes = scene->attributes(scene.id(node));
    require(index < attributes.size(), "the index of an attribute");
    if (key) write_text(key, attributes[index].first);
    if (value) write_text(value, attributes[index].second);
  });
}
