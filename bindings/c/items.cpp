// Meshes, materials and items.
#include <vector>

#include "sightline/bindings/c/internal/objects.h"
#include "sightline/bindings/c/internal/values.h"
#include "sightline/core/mesh_extras.h"
#include "sightline/core/primitive.h"

using namespace sightline;
using namespace sightline::capi;

namespace {

std::vector<core::vec3> vectors_of(const float* values, std::size_t count) {
  static_assert(sizeof(core::vec3) == 3 * sizeof(float));
  std::vector<core::vec3> vectors(count);
  if (count > 0) std::memcpy(vectors.data(), values, count * sizeof(core::vec3));
  return vectors;
}

core::Mesh mesh_of(const sl_mesh_data* from) {
  const sl_mesh_data data = read(from, sl_mesh_data SL_MESH_DATA_INIT);
  check_array(data.positions, data.vertex_count, core::kNone);
  check_array(data.indices, data.index_count, core::kNone);
  core::Mesh mesh;
  mesh.name = text_or_empty(data.name);
  mesh.positions = vectors_of(data.positions, data.vertex_count);
  if (data.normals) mesh.normals = vectors_of(data.normals, data.vertex_count);
  if (data.index_count > 0) mesh.indices.assign(data.indices, data.indices + data.index_count);
  return mesh;
}

bool in_use(const core::Scene& scene, core::MeshId mesh) {
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (scene.contains_item(item) && int(scene.kind(item)) >= core::kPrimitiveKindCount && scene.mesh_of(item) == mesh)
      return true;
  return false;
}

core::Material material_of(const sl_material_data* from) {
  const sl_material_data data = read(from, sl_material_data SL_MATERIAL_DATA_INIT);
  for (const float value : {data.colour[0], data.colour[1], data.colour[2], data.alpha})
    require(value >= 0.0f && value <= 1.0f, "colours and alpha from 0 to 1");
  return {
      std::string(text_or_empty(data.name)), {data.colour[0], data.colour[1], data.colour[2]}, data.alpha, data.code};
}

core::Primitive primitive_of(const sl_primitive* from) {
  require(from != nullptr, "a primitive, found null");
  const auto kind = enum_of<core::Kind>(from->kind, core::kPrimitiveKindCount, "kind of a primitive");
  return core::make_primitive(kind, std::span(from->of.parameters));
}

/// Runs an edit of one item.
template <class Edit>
sl_status edit_item(const char* function, sl_scene handle, sl_item item, const Edit& edit) {
  return call(function, [&] {
    const SceneUse scene(handle, Access::kEdit);
    edit(scene, scene.id(item));
  });
}

}  // namespace

// --- meshes ----------------------------------------------------------------------------------------------------------

sl_status sl_mesh_add(sl_scene handle, const sl_mesh_data* data, sl_mesh* mesh) {
  return call(__func__, [&] {
    check_result(mesh);
    core::Mesh made = mesh_of(data);
    const SceneUse scene(handle, Access::kEdit);
    require(scene->mesh_slots() < kMostPerScene, "at most 2^28 meshes");
    *mesh = handle_of(value_of(scene->add_mesh(std::move(made))));
  });
}

sl_status sl_mesh_get(sl_scene handle, sl_mesh mesh, sl_mesh_data* data) {
  return call(__func__, [&] {
    const SceneUse scene(handle, Access::kRead);
    const core::Mesh& found = scene->mesh(scene.id(mesh));
    const auto floats = [](const std::vector<core::vec3>& vectors) {
      return vectors.empty() ? nullptr : &vectors.front().x;
    };
    write(data, {0, std::uint32_t(found.positions.size()), nullptr, floats(found.positions), floats(found.normals),
                 found.indices.empty() ? nullptr : found.indices.data(), found.indices.size()});
  });
}

sl_status sl_mesh_get_surface(sl_scene handle, sl_mesh mesh, uint32_t triangle, sl_mesh_surface* surface) {
  return call(__func__, [&] {
    const SceneUse scene(handle, Access::kRead);
    const core::Mesh& of = scene->mesh(scene.id(mesh));
    if (triangle >= of.indices.size() / 3) refuse(SL_ERROR_ARGUMENT, "triangle: the mesh has fewer");
    const std::uint32_t face = core::surface_of(of, triangle);
    const core::MeshSurface s = face == core::kNone ? core::MeshSurface() : core::surfaces_stored_with(of)[face];
    write(surface, {0,
                    std::int32_t(s.kind),
                    {s.origin.x, s.origin.y, s.origin.z},
                    {s.axis.x, s.axis.y, s.axis.z},
                    s.radius,
                    s.tube_radius,
                    s.slope});
  });
}

sl_status sl_mesh_remove(sl_scene handle, sl_mesh mesh) {
  return call(__func__, [&] {
    const SceneUse scene(handle, Access::kEdit);
    const core::MeshId id = scene.id(mesh);
    if (in_use(*scene, id)) refuse(SL_ERROR_BUSY, "an item uses the mesh: remove it first");
    scene->remove_mesh(id);
  });
}

// --- materials -------------------------------------------------------------------------------------------------------

sl_status sl_material_add(sl_scene handle, const sl_material_data* data, sl_material* material) {
  return call(__func__, [&] {
    check_result(material);
    core::Material made = material_of(data);
    const SceneUse scene(handle, Access::kEdit);
    require(scene->material_slots() < kMostPerScene, "at most 2^28 materials");
    *material = handle_of(scene->add_material(std::move(made)));
  });
}

sl_status sl_material_update(sl_scene handle, sl_material material, const sl_material_data* data) {
  return call(__func__, [&] {
    core::Material made = material_of(data);
    const SceneUse scene(handle, Access::kEdit);
    scene->update_material(scene.id(material), std::move(made));
  });
}

sl_status sl_material_get(sl_scene handle, sl_material material, sl_material_data* data, sl_text* name) {
  return call(__func__, [&] {
    if (name) check_text(name);
    const SceneUse scene(handle, Access::kRead);
    const core::Material& found = scene->material(scene.id(material));
    write(data, {0, found.code, nullptr, {found.colour.x, found.colour.y, found.colour.z}, found.alpha});
    if (name) write_text(name, found.name);
  });
}

sl_status sl_material_remove(sl_scene handle, sl_material material) {
  return call(__func__, [&] {
    const SceneUse scene(handle, Access::kEdit);
    scene->remove_material(scene.id(material));
  });
}

// --- items -----------------------------------------------------------------------------------------------------------

sl_status sl_item_add_primitive(sl_scene handle, sl_node node, const sl_primitive* primitive,
                                const double placement[16], sl_material material, sl_item* item) {
  return call(__func__, [&] {
    check_result(item);
    const core::Primitive made = primitive_of(primitive);
    const SceneUse scene(handle, Access::kEdit);
    *item = to_index(scene->add_primitive(scene.id(node), made, affine_of(placement), scene.id_or_none(material)));
  });
}

sl_status sl_item_add_mesh(sl_scene handle, sl_node node, sl_mesh mesh, const double placement[16],
                           sl_material material, sl_item* item) {
  return call(__func__, [&] {
    check_result(item);
    const SceneUse scene(handle, Access::kEdit);
    *item = to_index(
        scene->add_mesh_instance(scene.id(node), scene.id(mesh), affine_of(placement), scene.id_or_none(material)));
  });
}

sl_status sl_item_remove(sl_scene handle, sl_item item) {
  return edit_item(__func__, handle, item, [&](const SceneUse& scene, core::ItemId id) { scene->remove_item(id); });
}

sl_status sl_item_set_placement(sl_scene handle, sl_item item, const double placement[16]) {
  return edit_item(__func__, handle, item,
                   [&](const SceneUse& scene, core::ItemId id) { scene->set_placement(id, affine_of(placement)); });
}

sl_status sl_item_set_visible(sl_scene handle, sl_item item, int32_t visible) {
  return edit_item(__func__, handle, item,
                   [&](const SceneUse& scene, core::ItemId id) { scene->set_visible(id, visible != 0); });
}

sl_status sl_item_set_material(sl_scene handle, sl_item item, sl_material material) {
  return edit_item(__func__, handle, item, [&](const SceneUse& scene, core::ItemId id) {
    scene->set_material(id, scene.id_or_none(material));
  });
}

sl_status sl_item_get(sl_scene handle, sl_item item, sl_item_info* info) {
  return call(__func__, [&] {
    const SceneUse scene(handle, Access::kRead);
    const core::ItemId id = scene.id(item);
    sl_item_info found SL_ITEM_INFO_INIT;
    found.kind = found.primitive.kind = sl_kind(scene->kind(id));
    found.node = handle_of(scene->node_of(id));
    found.material = handle_of(scene->item_material(id));
    write_affine(scene->placement(id), found.placement);
    if (found.kind < core::kPrimitiveKindCount) {
      const core::Primitive primitive = scene->primitive(id);
      const auto values = core::parameters(primitive);
      std::copy(values.begin(), values.end(), found.primitive.of.parameters);
    } else {
      found.mesh = handle_of(scene->mesh_of(id));
    }
    found.next_item = to_index(scene->next_item(id));
    found.visible = scene->item_visible(id);
    write(info, found);
  });
}
